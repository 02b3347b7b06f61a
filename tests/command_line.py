"""Commands of `frankie-task`, called in this process."""

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
