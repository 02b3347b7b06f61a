"""Lazy packages: names are imported at their first use, so that the command line starts fast."""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable, Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any


def lazy_face(package: str) -> Callable[[str], Any]:
    """The `__getattr__` of a package, for the names under its `if TYPE_CHECKING:` (PEP 562)."""

    def of_package(name: str) -> Any:
        where = _homes(package).get(name)
        if where is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(where), name)
        setattr(sys.modules[package], name, value)
        return value

    return of_package


@cache
def _homes(package: str) -> dict[str, str]:
    source = Path(str(sys.modules[package].__file__)).read_text(encoding="utf-8")
    return dict(_named(ast.parse(source).body))


def _named(statements: list[ast.stmt]) -> Iterator[tuple[str, str]]:
    for statement in statements:
        if isinstance(statement, ast.If) and ast.unparse(statement.test) == "TYPE_CHECKING":
            yield from _named(statement.body)
        elif isinstance(statement, ast.ImportFrom) and statement.module:
            yield from ((alias.name, statement.module) for alias in statement.names)
