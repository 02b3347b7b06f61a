"""A tree and its run as text for a terminal: the whole picture, and one line per change."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from py_trees.common import Status
from rich.text import Text

from app.live.nodes import Look, looks, parents, path_from_root, tip
from app.task_time import in_words, task_time

if TYPE_CHECKING:
    from app.live.nodes import NodeInfo, NodeStatus
    from app.live.snapshot import Snapshot

_LOOKS = {
    Look.IDLE: ("·", "bright_black"),
    Look.RUNNING: ("▶", "cyan"),
    Look.SUCCESS: ("✔", "green"),
    Look.NOT_YET: ("○", "yellow"),
    Look.FAILURE: ("✗", "red"),
}
_GLYPH = {Status.RUNNING: "▶", Status.SUCCESS: "✔", Status.FAILURE: "✗"}
_ANSWERED_NO = "○"
_BAR = 20
_LONGEST_NAME = 40


class Moment(NamedTuple):
    """One tick, with the figures beside the tree."""

    seen: Snapshot
    placed: int
    attempts: int
    paused: str = ""
    """Why the run is paused; empty if it is not."""


@dataclass(frozen=True, kw_only=True)
class RunInfo:
    """Constant data of a run."""

    task: str
    where: str
    objects: int = 0
    """Number of objects to be placed; 0 if unknown or none."""


def picture(
    info: RunInfo,
    tree: Sequence[NodeInfo],
    moment: Moment,
    *,
    elapsed: float,
    width: int,
    rows: int,
    age: float = 0.0,
) -> Text:
    """The whole display: badges, figures, and the tree with the running leaf in bold.

    Args:
        info: the run.
        tree: its nodes, in preorder.
        moment: the tick to draw.
        elapsed: real time since the run began [s].
        width: of the terminal [characters].
        rows: available lines.
        age: of the moment, if it is too old [s].
    """
    lines = [_head(info, moment, age), _figures(info, moment, elapsed)]
    lines += tree_lines(tree, moment.seen.nodes, rows=max(3, rows - len(lines)))
    for line in lines:
        line.no_wrap = True
        line.truncate(width, overflow="ellipsis")
    return Text("\n").join(lines)


def frozen(age: float) -> str:
    """Message when no tick has come for `age` [s]."""
    return f"frozen for {in_words(age)}: the control loop stands still, the robot may be moving"


def _head(info: RunInfo, moment: Moment, age: float) -> Text:
    text = Text()
    if age:
        text.append(f" {frozen(age)} ", style="bold white on red")
        text.append(" ")
    faults = [fault.text for fault in moment.seen.state.faults]
    if faults:
        text.append(f" FAULT: {'; '.join(faults)} ", style="bold white on red")
        text.append(" ")
    if moment.paused:
        text.append(f" PAUSED {moment.paused} ", style="bold black on yellow")
        text.append(" ")
    text.append(info.task, style="bold")
    text.append(f"  {info.where}", style="bright_black")
    return text


def _figures(info: RunInfo, moment: Moment, elapsed: float) -> Text:
    text, seen = Text(), moment.seen
    if info.objects:
        done = min(_BAR, round(_BAR * moment.placed / info.objects))
        text.append("━" * done, style="green")
        text.append("━" * (_BAR - done), style="bright_black")
        text.append(f" {moment.placed} of {info.objects} placed", style="bold")
        text.append(f"  {_counted(moment.attempts, 'grasp')}  ")
    speed = f", {seen.stamp / elapsed:.1f} times real time" if elapsed > 0.0 else ""
    text.append(f"{task_time(seen.time, seen.paused_s)}{speed}", style="bright_black")
    return text


def _counted(number: int, what: str) -> str:
    return f"{number} {what}" + ("" if number == 1 else "s" if what[-1] != "s" else "es")


def tree_lines(tree: Sequence[NodeInfo], nodes: Sequence[NodeStatus], *, rows: int) -> list[Text]:
    """A line per node, as many as fit: the ancestors of the running leaf first."""
    running = tip(nodes)
    shown, states = _most_telling(tree, running, rows), looks(tree, nodes)
    lines = []
    for index in shown:
        node, status = tree[index], nodes[index]
        glyph, style = _LOOKS[states[index]]
        line = Text("  " * node.depth)
        line.append(f"{glyph} ", style=style)
        line.append(_shortened(node.title), style=f"bold {style}" if index == running else style)
        message = " ".join(status.message.split())
        if index == running:
            line.append(f"  {message}")
        elif status.status is Status.FAILURE and _is_leaf(tree, index):
            line.append(f"  {message}", style="dim")
        lines.append(line)
    if hidden := len(tree) - len(shown):
        lines[-1].append(f"   (+ {hidden} nodes)", style="bright_black")
    return lines


def _most_telling(tree: Sequence[NodeInfo], running: int, rows: int) -> list[int]:
    """Indices of the nodes to draw, in preorder, at most `rows`."""
    if len(tree) <= rows:
        return list(range(len(tree)))
    way, above = path_from_root(tree, running), parents(tree)
    beside = [i for i, parent in enumerate(above) if parent in way and i not in way]
    beside.sort(key=lambda i: (-tree[i].depth, abs(i - running)))
    return sorted([*way[-rows:], *beside[: max(0, rows - len(way))]])


def _is_leaf(tree: Sequence[NodeInfo], index: int) -> bool:
    return index + 1 == len(tree) or tree[index + 1].depth <= tree[index].depth


def _shortened(name: str) -> str:
    name = " ".join(name.split())
    return name if len(name) <= _LONGEST_NAME else name[: _LONGEST_NAME - 1] + "…"


class Changes:
    """One line for every change of a leaf, of the robot's faults, and of pauses."""

    def __init__(self, info: RunInfo, tree: Sequence[NodeInfo]) -> None:
        self._info = info
        self._leaves = [index for index in range(len(tree)) if _is_leaf(tree, index)]
        self._names = [_shortened(node.title) for node in tree]
        self._statuses = [Status.INVALID] * len(tree)
        self._faults: tuple[str, ...] = ()
        self._paused, self._placed = "", 0

    def lines(self, moment: Moment) -> Iterator[str]:
        """The lines that are new since the moment before."""
        at = f"{moment.seen.time:8.2f} s  "
        faults = tuple(fault.text for fault in moment.seen.state.faults)
        if faults != self._faults:
            yield f"{at}! {'FAULT: ' + '; '.join(faults) if faults else 'faults cleared'}"
        if moment.paused != self._paused:
            yield f"{at}‖ PAUSED {moment.paused}" if moment.paused else f"{at}▶ resumed"
        self._faults, self._paused = faults, moment.paused
        for index in self._leaves:
            before, now = self._statuses[index], moment.seen.nodes[index]
            self._statuses[index] = now.status
            if now.status is not before and (line := self._change(index, before, now)):
                yield at + line
        if moment.placed != self._placed and self._info.objects:
            yield f"{at}  {moment.placed} of {self._info.objects} placed"
        self._placed = moment.placed

    def _change(self, index: int, before: Status, now: NodeStatus) -> str:
        if now.status is Status.INVALID:
            return f"■ {self._names[index]}: halted" if before is Status.RUNNING else ""
        message = " ".join(now.message.split())
        answered_no = now.status is Status.FAILURE and before is not Status.RUNNING
        glyph = _ANSWERED_NO if answered_no else _GLYPH[now.status]
        return f"{glyph} {self._names[index]}" + (f": {message}" if message else "")
