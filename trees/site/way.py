"""Where the base stands after the first steps of a task."""

from collections.abc import Generator, Iterator, Sequence
from math import radians
from pathlib import Path

import numpy as np
from pinocchio import SE3, utils

from behaviours import BasePose, ToolPose
from config import Diagnostic, Severity
from robots import Geom, Plane, RobotDescription
from trees.language import (
    LeafNode,
    Node,
    SubtreeNode,
    Task,
)
from trees.site.reachability import what_is_in_the_way
from trees.site.site_rules import REACH
from trees.words import all_in_order

_ARM = 1.2  # no hand reaches farther from the middle of the base [m]
_AWAY = 5.0  # a base this far from all furniture has left the room [m]
_ONCE = frozenset({"timeout_s", "retry", "while", "force"})
"""Modifiers with which a node runs to its end, if it comes to it, a single time."""


def first_drives(
    task: Task, robot: RobotDescription, fixtures: Sequence[Geom]
) -> Iterator[Diagnostic]:
    """Drives from the start of the scene that end in furniture, far outside, or too late."""
    mTb, solid = SE3.Identity(), [one for one in fixtures if not isinstance(one.shape, Plane)]
    for path, leaf in _steps(task.path, task.root):
        given, where = leaf.arguments, (path, leaf.location)
        forward, turn = given.get("forward_m", 0.0), given.get("turn_deg", 0.0)
        to = next((given[name] for name in leaf.type.goes_to if name in given), None)
        if isinstance(to, BasePose | ToolPose):
            goal, reach = (to.mTb, 0.0) if isinstance(to, BasePose) else (to.mTe, _ARM)
            way = float(np.linalg.norm((goal.translation - mTb.translation)[:2])) - reach
            limits = (given.get("timeout_s"), leaf.modifiers.get("timeout_s"))
            limit = min((one for one in limits if isinstance(one, float)), default=np.inf)
            if (least := way / float(robot.limits.base_twist[0])) > limit:
                message = f"`{leaf.name}` has {limit:g} s, and needs {least:.1f} s at full speed"
                hint = "leave its `timeout_s` out, or give it some times more"
                yield Diagnostic(REACH, *where, message, hint, Severity.WARNING)
            if reach:
                return
            mTb = goal
        elif leaf.type.key == "drive" and isinstance(forward, float) and isinstance(turn, float):
            turned = utils.rotate("z", radians(turn))
            mTb = mTb * SE3(turned, turned @ np.array([forward, 0.0, 0.0]))
            away = [np.linalg.norm((one.pose.translation - mTb.translation)[:2]) for one in solid]
            hint = "drive to a base pose, or not as far"
            if why := what_is_in_the_way(BasePose(name=leaf.name, mTb=mTb), robot, fixtures):
                message = f"`{leaf.name}` ends where it cannot stand: {why[0]}"
                yield Diagnostic(REACH, *where, message, hint)
            elif min(away, default=0.0) > _AWAY:
                message = f"`{leaf.name}` ends more than {_AWAY:g} m away from all furniture"
                yield Diagnostic(REACH, *where, message, hint, Severity.WARNING)
        elif leaf.type.moves and not leaf.type.base_rests:
            return


def _steps(path: Path, node: Node) -> Generator[tuple[Path, LeafNode], None, bool]:
    """The leaves that certainly follow each other; returns whether more may come behind them."""
    if not _ONCE.issuperset(node.modifiers) or node.modifiers.get("force") == "failure":
        return False
    if isinstance(node, SubtreeNode):
        return (yield from _steps(node.task.path, node.task.root))
    if isinstance(node, LeafNode):
        yield path, node
        return True
    if node.word.outcomes is not all_in_order:
        return False
    for child in node.children:
        if not (yield from _steps(path, child)):
            return False
    return True
