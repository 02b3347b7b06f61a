"""Where the base stands in a task: after its first steps, and where a guard asks the laser."""

from collections.abc import Generator, Iterator, Sequence
from math import radians
from pathlib import Path

import numpy as np
from pinocchio import SE3, utils

from behaviours import BasePose, Posture, Region, ToolPose
from config import Diagnostic, Severity
from controller import stance_search
from robots import Box, Geom, Plane, RobotDescription
from trees.language import (
    CompositeNode,
    LeafNode,
    Node,
    SubtreeNode,
    Task,
    all_leaves,
    is_condition,
    nodes_below,
)
from trees.site.reach import gap, what_is_in_the_way
from trees.site.rules import GUARD, REACH
from trees.words import COMPOSITES, InOrder, Outcome

_ARM = 1.2  # no hand reaches farther from the middle of the base [m]
_AWAY = 5.0  # a base this far from all furniture has left the room [m]
_BEAM = 0.005  # half the height of the plane of a laser [m]
_FAR = 100.0  # half the edge of a plane that cuts all furniture [m]
_MARGIN = 0.1  # by which the base may stand elsewhere than here [m]
_DOWN = np.diag([1.0, -1.0, -1.0])  # of a hand that looks down
_ONCE = frozenset({"timeout_s", "delay_s", "retry", "while", "force_success"})
"""Modifiers with which a node runs to its end, if it comes to it, a single time."""


def first_drives(
    task: Task, robot: RobotDescription, fixtures: Sequence[Geom]
) -> Iterator[Diagnostic]:
    """Drives from the start of the scene that end in furniture, far outside, or too late."""
    mTb = SE3.Identity()
    for path, leaf in _steps(task.path, task.root):
        given, kinds = leaf.arguments, leaf.type
        where = path, leaf.location
        to = next((given[name] for name in kinds.goes_to if name in given), None)
        posture = [Posture in kinds.parameters[name].type.named_types for name in kinds.goes_to]
        forward, turn = given.get("forward_m", 0.0), given.get("turn_deg", 0.0)
        if isinstance(to, BasePose | ToolPose):
            is_base = isinstance(to, BasePose)
            goal = (to.mTb if isinstance(to, BasePose) else to.mTe).translation
            way = float(np.linalg.norm((goal - mTb.translation)[:2])) - (0.0 if is_base else _ARM)
            limits = (given.get("timeout_s"), leaf.modifiers.get("timeout_s"))
            limit = min((one for one in limits if isinstance(one, float)), default=np.inf)
            if (least := way / float(robot.limits.base_twist[0])) > limit:
                message = f"`{leaf.name}` has {limit:g} s, and needs {least:.1f} s at full speed"
                hint = "leave its `timeout_s` out, or give it some times more"
                yield Diagnostic(REACH, *where, message, hint, Severity.WARNING)
            if not isinstance(to, BasePose):
                return
            mTb = to.mTb
        elif kinds.key == "drive" and isinstance(forward, float) and isinstance(turn, float):
            turned = utils.rotate("z", radians(turn))
            mTb = mTb * SE3(turned, turned @ np.array([forward, 0.0, 0.0]))
            here = BasePose(name=leaf.name, mTb=mTb)
            solid = [one for one in fixtures if not isinstance(one.shape, Plane)]
            away = [np.linalg.norm((one.pose.translation - mTb.translation)[:2]) for one in solid]
            hint = "drive to a base pose, or not as far"
            if why := what_is_in_the_way(here, robot, fixtures):
                message = f"`{leaf.name}` ends where it cannot stand: {why[0]}"
                yield Diagnostic(REACH, *where, message, hint)
            elif min(away, default=0.0) > _AWAY:
                message = f"`{leaf.name}` ends more than {_AWAY:g} m away from all furniture"
                yield Diagnostic(REACH, *where, message, hint, Severity.WARNING)
        elif kinds.moves and not any(posture):
            return


def _steps(path: Path, node: Node) -> Generator[tuple[Path, LeafNode], None, bool]:
    """The leaves that certainly follow each other; returns whether more may come behind them."""
    if not _ONCE.issuperset(node.modifiers):
        return False
    if isinstance(node, SubtreeNode):
        return (yield from _steps(node.task.path, node.task.root))
    if isinstance(node, LeafNode):
        yield path, node
        return True
    if COMPOSITES[node.key].outcomes != InOrder(Outcome.SUCCESS):
        return False
    for child in node.children:
        if not (yield from _steps(path, child)):
            return False
    return True


def blind_guards(
    task: Task, robot: RobotDescription, fixtures: Sequence[Geom]
) -> Iterator[Diagnostic]:
    """Guards against obstacles that furniture breaks, which the laser sees from where it works."""
    if robot.laser is None or not fixtures:
        return
    for node in nodes_below(task.root):
        if isinstance(node, SubtreeNode):
            yield from blind_guards(node.task, robot, fixtures)
        asked = [node.modifiers.get("while")]
        if isinstance(node, CompositeNode) and COMPOSITES[node.key].is_reactive:
            asked += [child for child in node.children if is_condition(child)]
        for guard in asked:
            if not isinstance(guard, CompositeNode | LeafNode):
                continue
            for distance in _kept_free(guard, True):
                for leaf in all_leaves(node):
                    if found := _seen_at_work(leaf, distance, robot, fixtures):
                        message = f"`{leaf.name}` brings the base to {found}, which the laser sees"
                        hint = "guard only the way between; what is near furniture is never free"
                        where = task.path, guard.location
                        yield Diagnostic(GUARD, *where, message, hint, Severity.WARNING)
                        break


def _kept_free(guard: Node, holds: bool) -> Iterator[float]:
    """The distances within which a guard wants no obstacle [m]."""
    if isinstance(guard, LeafNode) and guard.type.key == "obstacle_within" and not holds:
        distance = guard.arguments["distance_m"]
        yield from [distance] if isinstance(distance, float) else []
    elif isinstance(guard, CompositeNode) and guard.key in ("not", "all_of"):
        for child in guard.children:
            yield from _kept_free(child, holds != (guard.key == "not"))


def _seen_at_work(
    leaf: LeafNode, distance: float, robot: RobotDescription, fixtures: Sequence[Geom]
) -> str:
    """Where furniture is this near to the base while a leaf works, and what; empty if not."""
    assert robot.laser is not None
    beam = robot.laser.bTs.translation[2]
    for name in (*leaf.type.goes_to, *leaf.type.surfaces):
        place = leaf.arguments.get(name)
        if isinstance(place, Region):
            place = ToolPose(name=place.name, mTe=SE3(_DOWN, place.mTr.translation))
        if isinstance(place, BasePose):
            mTb = place.mTb
        elif isinstance(place, ToolPose):
            search = stance_search(robot, place.mTe, tuple(fixtures))
            search.finish()
            if search.best is None:
                continue
            x, y, heading = search.best.base_for(place.mTe)
            mTb = SE3(utils.rotate("z", heading), np.array([x, y, 0.0]))
        else:
            continue
        up = SE3(np.eye(3), np.array([0.0, 0.0, beam]))
        length, width, _ = robot.base.size
        outline = Geom(Box((length / 2.0, width / 2.0, _BEAM)), mTb * up)
        plane = Geom(Box((_FAR, _FAR, _BEAM)), up)
        for one in fixtures:
            if isinstance(one.shape, Plane) or gap(plane, one) > 0.0:
                continue
            if (near := gap(outline, one)) < distance - _MARGIN:
                return f"{max(near, 0.0):.1f} m from `{one.name}`"
    return ""
