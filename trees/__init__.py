"""The shipped tasks; their language is in `trees.language`.

Each `*.yaml` here is a task; wherever a tree is asked for, its name stands for its file.
"""

from __future__ import annotations

from os.path import isfile
from pathlib import Path

from config import UserError, nearest, quoted
from trees.task_schema import SCHEMA_FILE, schema_text
from trees.template import new_files

_FOLDER = Path(__file__).parent


class UnknownTreeError(UserError):
    """No shipped tree has this name; the text lists those that have one."""


def shipped_names() -> tuple[str, ...]:
    """The names of the shipped tasks, sorted."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.yaml")))


def shipped(name: str) -> Path:
    """The file of a shipped task. Raises UnknownTreeError: there is no such task."""
    names = shipped_names()
    if name in names:
        return _FOLDER / f"{name}.yaml"
    here = (path.stem for path in Path().glob("*.yaml"))
    meant, known = nearest(name, (*names, *here)), f"a file or one of {quoted(names)}"
    hint = f"{meant} Give {known}" if meant else f"give {known}"
    raise UnknownTreeError(f"no tree is called `{name}`; {hint}")


def find(tree: str) -> Path:
    """The file for a path or for the name of a shipped task.

    A text with a folder or an ending is a path, whether or not the file exists; `.yaml` may be left
    out. Raises UnknownTreeError: it is neither.
    """
    path, beside = Path(tree), Path(f"{tree}.yaml")
    if path.suffix or len(path.parts) > 1 or isfile(path):
        return path
    return beside if tree not in shipped_names() and isfile(beside) else shipped(tree)
