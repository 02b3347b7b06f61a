"""The user's cache folder of this program: what is there is made again if it is missing."""

import os
from pathlib import Path

from config.diagnostics import UserError


def user_cache() -> Path:
    """The folder, which need not exist; UserError: the user has no home."""
    usual = os.path.expanduser("~/.cache")
    if not (folder := os.environ.get("XDG_CACHE_HOME") or usual.removeprefix("~/.cache")):
        raise UserError("you have no home folder: set HOME, or XDG_CACHE_HOME for what is kept")
    return Path(folder) / "frankie-task"
