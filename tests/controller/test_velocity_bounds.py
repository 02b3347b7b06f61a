"""The bounds of every joint at every distance to its limits, against their equations."""

from dataclasses import replace

import numpy as np
import pytest

from controller import ControllerSettings, RobotModel
from controller.settings import JointLimitSettings
from controller.velocity_bounds import VelocityBounds
from robots import load_robot

FRANKIE = load_robot("frankie")
DAMPERS = JointLimitSettings(stop_distance=0.04, influence_distance=0.25)
SPANS = [0.8, 1.0, 2.4, 2.6, 3.0, 4.0, 6.0]  # of the joints [rad]


def allowed(distance: float, span: float, speed: float, brakes: bool) -> float:
    """By eq. 15 and 16, and by the speed v of which v lag + v^2 / 2a is left [rad/s]."""
    share = min(1.0, 0.4 * span)
    room = distance - 0.04 * share
    if distance <= 0.25 * share:
        speed = min(speed, room / (0.21 * share))
    if brakes:
        quadratic = [1.0 / (2.0 * FRANKIE.limits.qdd[0]), FRANKIE.arm.lag, -max(room, 0.0)]
        speed = min(speed, max(np.roots(quadratic)))
    return max(speed, -0.2)


@pytest.mark.parametrize("brakes", [True, False])
@pytest.mark.parametrize("distance", [-0.1, 0.0, 0.01, 0.03, 0.05, 0.099, 0.11, 0.249, 0.251, 0.45])
def test_a_joint_approaches_its_limits_as_its_damper_and_brakes_allow(distance, brakes):
    limits = replace(FRANKIE.limits, q_max=FRANKIE.limits.q_min + SPANS)
    model = RobotModel(replace(FRANKIE, limits=limits))
    bounds = VelocityBounds(
        model, ControllerSettings(joint_limits=DAMPERS, limit_acceleration=brakes)
    )
    expected = np.zeros(model.n)
    expected[model.n_base :] = [
        allowed(distance, *one, brakes) for one in zip(SPANS, limits.qd.tolist(), strict=True)
    ]
    upper, lower = (
        bounds.at(limits.q_max - distance, expected),
        bounds.at(limits.q_min + distance, -expected),
    )
    np.testing.assert_allclose(upper[1][model.n_base :], expected[model.n_base :], atol=1e-9)
    np.testing.assert_allclose(lower[0][model.n_base :], -expected[model.n_base :], atol=1e-9)


@pytest.mark.parametrize("last", [-1.5, -0.06, 0.0, 0.03, 1.5])
@pytest.mark.parametrize("share", [1.0, 0.999, 0.25])
def test_the_base_has_its_share_of_speed_and_nothing_accelerates_too_fast(share, last):
    model = RobotModel(FRANKIE)
    before, change = last * model.velocity_limits[1], 0.02 * model.acceleration_limits
    speeds = model.velocity_limits * ([share] * model.n_base + [1.0] * 7)
    for accelerates in (False, True):
        settings = ControllerSettings(period=0.02, limit_acceleration=accelerates)
        bounds = VelocityBounds(model, settings).at(FRANKIE.arm.ready, before, share)
        within = np.clip(speeds, before - change, before + change) if accelerates else speeds
        np.testing.assert_allclose(bounds, within)
