"""Commands of `frankie-task`, called in this process."""

from typer.testing import CliRunner

from app.commands import app


def call(*arguments: object) -> tuple[int, str, str]:
    """Exit code, standard output and standard error; an exception other than an exit is raised."""
    words = [str(argument) for argument in arguments]
    result = CliRunner().invoke(app, words, env={"COLUMNS": "200"})
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.stdout, result.stderr
