"""Damaged task files give a task or located diagnostics, soon, and never anything else.

A task that comes out of it is run with leaves that end as dice fall: a key that the check let pass
is never read before it is written.
"""

import random
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from everything import write_everything
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from tree_toys import ToyContext

import trees
from behaviours import DetectedObjects, Key
from config import Diagnostic
from trees.language import Task, TaskFileError, build, known_leaves, load
from trees.words import SEEN_LIST

SNIPPETS = (
    *("{type: object}", "$thing", "list: things, ", "in: $things", "colour: red, "),
    *("\n", ":", "- ", "{", "}", "[", "]", "$", "&a ", "*a", "!t ", "'", '"', "|", "\t", "#", ","),
    *("? ", "0", "-1", ".nan", "1e999", "null", "true", "\u2028", "\x00", "ü", "---\n", "  "),
    *("sequence:", "fallback: ", "forever: ", "until: ", "parallel: ", "policy: 2, children: "),
    *("retry: 2, ", "while: arm_healthy, ", "unless: holding_object, ", "force: failure, "),
    *("set: {found: 1}", "$found", "$pause", "$count", "count: found", "subtree: ", "with: "),
    *("out: ", "{file: parts/count.yaml}", "{file: ../x.yaml}", "{type: pose}"),
    *("default: ", "min: "),
)
LEAVES = known_leaves()


class Dice(Behaviour):
    """Outcomes or runs on as a die falls; a success writes every key."""

    def __init__(self, name: str, rng: random.Random, values: dict[Key, object]) -> None:
        super().__init__(name)
        self.rng, self.values = rng, values

    def update(self) -> Status:
        status = self.rng.choice([Status.SUCCESS, Status.FAILURE, Status.RUNNING, Status.INVALID])
        if status is Status.SUCCESS:
            for key, value in self.values.items():
                key.write(value)
        return status


def damaged(text: str, rng: random.Random) -> str:
    """The text with one to four changes: pieces put in, taken out, repeated or moved."""
    for _ in range(rng.randint(1, 4)):
        start = rng.randint(0, len(text))
        end = min(len(text), start + rng.choice([0, 0, 1, 3, 12]))
        kind = rng.randrange(4)
        if kind == 0:
            lines = text.splitlines(keepends=True) or [""]
            line = rng.choice(lines)
            lines.insert(rng.randint(0, len(lines)), rng.choice(["", "  "]) + line)
            text = "".join(lines)
        elif kind == 1:
            lines = text.splitlines(keepends=True) or [""]
            del lines[rng.randrange(len(lines))]
            text = "".join(lines)
        else:
            piece = rng.choice(SNIPPETS) if kind == 2 else text[start : start + 20]
            text = text[:start] + piece + text[end:]
    return text


def cases(folder: Path, count: int) -> Iterator[Path]:
    """Paths of task files, each time with another damage in it or in its subtree."""
    rng = random.Random(0)
    shipped = Path(trees.__file__).parent
    for path in (*shipped.glob("*.yaml"), *shipped.glob("parts/*.yaml")):
        (folder / path.relative_to(shipped)).parent.mkdir(exist_ok=True)
        shutil.copy(path, folder / path.relative_to(shipped))
    samples = (write_everything(folder), folder / "choosing.yaml")
    whole = {path: path.read_text() for path in sorted(folder.rglob("*.yaml"))}
    tops = [path for path in whole if path.parent == folder]
    parts = [path for path in whole if path.parent != folder]
    weights = [10 if path in samples else 1 for path in tops]
    for _ in range(count):
        [top] = rng.choices(tops, weights)
        broken = rng.choice([top, top, top, *parts])
        broken.write_bytes(damaged(whole[broken], rng).encode("utf-8", errors="replace"))
        yield top
        broken.write_text(whole[broken])


def judge(path: Path, rng: random.Random) -> str:
    """`task` or `diagnostics`; fails if it is anything else."""
    task, diagnostics = loaded(path)
    if task is not None:
        run(task, rng)
        return "task"
    assert diagnostics
    for diagnostic in diagnostics:
        lines = diagnostic.path.read_bytes().decode(errors="replace").splitlines()
        assert 1 <= diagnostic.location.line <= len(lines) + 1
        assert diagnostic.location.column >= 1
        assert diagnostic.message
        assert diagnostic.hint
    return "diagnostics"


def loaded(path: Path) -> tuple[Task | None, Sequence[Diagnostic]]:
    try:
        return load(path, leaves=LEAVES), ()
    except TaskFileError as error:
        return None, error.diagnostics


def run(task: Task, rng: random.Random) -> None:
    """A few ticks with leaves that end as dice fall."""
    context = ToyContext()

    def leaf(node, context, arguments):
        outputs = {key: name for name, key in arguments.items() if isinstance(key, Key)}
        seen = {key for key, name in outputs.items() if node.type.outputs[name].type == SEEN_LIST}
        values = {key: DetectedObjects([1, 2]) if key in seen else 1 for key in outputs}
        return Dice(node.name, rng, values)

    root = build(task, context, leaf)
    for _ in range(12):
        root.tick_once()
        context.clock.sleep_until(context.clock.now() + 0.1)
    root.stop(Status.INVALID)
    assert not any(node.status is Status.RUNNING for node in root.iterate())


@pytest.mark.parametrize("count", [300, pytest.param(5_000, marks=pytest.mark.slow)])
def test_damaged_files(tmp_path, count):
    rng = random.Random(0)
    ends = [judge(path, rng) for path in cases(tmp_path, count)]
    assert min(ends.count("task"), ends.count("diagnostics")) > 15


@pytest.mark.parametrize(
    "text",
    [
        "task: t\ntree:\n  sequence:\n" + "    - zzzz: {a: 1}\n" * 3_000,
        "task: t\ntree: {sequence: [" + "open_gripper, " * 4_500 + "]}\n",
        "task: t\ntree: " + "{forever: " * 2_500 + "open_gripper" + "}" * 2_500 + "\n",
        "task: t\nposes: {" + "".join(f"p{n}: [, " for n in range(4_500)) + "}\n",
    ],
    ids=["errors", "nodes", "depth", "brackets"],
)
def test_large_files_are_bounded(tmp_path, text):
    path = tmp_path / "large.yaml"
    path.write_text(text)
    task, diagnostics = loaded(path)
    assert task or 1 <= len(diagnostics) <= 100
