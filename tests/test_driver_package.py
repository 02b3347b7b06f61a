"""The driver of docs/drivers.md, installed as a package of its own."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "docs" / "driver"


def run(*words: str | Path, home: Path) -> str:
    """What a program says that finds the packages of a folder; it must end well."""
    path = os.pathsep.join([str(home), str(ROOT)])
    done = subprocess.run(
        [sys.executable, "-m", *map(str, words)],
        env=os.environ | {"PYTHONPATH": path},
        cwd=home.parent,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_a_driver_is_installed_listed_named_in_a_robot_file_and_keeps_the_contract(tmp_path):
    home = tmp_path / "site"
    offline = ("--no-deps", "--no-build-isolation", "--no-index", "--quiet")
    run("pip", "install", *offline, "--target", home, EXAMPLE, home=home)
    listed = run("frankie_task_cli", "drivers", home=home).splitlines()
    assert "base     line         line-base 1.0        address, port=5000" in listed
    text = (ROOT / "robots" / "frankie_site.yaml").read_text()
    begin, end = text.index("    driver: omron"), text.index("  arm:\n")
    robot = tmp_path / "ours.yaml"
    robot.write_text(f"{text[:begin]}    driver: line\n    address: 127.0.0.1\n{text[end:]}")
    run("frankie_task_cli", "check", ROOT / "trees/pick_one.yaml", "--robot", robot, home=home)
    run("pytest", "-q", "-p", "no:cacheprovider", EXAMPLE / "test_line_base.py", home=home)
