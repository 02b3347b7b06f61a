"""docs/authoring.md does what it says: its files are written, its commands done, in its order."""

from __future__ import annotations

import doctest
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import call

GUIDE = Path(__file__).parents[3] / "docs" / "authoring.md"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
COMPARED = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


class Reader:
    """A person who does what the guide says, in an empty folder; `packages` is for `pip`."""

    def __init__(self, folder: Path, packages: Path) -> None:
        self._folder, self._packages, self._exit_code = folder, packages, 0

    def read(self, kind: str, text: str) -> None:
        """Follow one block of the guide."""
        if kind == "console":
            for step in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
                command, _, expected = step.partition("\n")
                output = self._do(*shlex.split(command))
                same = doctest.OutputChecker().check_output(expected, output, COMPARED)
                assert same or not expected, f"$ {command}\n{output}\n--- but says\n{expected}"
        else:
            path = self._folder / text.partition("\n")[0].removeprefix("# ")
            path.parent.mkdir(exist_ok=True)
            path.write_text(text)

    def _do(self, program: str, *words: str) -> str:
        if program == "echo":
            return f"{self._exit_code}\n"
        if program == "frankie-task":
            # Standard error has the status line, which depends on how fast the computer is.
            self._exit_code, out, err = call(*words)
            return out or err
        if program == "pytest":
            words += ("-p", "no:cacheprovider")
        else:  # pip, without the net, and to where it leaves no trace
            words += ("--quiet", "--no-deps", "--no-build-isolation", "--no-index")
            words += ("--target", str(self._packages))
        command = [sys.executable, "-m", program, *words]
        done = subprocess.run(command, cwd=self._folder, capture_output=True, text=True)
        self._exit_code = done.returncode
        assert program != "pip" or done.returncode == 0, done.stderr
        return done.stdout


@pytest.mark.slow
def test_everything_in_the_guide_runs(tmp_path, monkeypatch):
    packages, folder = tmp_path / "packages", tmp_path / "work"
    packages.mkdir()
    folder.mkdir()
    monkeypatch.syspath_prepend(packages)
    monkeypatch.chdir(folder)
    reader = Reader(folder, packages)
    blocks = BLOCK.findall(GUIDE.read_text())
    assert {kind for kind, _ in blocks} == {"yaml", "console", "python", "toml"}
    for kind, text in blocks:
        reader.read(kind, text)
    monkeypatch.delitem(sys.modules, "greeting", raising=False)
    assert {"hello.yaml", "bring.yaml", "runs"} <= {path.name for path in folder.iterdir()}
    runs = re.findall(r"^\$ frankie-task run ", GUIDE.read_text(), re.MULTILINE)
    assert len(list((folder / "runs").iterdir())) == len(runs) == 3
