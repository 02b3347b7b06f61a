"""What every node did and when: the events of a run put together to spans of time."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from app.review.event_log import (
    FaultEvent,
    Log,
    Node,
    NodeEvent,
    NowEvent,
)


@dataclass(frozen=True, kw_only=True)
class Span:
    """One round of a node, from its first tick to its end."""

    node: int
    begin: float
    end: float
    """[s]; of what was still running, the last event."""
    status: str
    """How it ended: SUCCESS, FAILURE, INVALID where it was halted, RUNNING where nothing ended."""
    message: str
    values: Mapping[str, float] = field(default_factory=dict)
    """Key figures when it failed."""

    @property
    def seconds(self) -> float:
        """How long it took."""
        return self.end - self.begin

    def covers(self, other: Span) -> bool:
        """Whether the other one lies within this one."""
        return self.begin <= other.begin and other.end <= self.end


@dataclass(frozen=True, kw_only=True)
class FaultSpan:
    """The robot could not move."""

    begin: float
    end: float
    """[s]; infinite if it was so at the last event."""
    text: str


@dataclass(frozen=True, kw_only=True)
class Timeline:
    """A run as spans."""

    nodes: Sequence[Node]
    parents: Sequence[int | None]
    rounds: Mapping[int, Sequence[Span]]
    """Of every node, in order of time."""
    faults: Sequence[FaultSpan]
    end: float
    """Of the last event [s]."""

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
        """All nodes below one, in preorder."""
        found: list[int] = []
        for child in self.children(node):
            found += [child, *self.below(child)]
        return found

    def running(self) -> int | None:
        """The innermost node that was running at the last event."""
        last = [index for index, rounds in self.rounds.items() if rounds[-1].status == "RUNNING"]
        return max(last, default=None)

    def leaf_at(self, time: float) -> int | None:
        """The leaf that was at work at a time."""
        at_work = [
            span
            for node, rounds in self.rounds.items()
            if self.is_leaf(node)
            for span in rounds
            if span.begin <= time <= span.end
        ]
        return max(at_work, key=lambda span: (span.seconds, span.node)).node if at_work else None


def timeline(log: Log) -> Timeline:
    """The events of a run as spans."""
    end = log.events[-1].time
    open_spans: dict[int, tuple[float, str]] = {}
    rounds: dict[int, list[Span]] = defaultdict(list)
    faults: list[FaultSpan] = []
    fault: tuple[float, str] | None = None
    for event in log.events:
        match event:
            case NodeEvent(status="RUNNING"):
                open_spans[event.node] = event.time, event.message
            case NodeEvent():
                begun = open_spans.pop(event.node, None)
                if begun is not None or event.status != "INVALID":
                    begin, message = begun or (event.time, "")
                    rounds[event.node].append(
                        Span(
                            node=event.node,
                            begin=begin,
                            end=event.time,
                            status=event.status,
                            message=message if event.status == "INVALID" else event.message,
                            values=event.values,
                        )
                    )
            case NowEvent():
                if event.node in open_spans:
                    open_spans[event.node] = open_spans[event.node][0], event.message
            case FaultEvent():
                if fault is not None:
                    faults.append(FaultSpan(begin=fault[0], end=event.time, text=fault[1]))
                fault = (event.time, "; ".join(event.faults)) if event.faults else None
    if fault is not None:
        faults.append(FaultSpan(begin=fault[0], end=float("inf"), text=fault[1]))
    for node, (begin, message) in open_spans.items():
        rounds[node].append(
            Span(node=node, begin=begin, end=end, status="RUNNING", message=message)
        )
    return Timeline(
        nodes=log.nodes,
        parents=_parents(log.nodes),
        rounds=dict(rounds),
        faults=faults,
        end=end,
    )


def _parents(nodes: Sequence[Node]) -> list[int | None]:
    """Index of each node's parent, which comes before it; a path is the parent's, `/`, a name."""
    known = {node.path: index for index, node in reversed(list(enumerate(nodes)))}
    above = [known.get(node.path.rpartition("/")[0], 0) for node in nodes]
    return [None if i == 0 else parent if parent < i else 0 for i, parent in enumerate(above)]
