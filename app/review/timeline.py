"""Timeline of a run: the rounds of every node, and its log as it was shown."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

from py_trees.common import Status

from app.live import Changes, LogLine, NodeInfo, NodeStatus, Noted, parents
from app.review.event_log import (
    FaultEvent,
    Log,
    Node,
    NodeEvent,
    NowEvent,
    PauseEvent,
    ResumeEvent,
)


@dataclass(frozen=True)
class Span:
    """One round of a node, from its first tick to its end [s]."""

    node: int
    begin: float
    end: float
    status: str  # SUCCESS, FAILURE, INVALID if it was halted, RUNNING if it did not end
    message: str

    @property
    def seconds(self) -> float:
        """Duration [s]."""
        return self.end - self.begin

    def covers(self, other: Span) -> bool:
        """Whether the other one lies within this one."""
        return self.begin <= other.begin and other.end <= self.end


@dataclass(frozen=True)
class FaultSpan:
    """A period with a fault of the robot [s]; its end is infinite if it lasted to the end."""

    begin: float
    end: float
    text: str


@dataclass(frozen=True, kw_only=True)
class Timeline:
    """A run as spans."""

    nodes: Sequence[Node]
    parents: Sequence[int | None]
    rounds: Mapping[int, Sequence[Span]]
    faults: Sequence[FaultSpan]
    end: float  # of the last event [s]

    def children(self, node: int) -> list[int]:
        """The nodes right below one."""
        return [index for index, parent in enumerate(self.parents) if parent == node]

    def is_leaf(self, node: int) -> bool:
        """Whether there is nothing below."""
        return node not in self.parents

    def within(self, span: Span, node: int) -> list[Span]:
        """The rounds of another node during a span."""
        return [one for one in self.rounds.get(node, ()) if span.covers(one)]

    def below(self, node: int) -> list[int]:
        """All descendants of a node, in preorder."""
        found: list[int] = []
        for child in self.children(node):
            found += [child, *self.below(child)]
        return found

    def running(self) -> int | None:
        """The innermost node that was running at the last event."""
        last = [index for index, rounds in self.rounds.items() if rounds[-1].status == "RUNNING"]
        return max(last, default=None)

    def leaf_at(self, time: float) -> int | None:
        """The leaf that ran at a time [s]."""
        at_work = [
            span
            for node, rounds in self.rounds.items()
            if self.is_leaf(node)
            for span in rounds
            if span.begin <= time <= span.end
        ]
        return max(at_work, key=lambda span: (span.seconds, span.node)).node if at_work else None


def timeline(log: Log) -> Timeline:
    """The spans of a run."""
    end = log.events[-1].time
    open_spans: dict[int, tuple[float, str]] = {}
    rounds: dict[int, list[Span]] = defaultdict(list)
    faults: list[FaultSpan] = []
    fault: tuple[float, str] | None = None
    for event in log.events:
        match event:
            case NodeEvent(status="RUNNING"):
                open_spans[event.node] = event.time, event.message
            case NodeEvent(node=node, status=status):
                begun = open_spans.pop(node, None)
                if begun is not None or status != "INVALID":
                    begin, before = begun or (event.time, "")
                    message = before if status == "INVALID" else event.message
                    rounds[node].append(Span(node, begin, event.time, status, message))
            case NowEvent():
                if event.node in open_spans:
                    open_spans[event.node] = open_spans[event.node][0], event.message
            case FaultEvent():
                if fault is not None:
                    faults.append(FaultSpan(fault[0], event.time, fault[1]))
                fault = (event.time, "; ".join(event.faults)) if event.faults else None
    if fault is not None:
        faults.append(FaultSpan(fault[0], float("inf"), fault[1]))
    for node, (begin, message) in open_spans.items():
        rounds[node].append(Span(node, begin, end, "RUNNING", message))
    return Timeline(
        nodes=log.nodes, parents=parents(tree_of(log)), rounds=rounds, faults=faults, end=end
    )


def tree_of(log: Log) -> list[NodeInfo]:
    """The tree of a run for viewers."""
    return [
        NodeInfo(**one.model_dump(exclude={"path"}), depth=one.path.count("/")) for one in log.nodes
    ]


class Retold(NamedTuple):
    """A run as those who watched it saw it."""

    tree: Sequence[NodeInfo]
    nodes: Sequence[NodeStatus]  # at the end
    changes: Changes
    lines: Sequence[LogLine]


def retold(log: Log) -> Retold:
    """The log of a run as the lines that were shown while it ran."""
    tree = tree_of(log)
    changes, lines = Changes(tree), list[LogLine]()
    nodes, faults, paused = [NodeStatus(Status.INVALID, "")] * len(tree), tuple[str, ...](), ""
    for time, events in groupby(log.events, key=lambda event: event.time):
        for event in events:
            match event:
                case NodeEvent():
                    nodes[event.node] = NodeStatus(Status(event.status), event.message)
                case FaultEvent():
                    faults = tuple(event.faults)
                case PauseEvent() | ResumeEvent():
                    paused = getattr(event, "why", "")
        changes.noted.append(Noted(log.task_time(time), time, tuple(nodes), faults, paused))
        lines += changes.take()
    return Retold(tree, nodes, changes, lines)
