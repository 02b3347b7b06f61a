"""Command line: one file per group of commands; `app` is their root."""

from app.commands.cli import app, main
from app.commands.refuse import find_tree, refuse
