"""Dry run: ticks a tree without a robot.

Conditions and times are real, other leaves end at once with scripted outcomes; neither simulator
nor network is loaded. It shows the logic: which node runs after which outcome, what is retried or
halted, how the task ends.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, cast

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from app.core import End, Outcome
from behaviours import Context, Key, TaskLog
from config import Plain, UserError, counted, parse_scalar, quoted, suggest
from hw import SimClock, TaskClock, WallClock
from trees.language import (
    COMPOSITES,
    LeafNode,
    SubtreeNode,
    Task,
    TaskFileError,
    ValueType,
    build,
    failed_node,
    leaves_at,
    load,
    nodes_below,
    nodes_in_order,
    real_leaf,
    ticked,
)

PERIOD = 0.1  # simulated time between ticks [s]

_GLYPHS: Mapping[str, str] = {"success": "✔", "failure": "✗", "running": "▶", "invalid": "■"}

_MOST_SHOWN, _MOST_TICKS = 200, 1000
_POLL_PERIOD = 0.2  # interval of looking for a saved file [s]


@dataclass(frozen=True, kw_only=True)
class Step:
    """A node that ended or was halted in a tick, or a leaf that began to run."""

    stamp: float  # simulated time [s]
    name: str
    key: str  # kind of node: `grasp`, `sequence`, `retry`, ...
    status: str
    reason: str

    @property
    def is_news(self) -> bool:
        """Whether a person wants to see it, which is false for unnamed composites."""
        return self.key not in COMPOSITES or self.name != self.key

    @property
    def label(self) -> str:
        """Name, and key if that differs."""
        return self.name if self.name == self.key else f"{self.name} ({self.key})"


@dataclass(frozen=True, kw_only=True)
class DryRun:
    """The result of a dry run."""

    task: str
    ended: bool
    outcome: Outcome
    steps: tuple[Step, ...]

    def to_text(self) -> str:
        """A line per step; the last line is the result."""
        news = [step for step in self.steps if step.is_news]
        lines = [
            f"{step.stamp:8.1f} s  {_GLYPHS[step.status]} {step.label}: {step.reason}"
            for step in news[:_MOST_SHOWN]
        ]
        if len(news) > _MOST_SHOWN:
            lines.append(f"{'...':>8}    {counted(len(news) - _MOST_SHOWN, 'more line')}")
        where = f" (in {self.outcome.node})" if self.outcome.node else ""
        end = self.outcome.end.value if self.ended else "no end"
        lines.append(f"{self.task}, dry: {end}: {self.outcome.reason}{where}")
        return "\n".join(lines)


class _DryLeaf(Behaviour):
    """Returns scripted outcomes; a success writes given values, or zeros and empty texts."""

    def __init__(
        self,
        node: LeafNode,
        script: Script,
        keys: Mapping[str, Plain],
        arguments: Mapping[str, object],
    ) -> None:
        super().__init__(node.name)
        self.key = node.type.key
        self.is_condition = node.type.is_condition
        self._script = script
        self._outputs = {
            key: keys.get(key.name, _smallest(node.type.outputs[name].type))
            for name, key in arguments.items()
            if isinstance(key, Key)
        }

    def update(self) -> Status:
        """One tick."""
        status, self.feedback_message = self._script.next(self.name, self.key)
        self.overdue = status is Status.RUNNING  # of a condition: it will not be known
        if status is Status.SUCCESS:
            for key, value in self._outputs.items():
                key.write(value)
        return status


def _smallest(expected: ValueType) -> object:
    if expected.choices:
        return expected.choices[0]
    empty = expected.types[0]()
    return empty if expected.least is None or not isinstance(empty, int | float) else expected.least


def dry_run(
    path: Path,
    *,
    outcomes: Sequence[str] = (),
    keys: Sequence[str] = (),
    overrides: Mapping[str, str] = MappingProxyType({}),
    places: Path | None = None,
) -> DryRun:
    """Tick a task without a robot.

    `outcomes` of leaves are `NODE=OUTCOME,OUTCOME,...` (others run if they need no robot, or
    succeed), `keys` that leaves write `KEY=VALUE`, `overrides` values of task parameters.

    Raises:
        TaskFileError: the file has diagnostics.
        LeafError: a leaf class is invalid.
        UserError: an outcome is invalid, or the tree has no such node.
    """
    task = load(path, overrides=overrides, places=places)
    script, values = read_script(outcomes, task), read_keys(keys, task)
    clock = SimClock()
    context = cast(Any, _DryContext(clock=TaskClock(clock)))

    def leaf(node: LeafNode, _: Context, arguments: Mapping[str, object]) -> Behaviour:
        if node.type.needs_robot or script.tells(node.name, node.type.key):
            return _DryLeaf(node, script, values, arguments)
        return real_leaf(node, context, arguments)

    root = build(task, context, leaf)
    order = [entry.node for entry in nodes_in_order(root)]
    steps: list[Step] = []
    were_running: set[Behaviour] = set()
    for tick in range(1, _MOST_TICKS + 1):
        running: set[Behaviour] = set()
        for node in ticked(root):
            if node.status is Status.RUNNING:
                running.add(node)
                if node.children or node in were_running:
                    continue
            steps.append(_step(clock, node))
        halted = [node for node in were_running if node.status is Status.INVALID]
        steps += [_step(clock, node, "halted") for node in sorted(halted, key=order.index)]
        were_running = running
        if root.status is not Status.RUNNING:
            break
        clock.sleep_until(PERIOD * tick)
    return DryRun(
        task=task.name,
        ended=root.status is not Status.RUNNING,
        outcome=_outcome_of(root),
        steps=tuple(steps),
    )


def _step(clock: SimClock, node: Behaviour, reason: str = "") -> Step:
    return Step(
        stamp=round(clock.now(), 6),
        name=node.name,
        key=str(getattr(node, "key", "")),
        status=node.status.value.lower(),
        reason=reason or node.feedback_message,
    )


@dataclass(frozen=True, kw_only=True)
class _DryContext:
    """The part of `Context` that leaves without a robot need."""

    clock: TaskClock
    log: TaskLog = field(default_factory=TaskLog)


def _outcome_of(root: Behaviour) -> Outcome:
    if root.status is Status.SUCCESS:
        return Outcome(end=End.SUCCESS, reason=root.feedback_message)
    if root.status is Status.RUNNING:
        reason = f"still running after {_MOST_TICKS} ticks: {root.feedback_message}"
        return Outcome(end=End.FAILURE, reason=reason)
    node = failed_node(root)
    return Outcome(end=End.FAILURE, reason=node.feedback_message, node=node.name)


def again_on_save(
    tree: Path,
    overrides: Mapping[str, str],
    places: Path | None,
    *,
    act: Callable[[], None],
    say: Callable[[str], None],
) -> None:
    """Call `act` each time that a file of a task is saved, until Ctrl-C; report its mistakes.

    Raises UserError: bad input other than the task.
    """
    files, site = {tree}, [] if places is None else [places]
    clock = WallClock()
    try:
        while True:
            before = _stamps([*files, *site])
            try:
                files = set(load(tree, overrides=overrides, places=places).files)
                before = _stamps([*files, *site])
                act()
            except TaskFileError as error:
                say(str(error))
                files |= {mistake.path for mistake in error.diagnostics}
                before |= _stamps(files - before.keys())
            say(f"{tree}: save it to run it again; Ctrl-C ends")
            while _stamps(before) == before:
                clock.sleep_until(clock.now() + _POLL_PERIOD)
    except KeyboardInterrupt:
        return


def _stamps(paths: Iterable[Path]) -> dict[Path, tuple[int, int] | None]:
    """When files were saved, and their sizes; None for what is not there."""
    found: dict[Path, tuple[int, int] | None] = {}
    for path in paths:
        try:
            status = path.stat()
            found[path] = status.st_mtime_ns, status.st_size
        except OSError:
            found[path] = None
    return found


OUTCOMES: Mapping[str, Status] = {
    "success": Status.SUCCESS,
    "failure": Status.FAILURE,
    "running": Status.RUNNING,
}


class Script:
    """The outcomes of leaves.

    `outcomes` are by node name or leaf key, in turn; the last repeats. Names take precedence, and
    nodes of the same word share a list.
    """

    def __init__(self, outcomes: Mapping[str, Sequence[Status]]) -> None:
        self._outcomes = outcomes
        self._taken = dict.fromkeys(outcomes, 0)

    def tells(self, name: str, key: str) -> bool:
        """Whether it contains a leaf."""
        return name in self._outcomes or key in self._outcomes

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

    Raises UserError: it is invalid, or the tree has no such leaf.
    """
    words = sorted({word for leaf in _leaves(task) for word in (leaf.name, leaf.type.key)})
    outcomes = {}
    for text in texts:
        word, equals, listed = text.rpartition("=")
        if not equals or not word:
            example = "for example --outcome grasp=failure,success"
            raise UserError(f"--outcome {text}: write a node and its outcomes, {example}")
        if word not in words:
            hint = f"{suggest(word, words)} The tree has {quoted(words)}"
            raise UserError(f"--outcome {text}: the tree has no leaf `{word}`; {hint}")
        outcomes[word] = [_outcome(one.strip(), text) for one in listed.split(",")]
    return Script(outcomes)


def _outcome(word: str, text: str) -> Status:
    if word not in OUTCOMES:
        known = ", ".join(f"`{known}`" for known in OUTCOMES)
        raise UserError(f"--outcome {text}: `{word}` is not an outcome; write {known}")
    return OUTCOMES[word]


def _leaves(task: Task) -> Iterator[LeafNode]:
    """The leaves of a task that can be scripted, with guards and subtrees, without `set`."""
    for node in nodes_below(task.root):
        yield from (leaf for leaf in leaves_at(node) if not leaf.type.names_keys)
        if isinstance(node, SubtreeNode):
            yield from _leaves(node.task)


def read_keys(texts: Sequence[str], task: Task) -> dict[str, Plain]:
    """Values of keys, from texts such as `found=3`.

    Raises UserError: it is invalid, or no leaf of the tree writes such a key.
    """
    written = sorted({key.name for leaf in _leaves(task) for key in leaf.outputs.values()})
    values = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name:
            raise UserError(f"--key {text}: write a key and its value, for example --key found=3")
        if name not in written:
            raise UserError(f"--key {text}: no leaf writes `{name}`; {suggest(name, written)}")
        values[name] = parse_scalar(value)
    return values
