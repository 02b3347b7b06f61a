"""From a tick of the session to the snapshot that recorder, page and status line are given."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from app.live import NodeStatus, ObjectView, SceneView, Signals, Snapshot
from controller import PoseGoal
from hw import DepthFrame, TrueObject, Truth
from trees.language import TreeNode

if TYPE_CHECKING:
    from app.core.session import Tick


def scene_view(truth: Truth | None) -> SceneView:
    """What a viewer needs to know of a world; empty where nobody knows it."""
    if truth is None:
        return SceneView()
    objects = tuple(ObjectView(name=o.name, parts=o.parts) for o in _movable(truth))
    return SceneView(fixtures=tuple(truth.fixtures), objects=objects)


def _movable(truth: Truth) -> tuple[TrueObject, ...]:
    """What has another pose from tick to tick, always in the same order."""
    return (*truth.objects, *truth.walkers)


class Snapshots:
    """Makes the snapshots of one run.

    Args:
        nodes: of the tree, in preorder.
        truth: what is known of the world, if anything.
    """

    def __init__(self, nodes: Sequence[TreeNode], truth: Truth | None) -> None:
        self._nodes = [place.node for place in nodes]
        self._truth = truth
        self._shown: DepthFrame | None = None

    def of(self, tick: Tick) -> Snapshot:
        """What one tick looked like; a frame is in the snapshot of the tick that first used it."""
        context, report, vision = tick.context, tick.report, tick.context.vision
        goal = context.goal
        is_new = vision.frame is not self._shown
        self._shown = vision.frame
        return Snapshot(
            tick=tick.number,
            stamp=tick.state.stamp,
            state=tick.state,
            command=tick.applied,
            nodes=tuple([NodeStatus(n.status, n.feedback_message) for n in self._nodes]),
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
            objects=tuple([one.pose for one in _movable(self._truth)]) if self._truth else (),
            frame=vision.frame if is_new else None,
            detection=vision.detection if is_new else None,
            grasp=vision.grasp,
            locked=vision.tracker.locked,
            blackboard={path: key.read() for path, key in context.keys.items() if key.written},
        )
