"""docs/authoring.md does what it says: its files are written, its commands done, in its order."""

from __future__ import annotations

import doctest
import importlib
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from command_line import call

GUIDE = Path(__file__).parents[3] / "docs" / "authoring.md"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
COMPARED = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


class Reader:
    """A person who does what the guide says, in an empty folder.

    Args:
        folder: where.
        packages: where Python finds what is installed.
    """

    def __init__(self, folder: Path, packages: Path) -> None:
        self._folder = folder
        self._packages = packages
        self._exit_code = 0

    def read(self, kind: str, text: str) -> None:
        """Follow one block of the guide."""
        if kind == "console":
            for step in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
                command, _, expected = step.partition("\n")
                self._do(command, expected)
        else:
            path = self._folder / text.partition("\n")[0].removeprefix("# ")
            path.parent.mkdir(exist_ok=True)
            path.write_text(text)

    def _do(self, command: str, expected: str) -> None:
        if command == "echo $?":
            output = f"{self._exit_code}\n"
        elif command.startswith("pip install "):
            output = self._install(command.removeprefix("pip install "))
        elif command.startswith("pytest "):
            tests = [sys.executable, "-m", *shlex.split(command), "-p", "no:cacheprovider"]
            done = subprocess.run(tests, cwd=self._folder, capture_output=True, text=True)
            output, self._exit_code = done.stdout, done.returncode
        else:
            program, *arguments = shlex.split(command)
            assert program == "frankie-task", f"the guide uses {program}"
            # Standard error has the status line, which depends on how fast the computer is.
            self._exit_code, out, err = call(*arguments)
            output = out or err
        assert not expected or doctest.OutputChecker().check_output(expected, output, COMPARED), (
            f"$ {command}\n{output}\n--- but the guide says\n{expected}"
        )

    def _install(self, package: str) -> str:
        """As the guide does, but without the net, and to where it leaves no trace."""
        options = ("--quiet", "--no-deps", "--no-build-isolation", "--no-index")
        target = ("--target", str(self._packages))
        subprocess.run(
            [sys.executable, "-m", "pip", "install", *options, *target, package],
            cwd=self._folder,
            check=True,
        )
        return ""


@pytest.mark.slow
def test_everything_in_the_guide_runs(tmp_path, monkeypatch):
    packages = tmp_path / "packages"
    folder = tmp_path / "work"
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
    files = {path.name for path in folder.iterdir()}
    assert {"hello.yaml", "bring.yaml", "runs"} <= files
    runs = re.findall(r"^\$ frankie-task run ", GUIDE.read_text(), re.MULTILINE)
    assert len(list((folder / "runs").iterdir())) == len(runs) == 3


def test_the_behaviour_of_the_guide_runs(tmp_path, monkeypatch):
    """Its own tests pass, and it greets; installed as its package says, without pip."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    for name, text in re.findall(
        r"^```\w+\n# (gree\S+)\n(.*?)^```$", GUIDE.read_text(), re.M | re.S
    ):
        Path(Path(name).name).write_text(text)
    declared = tomllib.loads(Path("pyproject.toml").read_text())["project"]["entry-points"]
    ((group, entries),) = declared.items()
    (package := Path("greeting-0.1.dist-info")).mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: greeting\nVersion: 0.1\n")
    lines = [f"{key} = {where}" for key, where in entries.items()]
    (package / "entry_points.txt").write_text("\n".join([f"[{group}]", *lines, ""]))
    try:
        tests = vars(importlib.import_module("test_greeting"))
        for test in [one for name, one in tests.items() if name.startswith("test_")]:
            test()
        code, out, err = call("run", "greet.yaml", "--view", "none")
        assert (code, "Good morning." in out) == (0, True), err
    finally:
        for name in ("greeting", "test_greeting"):
            sys.modules.pop(name, None)


def test_the_files_of_the_guide_are_checked_as_it_says(tmp_path, monkeypatch):
    """Without runs, and without the package that it installs."""
    monkeypatch.chdir(tmp_path)
    text = GUIDE.read_text()
    for name, mistakes in (("mistaken.yaml", 1), ("bring.yaml", 0)):
        (block,) = re.findall(rf"^```yaml\n(# {name}\n.*?)^```$", text, re.M | re.S)
        Path(name).write_text(block)
        assert call("check", name)[0] == (2 if mistakes else 0)
