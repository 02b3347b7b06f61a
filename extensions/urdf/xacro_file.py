"""Expands xacro files, in a process of its own: a macro may have no end, or fill the memory."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout, suppress
from importlib.util import find_spec
from pathlib import Path
from resource import RLIMIT_AS, setrlimit
from typing import Any

from config import UserError, extra, suggest
from extensions.urdf.packages import Packages

_LONGEST = 60.0  # expansion [s]
_MEMORY = 4 << 30  # that it may use [bytes]


def expanded(path: Path, packages: Sequence[Path], arguments: Sequence[str]) -> str:
    """The URDF of a xacro file with arguments `name:=value`; raises UserError."""
    if find_spec("xacro") is None:
        raise UserError(f"xacro files need an extra: {extra('robots')}")
    given = dict(one.split(":=", 1) for one in arguments)
    asked = json.dumps([str(path.resolve()), [str(one) for one in packages], given])
    around = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-P", "-m", __name__]
    try:
        done = subprocess.run(
            command, input=asked, capture_output=True, text=True, env=around, timeout=_LONGEST
        )
    except subprocess.TimeoutExpired:
        what = f"it is not expanded after {_LONGEST:.0f} s; does a macro call itself?"
        raise UserError(f"{path}: {what}") from None
    if done.returncode:
        why = (done.stderr.strip().splitlines() or ["it ended without a word"])[-1]
        raise UserError(f"{path}: xacro cannot expand it: {why}")
    return done.stdout


def _expand(path: str, folders: list[str], given: dict[str, str]) -> str:
    """The URDF; exits with one line if there is none."""
    import xacro
    from xacro import substitution_args

    packages = Packages(Path(path), [Path(one) for one in folders])

    def find(name: str) -> str:
        if found := packages.find(name):
            return str(found[0])
        raise xacro.XacroException(f"no package is called `{name}`; say where with --packages")

    substitution_args._eval_find = substitution_args._eval_dict["find"] = find
    try:
        text: str = xacro.process_file(path, mappings=dict(given)).toxml()
    except (Exception, SystemExit) as error:  # of macros that anybody may have made
        inner: Any = error
        while getattr(inner, "exc", None):  # each wraps the one before
            inner = inner.exc
        files: list[Any] = [one for one in xacro.filestack or () if one and one != path]
        why = {
            RecursionError: "a file or macro uses itself; cut the circle",
            MemoryError: f"it needs more than {_MEMORY >> 30} GB; does a macro call itself?",
            KeyError: f"nothing is called {inner}",
        }.get(type(inner), " ".join(str(inner).split())[:300])
        sys.exit(why + (f" (in {files[-1]})" if files else ""))
    texts = [Path(one).read_text(encoding="utf-8") for one in (path, *xacro.all_includes)]
    known = re.findall(r"<xacro:arg\s[^>]*?name=[\"']([^\"']+)", "".join(texts))
    if unknown := sorted(given.keys() - set(known)):
        sys.exit(f"it has no argument `{unknown[0]}`; {suggest(unknown[0], known)}")
    return text


if __name__ == "__main__":
    with suppress(ValueError):  # macOS has no such limit
        setrlimit(RLIMIT_AS, (_MEMORY, _MEMORY))
    with redirect_stdout(sys.stderr):  # macros may print
        urdf = _expand(*json.load(sys.stdin))
    sys.stdout.write(urdf)
