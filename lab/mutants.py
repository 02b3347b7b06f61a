"""Mutants: one operator or constant of the product is changed at a time, and a test should see it.

    make coverage
    python -m lab.mutants hw/gate.py hw/loop_watchdog.py --count 20 --seed 1

Each mutant lives in a copy of the repository, where those tests run that have run its line; of a
line that runs when its module is imported, those that have run any line of the module.
"""

import ast
import os
import random
import re
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, NamedTuple

import coverage
import pytest
import typer

_OPERATORS = {
    **{"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="},
    **{"is": "is not", "is not": "is", "in": "not in", "not in": "in"},
    **{"+": "-", "-": "+", "*": "/", "/": "*", "and": "or", "or": "and", "//": "*", "**": "*"},
}
_TOKEN = re.compile(r"is not\b|not in\b|\b(?:is|in|and|or)\b|[<>=!]=|//|\*\*|[<>+*/-]")
_NEVER = ast.JoinedStr | ast.Raise | ast.Assert
_MOST_TESTS = 60  # that are asked, those of the fewest lines first
_LIMIT = 300.0  # of their run [s]; a mutant that hangs is seen


class Mutant(NamedTuple):
    """A change of one file."""

    path: Path
    line: int
    start: int
    """Place of the first changed character in the file ..."""
    end: int
    """... and of the first one after the change."""
    text: str
    """What stands there instead."""

    def of(self, source: str) -> str:
        """The changed file."""
        return source[: self.start] + self.text + source[self.end :]

    def described(self, source: str) -> str:
        """Its place, and the changed line."""
        begin = source.rfind("\n", 0, self.start) + 1
        end = source.find("\n", self.end)
        was = source[self.start : self.end]
        whole = source[begin:end].strip()
        return f"{self.path}:{self.line}: `{was}` -> `{self.text}` in: {whole}"


def mutants_of(path: Path, source: str) -> Iterator[Mutant]:
    """All mutants of a file, in the order of its text."""
    starts = [0]
    for line in source.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    encoded = source.encode()

    def place(line: int, column: int) -> int:
        return len(encoded[: starts[line - 1] + column].decode())

    def begin(node: ast.expr) -> int:
        return place(node.lineno, node.col_offset)

    def end(node: ast.expr) -> int:
        return place(node.end_lineno or node.lineno, node.end_col_offset or 0)

    def between(left: ast.expr, right: ast.expr) -> Iterator[Mutant]:
        found = _TOKEN.search(source, end(left), begin(right))
        if found and found[0] in _OPERATORS:
            yield Mutant(path, left.lineno, *found.span(), _OPERATORS[found[0]])

    for node in _walk(ast.parse(source)):
        match node:
            case ast.Compare(left=left, comparators=[right]):
                yield from between(left, right)
            case ast.BinOp(left=left, right=right):
                yield from between(left, right)
            case ast.BoolOp(values=[left, right, *_]):
                yield from between(left, right)
            case ast.UnaryOp(op=ast.Not()):
                yield Mutant(path, node.lineno, begin(node), begin(node) + len("not "), "")
            case ast.Constant(value=bool(value)):
                yield Mutant(path, node.lineno, begin(node), end(node), str(not value))
            case ast.Constant(value=int(value) | float(value)):
                yield Mutant(path, node.lineno, begin(node), end(node), f"{value * 2 or 1}")


def _walk(node: ast.AST) -> Iterator[ast.AST]:
    """What decides: no annotations and decorators, no text, that of an error included, no check.

    A check, of an `assert` or `zip(strict=...)`, holds in every run of a program without mistakes.
    """
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST) or isinstance(child, _NEVER):
                continue
            if not (isinstance(child, ast.keyword) and child.arg == "strict"):
                yield child
                yield from _walk(child)


def _ran(data: coverage.CoverageData) -> Counter[str]:
    """How many lines each test has run."""
    return Counter(
        test
        for path in data.measured_files()
        for tests in data.contexts_by_lineno(path).values()
        for test in tests
        if test
    )


def _is_seen(mutant: Mutant, tests: list[str], root: Path) -> bool:
    """Whether a test fails where the mutant lives."""
    files = {path.stem: path for path in root.rglob("test_*.py")}
    of_tests = [one.split(".")[-2:] for one in tests]
    ids = [f"{files[module]}::{test}" for module, test in of_tests if module in files]
    path = root / mutant.path
    source = path.read_text()
    path.write_text(mutant.of(source))
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *ids]
    environment = os.environ | {"PYTHONPATH": str(root)}
    try:
        ended = subprocess.run(
            command, cwd=root, env=environment, capture_output=True, timeout=_LIMIT, check=False
        )
    except subprocess.TimeoutExpired:
        return True
    finally:
        path.write_text(source)
    if b"not found: " in ended.stderr:
        raise RuntimeError(f"no verdict on {mutant.path}:{mutant.line}: {ended.stderr.decode()}")
    # Where the mutant cannot be imported, the tests are not collected.
    failed = pytest.ExitCode.TESTS_FAILED, pytest.ExitCode.INTERRUPTED, pytest.ExitCode.USAGE_ERROR
    return ended.returncode in failed


def main(
    paths: Annotated[list[Path], typer.Argument(help="Files of the product.")],
    count: Annotated[int, typer.Option(help="How many mutants, at random.")] = 60,
    seed: Annotated[int, typer.Option(help="Of the choice.")] = 0,
) -> None:
    """Change one operator or constant at a time, and run the tests that run its line."""
    data = coverage.CoverageData()
    data.read()
    if not (sizes := _ran(data)):
        raise typer.BadParameter("no test is known to run them: `make coverage` first")
    if subprocess.run(["git", "diff", "--quiet", "HEAD"], check=False).returncode:
        raise typer.BadParameter("commit first: the mutants live in a copy of the last commit")
    everything = [one for path in paths for one in mutants_of(path, path.read_text())]
    chosen = random.Random(seed).sample(everything, min(count, len(everything)))
    survivors = 0
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder) / "copy"
        subprocess.run(["git", "worktree", "add", "-q", "--detach", root], check=True)
        try:
            for mutant in sorted(chosen):
                lines = data.contexts_by_lineno(str(mutant.path.resolve()))
                tests = set(lines.get(mutant.line, ())) - {""} or set().union(*lines.values())
                best = sorted(tests - {""}, key=lambda test: (sizes[test], test))[:_MOST_TESTS]
                is_seen = bool(best) and _is_seen(mutant, best, root)
                survivors += not is_seen
                said = "seen" if is_seen else "SURVIVES" if best else "SURVIVES, no test runs it"
                typer.echo(f"{said}: {mutant.described(mutant.path.read_text())}")
        finally:
            subprocess.run(["git", "worktree", "remove", "--force", root], check=True)
    typer.echo(f"{len(chosen) - survivors} of {len(chosen)} mutants seen")


if __name__ == "__main__":
    typer.run(main)
