"""`run --dry`: the tree in a world where every leaf ends at once, as a script says.

Nothing of the robot, the simulator or the network is loaded. What is tried out is the task: which
node runs after which outcome, what is attempted again, how the task ends.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, cast

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from app.core import End, Outcome
from behaviours import Key, TaskLog
from config import UserError, quoted, suggest
from hw import SimClock, TaskClock
from trees.language import (
    COMPOSITES,
    SET,
    LeafNode,
    SubtreeNode,
    Task,
    ValueType,
    build,
    failed_node,
    leaves_at,
    load,
    nodes_below,
    nodes_in_order,
)

PERIOD = 0.1
"""Simulated time from tick to tick [s]."""

OUTCOMES: Mapping[str, Status] = {
    "success": Status.SUCCESS,
    "failure": Status.FAILURE,
    "running": Status.RUNNING,
}
"""What a leaf may be told to return."""

_GLYPHS: Mapping[str, str] = {"success": "✔", "failure": "✗", "running": "▶", "invalid": "·"}

_MOST_SHOWN = 200
"""More lines are not read by a person."""


class ScriptError(UserError):
    """An outcome cannot be scripted; the text says why and what to write."""


@dataclass(frozen=True, kw_only=True)
class Step:
    """How a node ended in a tick, or that a leaf began to run."""

    tick: int
    stamp: float
    """Simulated time [s]."""
    path: str
    """Names from the root down, joined by `/`."""
    name: str
    key: str
    """What the node is: `grasp`, `sequence`, `retry`, ..."""
    status: str
    reason: str

    @property
    def is_news(self) -> bool:
        """Whether it adds to the line before: a composite without a name does not."""
        return self.key not in COMPOSITES or self.name != self.key

    @property
    def label(self) -> str:
        """Its name, and its key if that differs."""
        return self.name if self.name == self.key else f"{self.name} ({self.key})"


@dataclass(frozen=True, kw_only=True)
class DryRun:
    """The result of a dry run."""

    task: str
    ended: bool
    """Whether the tree ended within the ticks allowed."""
    outcome: Outcome
    ticks: int
    steps: tuple[Step, ...]

    def to_json(self) -> str:
        """One JSON object."""
        outcome = {
            "outcome": self.outcome.end.value,
            "reason": self.outcome.reason,
            "node": self.outcome.node,
        }
        return json.dumps(asdict(self) | outcome, indent=2)

    def to_text(self) -> str:
        """A line a step; the last line is the result."""
        news = [step for step in self.steps if step.is_news]
        hidden = len(news) - _MOST_SHOWN
        lines = [
            f"{step.stamp:8.1f} s  {_GLYPHS[step.status]} {step.label}: {step.reason}"
            for step in news[:_MOST_SHOWN]
        ]
        if hidden > 0:
            lines.append(f"{'...':>8}    {hidden} more lines; all of them with --json")
        where = f" (in {self.outcome.node})" if self.outcome.node else ""
        end = self.outcome.end.value if self.ended else "no end"
        lines.append(f"{self.task}, dry: {end}: {self.outcome.reason}{where}")
        return "\n".join(lines)


class Script:
    """Which outcome is next for a leaf.

    Args:
        outcomes: by leaf key or node name, in turn; the last repeats. All nodes of this key or name
            take from the same list. A name counts before a key; the other leaves succeed.
    """

    def __init__(self, outcomes: Mapping[str, Sequence[Status]]) -> None:
        self._outcomes = outcomes
        self._taken = dict.fromkeys(outcomes, 0)

    def next(self, name: str, key: str) -> tuple[Status, str]:
        """The outcome of the next tick of a leaf, and its reason."""
        word = name if name in self._outcomes else key
        if word not in self._outcomes:
            return Status.SUCCESS, "not scripted"
        statuses, number = self._outcomes[word], self._taken[word] + 1
        self._taken[word] = number
        again = ", again" if number > len(statuses) else ""
        number = min(number, len(statuses))
        return statuses[number - 1], f"scripted, {number} of {len(statuses)}{again}"


def read_script(texts: Sequence[str], task: Task) -> Script:
    """The script in texts such as `grasp=failure,failure,success`.

    Raises:
        ScriptError: it is written wrongly, or the tree has no such leaf.
    """
    words = sorted({word for leaf in _leaves(task) for word in (leaf.name, leaf.type.key)})
    outcomes = {}
    for text in texts:
        word, equals, listed = text.rpartition("=")
        if not equals or not word:
            example = "for example --outcome grasp=failure,success"
            raise ScriptError(f"--outcome {text}: write a node and its outcomes, {example}")
        if word not in words:
            hint = f"{suggest(word, words)} The tree has {quoted(words)}"
            raise ScriptError(f"--outcome {text}: the tree has no leaf `{word}`; {hint}")
        outcomes[word] = [_outcome(one.strip(), text) for one in listed.split(",")]
    return Script(outcomes)


def _outcome(word: str, text: str) -> Status:
    if word not in OUTCOMES:
        known = ", ".join(f"`{known}`" for known in OUTCOMES)
        raise ScriptError(f"--outcome {text}: `{word}` is not an outcome; write {known}")
    return OUTCOMES[word]


def _leaves(task: Task) -> Iterator[LeafNode]:
    """The leaves of a task that can be scripted, with guards and other files, without `set`."""
    for node in nodes_below(task.root):
        yield from (leaf for leaf in leaves_at(node) if leaf.type is not SET)
        if isinstance(node, SubtreeNode):
            yield from _leaves(node.task)


class _DryLeaf(Behaviour):
    """Returns what the script says; when it succeeds, its outputs hold zeros and empty texts."""

    def __init__(self, node: LeafNode, script: Script, arguments: Mapping[str, object]) -> None:
        super().__init__(node.name)
        self.key = node.type.key
        self.is_condition = node.type.is_condition
        self._script = script
        self._outputs = {
            key: _smallest(node.type.outputs[name].type)
            for name, key in arguments.items()
            if isinstance(key, Key)
        }

    def update(self) -> Status:
        """One tick."""
        status, self.feedback_message = self._script.next(self.name, self.key)
        if status is Status.SUCCESS:
            for key, value in self._outputs.items():
                key.write(value)
        return status


def _smallest(expected: ValueType) -> object:
    """The smallest value of a type."""
    if expected.choices:
        return expected.choices[0]
    empty = expected.types[0]()
    return empty if expected.least is None or not isinstance(empty, int | float) else expected.least


def dry_run(
    path: Path, *, outcomes: Sequence[str], overrides: Mapping[str, str], most_ticks: int
) -> DryRun:
    """Tick a task without a robot.

    Args:
        path: the task file.
        outcomes: what leaves return, each `NODE=OUTCOME,OUTCOME,...`.
        overrides: values of task parameters, as texts.
        most_ticks: a tree that has not ended by then is stopped.

    Raises:
        TaskFileError: the file has diagnostics.
        LeafError: a leaf class, not the file, is at fault.
        ScriptError: an outcome is written wrongly, or the tree has no such node.
    """
    task = load(path, overrides=overrides)
    script = read_script(outcomes, task)
    clock = SimClock()
    context = cast(Any, _DryContext(clock=TaskClock(clock)))
    root = build(task, context, lambda node, _, arguments: _DryLeaf(node, script, arguments))
    paths = {entry.node: entry.path for entry in nodes_in_order(root)}
    steps: list[Step] = []
    were_running: set[Behaviour] = set()
    for tick in range(1, most_ticks + 1):
        running: set[Behaviour] = set()
        for node in root.tick():
            if node.status is Status.RUNNING:
                running.add(node)
                if node.children or node in were_running:
                    continue
            steps.append(
                Step(
                    tick=tick,
                    stamp=round(clock.now(), 6),
                    path=paths[node],
                    name=node.name,
                    key=str(getattr(node, "key", "")),
                    status=node.status.value.lower(),
                    reason=node.feedback_message,
                )
            )
        were_running = running
        if root.status is not Status.RUNNING:
            break
        clock.sleep_until(PERIOD * tick)
    return DryRun(
        task=task.name,
        ended=root.status is not Status.RUNNING,
        outcome=_outcome_of(root, most_ticks),
        ticks=tick,
        steps=tuple(steps),
    )


@dataclass(frozen=True, kw_only=True)
class _DryContext:
    """All that a tree of dry leaves needs of a `Context`."""

    clock: TaskClock
    keys: dict[str, Key[object]] = field(default_factory=dict)
    log: TaskLog = field(default_factory=TaskLog)


def _outcome_of(root: Behaviour, most_ticks: int) -> Outcome:
    if root.status is Status.SUCCESS:
        return Outcome(end=End.SUCCESS, reason=root.feedback_message)
    if root.status is Status.RUNNING:
        reason = f"still running after {most_ticks} ticks: {root.feedback_message}"
        return Outcome(end=End.FAILURE, reason=reason)
    node = failed_node(root)
    return Outcome(end=End.FAILURE, reason=node.feedback_message, node=node.name)
