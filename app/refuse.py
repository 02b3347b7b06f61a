"""How a command says that its input is no good."""

from __future__ import annotations

from typing import NoReturn

import typer
from rich.console import Console

from app.outcome import EXIT_BAD_INPUT


def refuse(message: str) -> NoReturn:
    """Say in one line on standard error what is wrong, and end with exit code 2."""
    Console(stderr=True).print(message, soft_wrap=True, highlight=False, markup=False)
    raise typer.Exit(EXIT_BAD_INPUT)
