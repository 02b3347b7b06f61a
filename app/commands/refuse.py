"""How a command says that its input is no good: one line on standard error, and exit code 2."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

import typer
from rich.console import Console

from app.core.outcome import EXIT_BAD_INPUT


def refuse(message: str) -> NoReturn:
    """Say in one line on standard error what is wrong, and end with exit code 2."""
    Console(stderr=True).print(message, soft_wrap=True, highlight=False, markup=False)
    raise typer.Exit(EXIT_BAD_INPUT)


@contextmanager
def bad_input() -> Iterator[None]:
    """Refuse with the text of any error that a person can hint."""
    from app.core.folder import FolderError
    from app.live.monitor import RecorderError, ViewError
    from app.live.operator import UnknownNodeError
    from app.live.operator.console import GrootError, NoControlError, PageError
    from config.reader import ConfigError
    from hw.sim import SceneError
    from perception import WeightsError
    from trees.language import LeafError, TaskFileError

    try:
        yield
    except (
        ConfigError,
        FolderError,
        GrootError,
        LeafError,
        NoControlError,
        PageError,
        RecorderError,
        SceneError,
        TaskFileError,
        UnknownNodeError,
        ViewError,
        WeightsError,
    ) as error:
        refuse(str(error))


def find_tree(tree: str) -> Path:
    """The file of a task that is given by path or name; refuses what is neither."""
    from trees import UnknownTreeError, find

    try:
        return find(tree)
    except UnknownTreeError as error:
        refuse(str(error))
