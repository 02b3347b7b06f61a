"""Command line: one file per group of commands; `app` is their root."""

from app.commands.cli import app, main
from app.commands.refuse import RefusingGroup, find_tree, refuse, write
from app.commands.review import Run, Runs, recording_of, said_losses
