"""Goals of Experiment 2, and the evaluation of motions, each measure on a constructed case."""

import numpy as np
import pytest

from controller import robot_model
from lab.bench.contacts import ContactChecker
from lab.bench.goals import DISC, generate_goals
from lab.bench.motion_evaluation import (
    Evaluator,
    Failure,
    count_violations,
    cumulative_jerk,
    failure_of,
)
from lab.bench.simulated_motion import Motion
from robots import load_robot

READY = load_robot("frankie").arm.ready


ROBOTS = ("frankie", "omni")


PERIOD = 0.01


OVER_THE_BASE = np.array([0.0, -1.2, 0.0, -2.4, 0.0, 2.6, 0.8])


INTO_THE_BASE = np.array([3.0, 1.2, 0.0, -2.2, 0.0, 2.0, 0.8])


ON_ITSELF = np.array([0.0, 0.0, 0.0, -3.05, 0.0, 0.3, 0.8])


ON_THE_FLOOR = np.array([0.0, 1.7, 0.0, -1.2, 0.0, 2.4, 0.8])


def still(model, samples=10, **changes):
    """A motion that stands at READY, with some arrays replaced."""
    fields = {
        "period": PERIOD,
        "base": np.zeros((samples + 1, 3)),
        "q": np.tile(READY, (samples + 1, 1)),
        "velocities": np.zeros((samples, model.n)),
        "tool": np.zeros((samples + 1, 3)),
        "position_error": np.ones(samples + 1),
        "orientation_error": np.zeros(samples + 1),
        "solved": True,
        "arrived": False,
    }
    return Motion(**(fields | changes))


@pytest.mark.parametrize("robot", ROBOTS)
def test_contacts_with_the_arm_the_base_and_the_floor(robot):
    touches = ContactChecker(robot_model(robot))
    for q in (READY, OVER_THE_BASE, np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.1, 0.8])):
        assert not touches(q)
    assert touches(INTO_THE_BASE)
    assert touches(ON_ITSELF)
    if robot == "omni":
        assert touches(ON_THE_FLOOR)


def test_every_limit_is_checked():
    model = robot_model("frankie")
    assert count_violations(model, still(model)) == 0
    n_base, step = model.n_base, model.acceleration_limits * PERIOD
    ramp = np.minimum(np.arange(1, 501)[:, None] * step, model.velocity_limits[1])

    assert count_violations(model, still(model, 500, velocities=ramp)) == 0

    fast = ramp.copy()
    fast[400:, n_base] *= 1.0 + 1e-6
    assert count_violations(model, still(model, 500, velocities=fast)) == 100

    jump = np.zeros((10, model.n))
    jump[5:, n_base + 3] = step[n_base + 3] * 1.01
    assert count_violations(model, still(model, velocities=jump)) == 1

    drive = np.zeros((10, model.n))
    drive[0, 1] = step[1] * 1.01
    drive[1:, 1] = step[1]
    assert count_violations(model, still(model, velocities=drive)) == 1

    q = np.tile(READY, (11, 1))
    q[4, 3] = model.limits.q_max[3] + 1e-6
    assert count_violations(model, still(model, q=q)) == 1


def error_over(seconds, function):
    return np.array([function(t) for t in np.arange(0.0, seconds + PERIOD / 2, PERIOD)])


@pytest.mark.parametrize(
    ("function", "reason"),
    [
        (lambda t: 0.3, Failure.STUCK_STILL),
        (lambda t: 0.3 + 0.1 * np.sin(5.0 * t), Failure.STUCK_MOVING),
        (lambda t: 4.0 - 0.1 * t, Failure.TIME_OVER),
    ],
)
def test_why_a_goal_was_not_reached(function, reason):
    model = robot_model("frankie")
    error = error_over(20.0, function)
    assert failure_of(still(model, len(error) - 1, position_error=error)) is reason


def test_jerk_is_that_of_a_known_motion_and_an_even_motion_has_none():
    times = np.arange(0.0, 2.0, PERIOD)
    cubic = np.outer(times**3, [0.0, 2.0, 0.0])
    assert cumulative_jerk(cubic, PERIOD) == pytest.approx(12.0 * 2.0, rel=0.02)
    even = np.outer(times, [1.0, 1.0, 0.0])
    assert cumulative_jerk(even, PERIOD) == pytest.approx(np.sqrt(2.0) / PERIOD * 2.0, rel=1e-6)


def test_manipulability_and_heading_are_those_of_the_posture():
    model = robot_model("omni")
    trial = Evaluator(model)(still(model, arrived=True))
    assert trial.manipulability == pytest.approx(0.0838, abs=1e-4)
    assert trial.heading_error == pytest.approx(0.0, abs=1e-9)
    assert trial.contact_samples == 0
    assert trial.failure is None


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_goals_are_seeded_in_the_disc_above_the_floor_and_all_around(robot):
    model = robot_model(robot)
    once, longer, other = (
        generate_goals(model, count, seed) for count, seed in ((20, 3), (300, 3), (20, 4))
    )
    assert longer[:20] == once != other
    places = np.array([goal.translation for goal in longer])
    assert (places[:, 2] >= 0.05).all()
    assert (np.linalg.norm(places, axis=1) <= DISC).all()
    bearings = np.arctan2(places[:, 1], places[:, 0])
    assert (np.histogram(bearings, 4, (-np.pi, np.pi))[0] > 40).all()


def test_postures_in_contact_are_rejected(monkeypatch):
    asked = []
    plain = ContactChecker.__call__

    def ask(self, *posture):
        asked.append(plain(self, *posture))
        return asked[-1]

    monkeypatch.setattr(ContactChecker, "__call__", ask)
    assert len(generate_goals(robot_model("frankie"), 100, 0)) == 100
    assert any(asked)
    assert asked.count(False) == 100
