"""The driver of docs/drivers.md and the recogniser of examples, each installed as a package."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
OFFLINE = ("--no-deps", "--no-build-isolation", "--no-index", "--quiet")
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
    run("pip", "install", *OFFLINE, "--target", home, EXAMPLE, home=home)
    listed = run("frankie_task_cli", "drivers", home=home).splitlines()
    assert "base     line         line-base 1.0        address, port=5000" in listed
    text = (ROOT / "robots" / "frankie_site.yaml").read_text()
    begin, end = text.index("    driver: omron"), text.index("  arm:\n")
    robot = tmp_path / "ours.yaml"
    robot.write_text(f"{text[:begin]}    driver: line\n    address: 127.0.0.1\n{text[end:]}")
    run("frankie_task_cli", "check", ROOT / "trees/pick_one.yaml", "--robot", robot, home=home)
    run("pytest", "-q", "-p", "no:cacheprovider", EXAMPLE / "test_line_base.py", home=home)


def test_a_recogniser_of_any_word_keeps_to_its_test_with_weights_of_a_stand_in(tmp_path):
    home, example = tmp_path / "site", ROOT / "examples/open_vocabulary"
    run("pip", "install", *OFFLINE, "--target", home, example, home=home)
    run("pytest", "-q", "-p", "no:cacheprovider", example, home=home)
