"""Calls of `frankie-task bench`."""

import json
from pathlib import Path

import command_line


def call(*arguments: object) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of one command."""
    return command_line.call("bench", *arguments)


def report(folder: Path, *arguments: object) -> dict:
    """The JSON file of a command that succeeds, with its standard output as `stdout`."""
    file = folder / "report.json"
    code, out, err = call(*arguments, "--json", file)
    assert code == 0, err
    return json.loads(file.read_text()) | {"stdout": out}


def refused(message: str, *arguments: object) -> None:
    """The command ends with exit code 2 and one line that contains this message."""
    code, _, err = call(*arguments)
    assert code == 2
    assert message in err
    assert err.count("\n") == 1
    assert "Traceback" not in err
