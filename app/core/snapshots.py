"""From a tick of the session to the snapshot that recorder, page and terminal are given."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, nan
from typing import TYPE_CHECKING

from app.live import NodeStatus, ObjectView, RegionView, SceneView, Signals, Snapshot
from behaviours import BasePose, Region, ToolPose
from controller import BaseGoal, Pose2D, PoseGoal
from hw import DepthFrame, TrueObject, Truth
from robots import Geom
from trees.language import TreeNode

if TYPE_CHECKING:
    from app.core.session import Tick


def scene_view(
    truth: Truth | None, fixtures: Sequence[Geom] = (), nodes: Sequence[TreeNode] = ()
) -> SceneView:
    """What a viewer needs to know of a world, and of the places that a tree names.

    Args:
        truth: what is known of the world, if anything.
        fixtures: what is known to stand there otherwise, as from a map.
        nodes: of the tree.
    """
    given = [value for n in nodes for value in getattr(n.node, "given", {}).values()]
    named = {
        value.name: value for value in given if isinstance(value, Region | ToolPose | BasePose)
    }
    goals = {
        name: value.wTe if isinstance(value, ToolPose) else value.wTb
        for name, value in named.items()
        if not isinstance(value, Region)
    }
    objects = _movable(truth) if truth else ()
    return SceneView(
        fixtures=tuple(truth.fixtures if truth else fixtures),
        objects=tuple(ObjectView(name=o.name, parts=o.parts) for o in objects),
        regions=tuple(
            RegionView(name=name, pose=value.wTr, size=value.size)
            for name, value in named.items()
            if isinstance(value, Region)
        ),
        goals=tuple(goals.items()),
    )


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
        goal, base_goal = context.goal, report.stance
        if isinstance(goal, BaseGoal):
            base_goal = Pose2D.of(goal.wTb)
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
                clearance=report.clearance if isfinite(report.clearance) else nan,
            ),
            objects=tuple([one.pose for one in _movable(self._truth)]) if self._truth else (),
            frame=vision.frame if is_new else None,
            detection=vision.detection if is_new else None,
            grasp=vision.grasp,
            locked=vision.tracker.locked,
            base_goal=base_goal,
            way=report.way if base_goal is not None else None,
            nearest=report.nearest,
            feels=report.feels,
            seen=None if context.seen is None else context.seen.cloud,
            blackboard={path: key.read() for path, key in context.keys.items() if key.written},
        )
