"""Each promise of the pages in `promises.yaml` has a test, and the table has nothing else."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest
import yaml

TESTS = Path(__file__).parent
TABLE = yaml.safe_load((TESTS / "promises.yaml").read_text("utf-8"))
PROMISING = re.compile(
    r"\b(never|always|every|each|all|any|whatever|nothing|nobody|none|neither|no|not|cannot|must|only"
    r"|within|exactly|bounded|refused|until|at most|at once|bit for bit|as soon as)\b",
    re.IGNORECASE,
)
CODE = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
BLOCK = re.compile(r"\n\s*\n|\n(?=\s*(?:- |\|))")
END = re.compile(r"(?<=[.?!])\s+(?=[A-Z`*\[])")


def sentences(page: str) -> list[str]:
    """The sentences of a page, and the rows of its tables; no code, no headings."""
    text = CODE.sub("\n", (TESTS.parent / page).read_text("utf-8"))
    blocks = [" ".join(block.split()) for block in BLOCK.split(text)]
    return [one for block in blocks if block[:1] != "#" for one in END.split(block)]


def has(node: str) -> bool:
    """Whether there is a test file, or a test in one."""
    file, _, name = node.partition("::")
    path = TESTS.parent / file
    if not path.is_file() or not name:
        return path.is_file()
    body = ast.parse(path.read_text("utf-8")).body
    return any(isinstance(one, ast.FunctionDef) and one.name == name for one in body)


def in_table(page: str, sentence: str) -> bool:
    return any(part in sentence for part in TABLE[page])


@pytest.mark.parametrize("page", TABLE)
def test_every_promise_is_in_the_table(page):
    promises = [one for one in sentences(page) if PROMISING.search(one)]
    assert promises
    assert [one for one in promises if not in_table(page, one)] == []


@pytest.mark.parametrize("page", TABLE)
def test_everything_in_the_table_is_promised_once(page):
    said = sentences(page)
    assert [part for part in TABLE[page] if sum(part in one for one in said) != 1] == []


@pytest.mark.parametrize("page", TABLE)
def test_what_is_promised_is_tested(page):
    tests = [one for named in TABLE[page].values() if isinstance(named, list) for one in named]
    assert tests
    assert [one for one in tests if not has(one)] == []
