"""What one tick of a run looked like, and the fixed things that it is read against."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from py_trees.common import Status

if TYPE_CHECKING:
    from pinocchio import SE3

    from controller import Command
    from hw import DepthFrame, RobotState
    from perception.grasp import Detection, GraspEstimate
    from robots.shapes import Geom


@dataclass(frozen=True, kw_only=True)
class NodeInfo:
    """A node of the tree; a tree is its nodes in preorder."""

    name: str
    kind: str
    """Its key in a task file, for example `sequence` or `navigate`."""
    depth: int
    """Number of ancestors; 0 at the root."""


class NodeStatus(NamedTuple):
    """How a node of the tree stands.

    A tuple, because every tick makes one a node: a frozen dataclass takes four times as long.
    """

    status: Status
    message: str
    """What it says about that; may be empty."""


@dataclass(frozen=True, kw_only=True)
class Signals:
    """How the controller and the loop fared in one tick; NaN where there is nothing to tell."""

    manipulability: float
    """Yoshikawa's measure of the arm."""
    slack: float
    """Norm of what the goal's twist had to give up [m/s, rad/s]."""
    position_error: float
    """End effector to goal [m]."""
    orientation_error: float
    """End effector to goal [rad]."""
    heading_error: float
    """Base's heading to the goal's bearing [rad]."""
    tick_ms: float
    """Time that the tick took to compute [ms]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Snapshot:
    """Everything a viewer is told about one tick."""

    tick: int
    stamp: float
    """On the session's clock [s]."""
    state: RobotState
    command: Command
    """As sent."""
    nodes: tuple[NodeStatus, ...]
    """One a node, in preorder."""
    goal: SE3 | None
    """Desired end-effector pose in the world, if there is one."""
    wTe: SE3
    """End effector in the world."""
    signals: Signals
    objects: tuple[SE3, ...] = ()
    """Poses in the world of the simulated objects, as `SceneView.objects`."""
    frame: DepthFrame | None = None
    """The depth image that arrived in this tick, ..."""
    detection: Detection | None = None
    """... and what was found in it."""
    grasp: GraspEstimate | None = None
    """The grasp that is being tracked."""
    locked: bool = False
    """Whether that grasp no longer moves."""
    blackboard: Mapping[str, object] = field(default_factory=dict)
    """What the nodes of the tree have written down for each other."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ObjectView:
    """What an object looks like."""

    name: str
    parts: tuple[Geom, ...]
    """In the object's frame."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SceneView:
    """What the world looks like; empty where it is not known."""

    fixtures: tuple[Geom, ...] = ()
    """In the world."""
    objects: tuple[ObjectView, ...] = ()


def parents(tree: Sequence[NodeInfo]) -> tuple[int | None, ...]:
    """Index of each node's parent; None for the root."""
    found: list[int | None] = []
    path: list[int] = []
    for index, node in enumerate(tree):
        del path[node.depth :]
        found.append(path[-1] if path else None)
        path.append(index)
    return tuple(found)


def tip(nodes: Sequence[NodeStatus]) -> int:
    """Index of the node that made the root's status: the last in preorder that shares it.

    That is the root itself before the first tick.
    """
    root = nodes[0].status
    if root == Status.INVALID:
        return 0
    return max(index for index, node in enumerate(nodes) if node.status == root)


def branch(tree: Sequence[NodeInfo], index: int) -> tuple[int, ...]:
    """Indices from the root down to a node, both included."""
    above = parents(tree)
    path = [index]
    while (parent := above[path[-1]]) is not None:
        path.append(parent)
    return tuple(reversed(path))
