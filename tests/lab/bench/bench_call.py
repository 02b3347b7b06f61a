"""Calls of `frankie-task bench`."""

import json
from pathlib import Path

from typer.testing import CliRunner

from app.commands import app


def call(*arguments: object) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of one command."""
    result = CliRunner().invoke(app, ["bench", *(str(argument) for argument in arguments)])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.stdout, result.stderr


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
