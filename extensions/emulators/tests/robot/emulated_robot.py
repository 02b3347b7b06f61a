"""An emulated Frankie at addresses of its own, as its file says it."""

import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest
from emulated_panda import IN_TIME, free_address

from drivers import panda, realsense
from extensions.emulators.frankie import EmulatorLink
from robots import load_real_robot

ROOT = Path(__file__).parents[4]
_missing = panda.missing() or realsense.missing()
needs_drivers = pytest.mark.skipif(bool(_missing), reason=_missing)


def robot_file(folder: Path, name: str = "robot", **changes: str) -> Path:
    """The shipped file of the emulated robot, with addresses that no other test uses."""
    text = (ROOT / "robots" / "emulated.yaml").read_text()
    text = text.replace("127.0.60.1", free_address())
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    path = folder / f"{name}.yaml"
    path.write_text(text)
    return path


@contextmanager
def emulated(
    path: Path, scene: str = "single", seed: int = 1, *reported: str, level: str = "exact"
):
    """Run the emulators of a file, whose parts behave as reported; the link to them."""
    words = [str(path), "kinematic", scene, str(seed), level, *reported]
    process = subprocess.Popen(
        [sys.executable, "-m", "extensions.emulators.frankie", *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )
    try:
        assert "begin" in process.stdout.readline()
        link = link_to(path)
        if not IN_TIME:
            link.do("arm patience 1000")
        yield link
        link.close()
    finally:
        process.stdin.close()
        process.wait(10.0)


def link_to(path: Path) -> EmulatorLink:
    hardware = load_real_robot(path).hardware
    return EmulatorLink(hardware.base.address, hardware.emulated)
