"""Choosing an object by its properties: is the one that was asked for taken?

The simulated world is the judge. After a failed attempt a neighbour is put aside on a table.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any, cast

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from py_trees.common import Status
from rich.table import Table

from app.core import Trial, VisionForm, set_up
from behaviours import (
    Detect,
    DetectedObjects,
    Grasp,
    Key,
    Leaf,
    Navigate,
    OpenGripper,
    Place,
    Recover,
    RetreatCheck,
    ToolPose,
)
from hw import Backend, SimClock, simulator
from hw.sim import World
from lab.bench.choosing_scenes import (
    ASIDE,
    CLUTTER,
    TRAY,
    TRAY_REGION,
    TrueObject,
    make_scene,
    true_object,
)
from lab.shared import Workers, percent, run_in_order
from perception import GraspDetector
from robots import Array, load_robot

ATTEMPTS = 3
_RATE = 10.0
"""Of the camera [Hz]: rendering takes most of the time."""
_SAME_AREA = 0.95
"""Of two objects whose areas have at least this ratio either may be the largest."""
_SAME_PLACE = 0.015
"""Of two objects whose distances differ by less than this either may be the nearest [m]."""
_ABOVE = ToolPose(
    name="above the tray",
    wTe=SE3(pin.rpy.rpyToMatrix(np.pi, 0.0, 0.0), np.array([TRAY[0] - 0.065, TRAY[1], 0.85])),
)
_AT_ASIDE = ToolPose(
    name="at the table",
    wTe=SE3(
        pin.rpy.rpyToMatrix(np.pi, 0.0, np.pi / 2.0),
        ASIDE.wTr.translation + np.array([0.0, -0.2, 0.25]),
    ),
)


@dataclass(frozen=True, kw_only=True)
class Taking:
    """The result of one scene."""

    seed: int
    clutter: str
    asked: str
    """The properties that were asked for."""
    objects: int
    """Number of objects in the scene."""
    counted: int
    """Number of objects detected in the first image; -1 if that failed."""
    wanted: str
    """Name of the right object, by the poses before the last attempt."""
    taken: str
    """Name of the object truly in the hand after a successful attempt; empty if none."""
    attempts: int
    put_aside: int
    """Number of neighbours put aside."""
    reason: str
    """Of the last attempt, if that failed."""

    @property
    def is_right(self) -> bool:
        """Whether the object that was asked for was taken."""
        return self.taken == self.wanted


@cache
def _detector() -> GraspDetector:
    return GraspDetector(gripper=load_robot("frankie").gripper)


def take(seed: int, *, world_name: str = "kinematic") -> Taking:
    """Build a scene, ask for an object of it, and check what the hand holds in the end.

    Args:
        seed: of the scene.
        world_name: `kinematic` or `physics`.

    Raises:
        WorldError: there is no such world, or it needs an extra.
    """
    world, clutter, request = make_scene(seed)
    described = load_robot("frankie")
    description = replace(described, camera=replace(described.camera, rate=_RATE))
    clock = SimClock()
    robot = simulator(world_name)(description, world, clock, seed=seed)
    backend = Backend(robot=robot, clock=clock, truth=world, world=world_name)
    with set_up(backend, _detector(), VisionForm.STEP) as setup:
        trial = Trial(setup)
        found: Key[DetectedObjects] = Key("found")
        context = trial.context
        trial.run(Navigate("go", context, to=_ABOVE))
        trial.run(OpenGripper("open", context))
        seen = trial.run(Detect("count", context, region=TRAY_REGION, list=found)) is Status.SUCCESS
        right: list[str] = []
        taken, reason, attempts, put_aside = "", "", 0, 0
        while True:
            attempts += 1
            objects = [true_object(obj) for obj in world.objects]
            right = matching(request.words, objects, context.state.wTb.translation)
            grasp = Grasp("grasp", context, within=TRAY_REGION, **cast(Any, request.words))
            failed = _first_failed(trial, [grasp, RetreatCheck("check", context)])
            if failed is None:
                taken, reason = _in_hand(world), ""
                break
            reason = failed.feedback_message
            if attempts == ATTEMPTS:
                break
            _come_back(trial)
            put_aside += _make_room(trial, request.words)
            _come_back(trial)
    return Taking(
        seed=seed,
        clutter=clutter,
        asked=request.kind,
        objects=len(world.objects),
        counted=len(found.read()) if seen else -1,
        wanted=taken if taken in right else next(iter(right), request.name),
        taken=taken,
        attempts=attempts,
        put_aside=put_aside,
        reason=reason,
    )


def _first_failed(trial: Trial, leaves: Iterable[Leaf]) -> Leaf | None:
    """Run leaves one after the other, as a sequence does."""
    return next((leaf for leaf in leaves if trial.run(leaf) is not Status.SUCCESS), None)


def _come_back(trial: Trial) -> None:
    context = trial.context
    back = Navigate("back", context, to=_ABOVE)
    _first_failed(trial, [Recover("recover", context), back, OpenGripper("open", context)])


def _make_room(trial: Trial, words: Mapping[str, Any]) -> bool:
    """Put a neighbour of the object on the table; whether that succeeded."""
    context = trial.context
    aside = [
        Grasp("neighbour", context, within=TRAY_REGION, neighbour=True, **words),
        RetreatCheck("check", context),
        Navigate("to the table", context, to=_AT_ASIDE),
        Place("put aside", context, on=ASIDE),
    ]
    return _first_failed(trial, aside) is None


def _in_hand(world: World) -> str:
    return next((name for name, on in world.supports().items() if on == "hand"), "")


def matching(words: Mapping[str, Any], objects: Sequence[TrueObject], base: Array) -> list[str]:
    """The names of the objects that are right, the best first.

    Args:
        words: parameters of `grasp`.
        objects: at their true poses.
        base: (3,) position of the robot's base in the world [m].
    """
    fitting = [
        one
        for one in objects
        if words.get("colour") in (None, one.colour)
        and 1000.0 * one.width >= words.get("min_width_mm", 0.0)
        and 1000.0 * one.width <= words.get("max_width_mm", np.inf)
    ]
    if not fitting:
        return []
    if words.get("choose") == "nearest":
        gaps = {one.name: float(np.linalg.norm(base[:2] - one.middle)) for one in fitting}
        least = min(gaps.values()) + _SAME_PLACE
        return sorted((name for name, gap in gaps.items() if gap < least), key=gaps.__getitem__)
    sign = -1.0 if words.get("choose") == "largest" else 1.0
    ordered = sorted(fitting, key=lambda one: sign * one.area)
    share = 0.0 if "choose" not in words else _SAME_AREA
    first = ordered[0].area
    return [one.name for one in ordered if min(one.area, first) >= share * max(one.area, first)]


def run_choosing(
    seeds: Sequence[int], done: Callable[[Taking], None], *, world: str, workers: Workers
) -> list[Taking]:
    """All scenes, in the order of their seeds; `done` is called after each."""
    simulator(world)  # raises before any scene if it is not available
    work = partial(take, world_name=world)
    return run_in_order(work, seeds, done, workers=workers, batch=1)


def choosing_table(takings: Sequence[Taking]) -> Table:
    """Shares by clutter and by what was asked for, each with its 95 % interval."""
    names = ("taken", "the right one, of those taken [%]", "of all [%]", "told apart rightly [%]")
    table = Table("scenes", "number", *names)
    groups = [("all", list(takings))]
    for clutter in CLUTTER:
        groups.append((clutter, [one for one in takings if one.clutter == clutter]))
    for asked in sorted({one.asked for one in takings}):
        groups.append((asked, [one for one in takings if one.asked == asked]))
    for name, group in groups:
        if group:
            table.add_row(
                name,
                str(len(group)),
                str(sum(bool(one.taken) for one in group)),
                percent([one.is_right for one in group if one.taken]),
                percent([one.is_right for one in group]),
                percent([one.counted == one.objects for one in group]),
            )
    return table


def choosing_notes(takings: Sequence[Taking]) -> list[str]:
    """A line for each scene in which the right object was not taken."""
    return [
        f"seed {one.seed} ({one.clutter}, {one.asked}): wanted {one.wanted}, "
        + (f"took {one.taken}" if one.taken else f"took nothing: {one.reason}")
        for one in takings
        if not one.is_right
    ]
