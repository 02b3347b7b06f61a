"""The command line: one file for each group of commands, `app` is their root."""

from app.commands.cli import app, main

__all__ = ["app", "main"]
