"""The shipped tasks, and in `trees.language` the language that they are written in.

Each `*.yaml` here is a task; wherever a tree is asked for, its name stands for its file.
"""

from __future__ import annotations

from pathlib import Path

from config import UserError, quoted, suggest

__all__ = ["UnknownTreeError", "find", "shipped", "shipped_names"]

_FOLDER = Path(__file__).parent


class UnknownTreeError(UserError):
    """No tree goes by this name; the text lists those that there are."""


def shipped_names() -> tuple[str, ...]:
    """The names of the shipped tasks, sorted."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.yaml")))


def shipped(name: str) -> Path:
    """The file of a shipped task.

    Raises:
        UnknownTreeError: there is none of this name.
    """
    names = shipped_names()
    if name in names:
        return _FOLDER / f"{name}.yaml"
    hint = f"{suggest(name, names)} Give a file or one of {quoted(names)}"
    raise UnknownTreeError(f"no tree is called `{name}`; {hint}")


def find(tree: str) -> Path:
    """The file that a person means by a path or by the name of a shipped task.

    A text with a folder or an ending is a path, whether or not there is such a file.

    Raises:
        UnknownTreeError: it is neither.
    """
    path = Path(tree)
    return path if path.suffix or len(path.parts) > 1 or path.is_file() else shipped(tree)
