"""Commands of `frankie-task`, called in this process."""

import json
from typing import Any

import pytest
from typer.testing import CliRunner

from app.commands import app


def call(*arguments: object, typed: str | None = None) -> tuple[int, str, str]:
    """Exit code, standard output and standard error; an exception other than an exit is raised.

    `typed` is the standard input.
    """
    words = [str(argument) for argument in arguments]
    result = CliRunner().invoke(app, words, input=typed, env={"COLUMNS": "200"})
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.stdout, result.stderr


def in_real_time(summary: str) -> dict[str, Any]:
    """What a run with a real clock told at its end; skips the test where it failed and says why.

    No robot can be held by a computer that leaves out control ticks.
    """
    told: dict[str, Any] = json.loads(summary)
    if told["outcome"] != "success" and told["too_slow"]:
        pytest.skip(told["too_slow"])
    return told
