"""What importing perception costs."""

import subprocess
import sys


def test_importing_it_does_not_import_torch() -> None:
    code = "import sys, perception; print('torch' in sys.modules)"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.stdout.strip() == "False", result.stderr
