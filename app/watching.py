"""From a tick of the session to the snapshot that recorder and status line are given."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from app.monitor import NodeInfo, NodeStatus, ObjectView, SceneView, Signals, Snapshot
from controller import PoseGoal
from trees.language import PlacedNode

if TYPE_CHECKING:
    from app.session import Tick
    from hw.sim import World


def tree_view(nodes: Sequence[PlacedNode]) -> list[NodeInfo]:
    """What a viewer needs to know of the nodes of a tree, in preorder."""
    return [
        NodeInfo(name=n.node.name, kind=str(getattr(n.node, "key", "")), depth=n.depth)
        for n in nodes
    ]


def scene_view(world: World) -> SceneView:
    """What a viewer needs to know of a simulated world."""
    objects = tuple(ObjectView(name=o.name, parts=o.parts) for o in world.objects)
    return SceneView(fixtures=world.fixtures, objects=objects)


def snapshot(tick: Tick, nodes: Sequence[PlacedNode], world: World) -> Snapshot:
    """What one tick looked like."""
    context, report, eyes = tick.context, tick.report, tick.context.eyes
    goal = context.goal
    fresh = eyes.frame is not None and eyes.frame.stamp == tick.state.stamp
    return Snapshot(
        tick=tick.number,
        stamp=tick.state.stamp,
        state=tick.state,
        command=tick.applied,
        nodes=tuple([NodeStatus(n.node.status, n.node.feedback_message) for n in nodes]),
        goal=goal.wTe if isinstance(goal, PoseGoal) else None,
        wTe=tick.state.wTb * report.bTe,
        signals=Signals(
            manipulability=report.manipulability,
            slack=report.slack,
            position_error=report.position_error,
            orientation_error=report.orientation_error,
            heading_error=report.heading_error,
            tick_ms=1000.0 * tick.seconds,
        ),
        objects=tuple([thing.pose for thing in world.objects]),
        frame=eyes.frame if fresh else None,
        detection=eyes.detection if fresh else None,
        grasp=eyes.grasp,
        locked=eyes.tracker.locked,
        blackboard={path: key.read() for path, key in context.keys.items() if key.written},
    )
