"""A base that is led between things arrives, and by itself touches none of them."""

from dataclasses import dataclass, replace
from math import hypot, inf, pi

import numpy as np
import pytest
from test_floor_map import base_at, box, distance

from config.planar import Pose2D
from controller import RobotModel
from controller.floor.base_drive import drive_along
from controller.floor.floor_map import FloorMap
from controller.floor.route import Route
from controller.settings import ControllerSettings
from robots import Geom, load_robot

SETTINGS = ControllerSettings()
DT = SETTINGS.period


def robot(name: str, reverse: float) -> RobotModel:
    description = load_robot(name)
    return RobotModel(
        replace(description, limits=replace(description.limits, base_reverse=reverse))
    )


ROBOTS = {"frankie": robot("frankie", 0.25), "omni": robot("omni", 1.0)}


@dataclass
class Drive:
    """A base with limits and a lag, and how it fared."""

    arrived: bool = False
    time: float = 0.0
    clearance: float = inf
    on_the_spot: float = 0.0
    unreachable: str = ""


def drive(
    model: RobotModel,
    fixtures: tuple[Geom, ...],
    start: Pose2D,
    goal: Pose2D,
    seconds: float = 60.0,
) -> Drive:
    room, route, run = FloorMap(fixtures, model.description), Route(model, SETTINGS), Drive()
    x, y, heading = start
    axes, n = model.description.base.axes, model.n_base
    command, velocities = np.zeros(n), np.zeros(n)
    most = model.acceleration_limits[:n] * DT
    low, high = model.velocity_limits[:, :n]
    while run.time < seconds:
        here = Pose2D(x, y, heading)
        lead = route.lead(room, here, goal)
        run.unreachable = lead.unreachable
        left = goal.relative_to(here)
        run.arrived = hypot(left.x, left.y) < 0.03 and abs(left.heading) < 0.03
        if run.arrived or run.unreachable:
            break
        wanted = drive_along(model, SETTINGS, lead)
        command = np.clip(np.clip(wanted, command - most, command + most), low, high)
        velocities += (1.0 - np.exp(-DT / model.description.base.lag)) * (command - velocities)
        vx, vy, w = (axes @ velocities * DT).tolist()
        c, s = np.cos(heading + w / 2.0), np.sin(heading + w / 2.0)
        x, y, heading = x + c * vx - s * vy, y + s * vx + c * vy, heading + w
        run.on_the_spot += abs(w) if hypot(vx, vy) < 0.08 * DT else 0.0
        run.time += DT
        if round(run.time / DT) % 5 == 0:
            base = base_at(x, y, heading)
            near = (f for f in fixtures if hypot(*(f.pose.translation[:2] - [x, y])) < 4.0)
            run.clearance = min([run.clearance, *(distance(base, f) for f in near)])
    return run


def wall(x: float, y: float, dx: float, dy: float) -> Geom:
    return box(x, y, dx, dy, height=0.9)


TABLE = box(2.0, 0.0, 0.8, 1.6, height=0.5)
TWO_TABLES = (box(0, 0.95, 3.0, 0.8, height=0.5), box(0, -0.95, 3.0, 0.8, height=0.5))
CORRIDOR = tuple(
    wall(x, y, dx, 0.1) for x, dx, aside in ((0, 6, 0.6), (1, 0.1, 0.5)) for y in (aside, -aside)
)
OUTSIDE = ((0, 4.5, 8, 0.1), (0, -4.5, 8, 0.1), (4, 0, 0.1, 9), (-4, 0, 0.1, 9))
TWO_ROOMS = tuple(wall(*one) for one in ((0, 2.45, 0.1, 4), (0, -2.45, 0.1, 4), *OUTSIDE))

CASES = {
    "behind a table, facing it": ((TABLE,), (0, 0, 0), (2.8, 0, pi)),
    "out from a table": ((TABLE,), (1.2, 0, 0), (-1.5, 0, pi)),
    "table to table": ((TABLE, box(-2, 0, 0.8, 1.6, height=0.5)), (1.2, 0, 0), (-1.2, 0, pi)),
    "a stop between two tables": (TWO_TABLES, (-2.5, 0.8, 0.5), (0, 0, 0)),
    "a turn, and out of a corridor": (CORRIDOR, (-2.5, 0, 2), (4.5, 1.5, pi / 2)),
    "through a door": (TWO_ROOMS, (-2.5, 2, 1.5), (2.5, 2, -pi / 2)),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("name", ROBOTS)
def test_it_arrives_in_time_without_touching_anything(name, case):
    fixtures, start, goal = CASES[case]
    model = ROBOTS[name]
    run = drive(model, fixtures, Pose2D(*start), Pose2D(*goal))
    free = drive(model, (), Pose2D(*start), Pose2D(*goal))
    assert run.arrived
    assert run.clearance > 0.0
    assert run.time < 1.7 * free.time + 0.5


@pytest.mark.parametrize("name", ROBOTS)
def test_where_it_has_only_to_turn_and_is_a_little_near_to_something_it_turns(name):
    """It has 15 mm less than it would keep if it had the choice."""
    model = ROBOTS[name]
    room = FloorMap((wall(0, 1, 2, 0.1),), model.description)
    y = 0.95 - room.turning + 0.015
    run = drive(model, (wall(0, 1, 2, 0.1),), Pose2D(0, y, 0.0), Pose2D(-0.0005, y, 1.5))
    assert run.arrived
    assert run.clearance > 0.0
    assert run.time < 3.0


def test_where_there_is_no_way_it_says_so_and_stays():
    ring = (wall(3, 1, 2, 0.1), wall(3, -1, 2, 0.1), wall(2, 0, 0.1, 2), wall(4, 0, 0.1, 2))
    run = drive(ROBOTS["frankie"], ring, Pose2D(0, 0, 0), Pose2D(3, 0, 0))
    assert run.unreachable == "no way for the base from (0.00, 0.00) to (3.00, 0.00)"
    assert run.time < 0.5


def test_a_goal_that_creeps_keeps_its_way_and_one_that_jumps_gets_another():
    model = ROBOTS["frankie"]
    room, route = FloorMap((TABLE,), model.description), Route(model, SETTINGS)

    def time_of_the_way(goal: Pose2D) -> tuple[float, int]:
        for waited in range(20):
            lead = route.lead(room, Pose2D(0.0, 0.0, 0.0), goal)
            if lead.time_left < inf:
                return lead.time_left, waited
        raise AssertionError("no way in 20 periods")

    first, thought = time_of_the_way(Pose2D(4.0, 0.0, 0.0))
    assert thought > 0
    assert time_of_the_way(Pose2D(4.05, 0.0, 0.0)) == (first, 0)
    other, thought = time_of_the_way(Pose2D(5.0, 0.0, 0.0))
    assert thought > 0
    assert other > first + 0.3


def test_a_base_that_can_hardly_turn_leaves_its_place_first():
    chair = box(0.45, -0.36, 0.12, 0.24)
    run = drive(ROBOTS["frankie"], (chair,), Pose2D(0.0, 0.0, 0.32), Pose2D(-1.0, -2.5, -1.8))
    assert run.arrived
    assert run.clearance > 0.04
