"""From a tick of the session to the snapshot that recorder and status line are given."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from app.live import NodeStatus, ObjectView, SceneView, Signals, Snapshot
from controller import PoseGoal
from trees.language import TreeNode

if TYPE_CHECKING:
    from app.core.session import Tick
    from hw.sim import World


def scene_view(world: World) -> SceneView:
    """What a viewer needs to know of a simulated world."""
    objects = tuple(ObjectView(name=o.name, parts=o.parts) for o in world.objects)
    return SceneView(fixtures=world.fixtures, objects=objects)


def snapshot(tick: Tick, nodes: Sequence[TreeNode], world: World) -> Snapshot:
    """What one tick looked like."""
    context, report, vision = tick.context, tick.report, tick.context.vision
    goal = context.goal
    fresh = vision.frame is not None and vision.frame.stamp == tick.state.stamp
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
        frame=vision.frame if fresh else None,
        detection=vision.detection if fresh else None,
        grasp=vision.grasp,
        locked=vision.tracker.locked,
        blackboard={path: key.read() for path, key in context.keys.items() if key.written},
    )
