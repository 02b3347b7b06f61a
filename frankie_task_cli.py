"""Entry point of `frankie-task`.

The packages of the project have plain names. Before it imports any of them, this module checks that
Python finds ours rather than a folder or distribution of the same name.
"""

import os
import sys
from importlib.machinery import PathFinder
from pathlib import Path

_PACKAGES = (
    "app",
    "behaviours",
    "config",
    "controller",
    "hw",
    "perception",
    "robots",
    "trees",
)
_MORE = ("drivers", "extensions", "lab")  # which may be left out
_HOME = Path(__file__).resolve().parent
_EXIT_BAD_INPUT = 2


def foreign_package() -> str | None:
    """One line about a package that Python would find elsewhere than beside this file, if any."""
    for name in (*_PACKAGES, *_MORE):
        spec = PathFinder.find_spec(name)
        if spec is None or spec.origin is None:
            if name in _MORE:
                continue
            return f"frankie-task is not installed completely: there is no package `{name}` in it"
        found = Path(spec.origin).resolve()
        if found.parent != _HOME / name:
            hint = "rename it, or take its folder from PYTHONPATH; or use an environment of its own"
            return f"{found}: hides the package `{name}` of frankie-task; {hint}"
    return None


def open_streams() -> None:
    """Open the null device for standard streams that were closed.

    Otherwise the first file that the process opens would become its standard output.
    """
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        if getattr(sys, name) is None:
            null = os.open(os.devnull, os.O_RDWR)
            os.dup2(null, number)
            setattr(sys, name, os.fdopen(number, mode))


def main() -> None:
    """Refuse foreign packages, then run the command line."""
    open_streams()
    if (line := foreign_package()) is not None:
        print(line, file=sys.stderr)
        sys.exit(_EXIT_BAD_INPUT)
    # Otherwise pydantic searches all installed packages for plug-ins at every start.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # Several threads that share a small product of matrices mostly wait for each other.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from app.commands import main as command_line

    command_line()


if __name__ == "__main__":
    main()
