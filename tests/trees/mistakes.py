"""A task in which everything is right, to put one mistake into; the leaves are the real ones."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from tree_toys import TOYS, check

from config import Diagnostic, Severity

MARK = "¦"
"""Stands in a mistake where the diagnostic has to point."""
TABLES = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text("utf-8"))
BEFORE = TABLES["before"]


def file_with(text: str) -> str:
    """The task with items at the end of its tree, or an entry of a section: `poses: {...}`."""
    for section in ("poses", "regions"):
        if text.startswith(f"{section}: {{"):
            entry = text.removeprefix(f"{section}: {{").removesuffix("}")
            return BEFORE.replace(f"{section}:\n", f"{section}:\n  {entry}\n")
    return BEFORE + "".join(f"    {line}\n" for line in text.splitlines())


def found_in(folder: Path, text: str, severity: Severity = Severity.ERROR) -> list[Diagnostic]:
    """The diagnostics of a text, which may contain the mark."""
    path = folder / "t.yaml"
    path.write_text(text.replace(MARK, ""), encoding="utf-8")
    return [one for one in check(path) if one.severity is severity]


def found_in_toys(folder: Path, tree: str, severity: Severity) -> list[str]:
    """The diagnostics of a tree of toys, `line:column: message` as counted from its first line."""
    path = folder / "t.yaml"
    lines = "".join(f"  {line}\n" for line in tree.strip().splitlines())
    path.write_text(f"task: toy\ntree:\n{lines}")
    found = [one for one in check(path, leaves=TOYS) if one.severity is severity]
    places = [(one.location.line - 2, one.location.column - 2, one.message) for one in found]
    return [f"{line}:{column}: {message}" for line, column, message in places]


def marked(text: str) -> tuple[int, int]:
    """Line and column of the mark."""
    before = text[: text.index(MARK)]
    return before.count("\n") + 1, len(before) - before.rfind("\n")


def table(name: str) -> pytest.MarkDecorator:
    """A test of each row of a table in `mistakes.yaml`."""
    return pytest.mark.parametrize("row", TABLES[name], ids=task_of)


def task_of(row: Any) -> str:
    """What identifies a row."""
    return row if isinstance(row, str) else row.get("task") or row["place"]
