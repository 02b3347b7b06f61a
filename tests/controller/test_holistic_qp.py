"""The QP against solutions that were found another way."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from controller import ControllerSettings, robot_model
from controller.collision.distance_constraints import SLACK_COSTS
from controller.holistic_qp import build_qp, linearise
from controller.qp_solver import Solver
from controller.velocity_bounds import VelocityBounds
from robots import load_robot

READY = load_robot("frankie").arm.ready


def random_qps(robot: str, count: int):
    """Random but realistic QPs, with bounds that often bind."""
    rng = np.random.default_rng(5)
    model, settings = robot_model(robot), replace(ControllerSettings(), smoothness=0.0)
    for _ in range(count):
        q = rng.uniform(model.limits.q_min, model.limits.q_max)
        last = rng.uniform(-0.3, 0.3, model.n) * model.velocity_limits[1]
        bounds = VelocityBounds(model, settings)(q, last)
        linearisation = linearise(model, settings, q)
        twist, error = rng.normal(size=6), float(rng.uniform(0.0, 4.0))
        yield (
            model,
            settings,
            linearisation,
            twist,
            error,
            build_qp(model, settings, linearisation, twist, error, bounds, last),
        )


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_the_qp_without_slack_variables_is_the_papers(robot):
    """The same minimiser as eq. 6 with the slack as variables and the twist as equality."""
    for model, settings, linearisation, twist, error, qp in random_qps(robot, 5):
        n, n_base = model.n, model.n_base
        weight = 1.0 / max(error, settings.min_error)
        Q = np.diag(
            [settings.base_effort * weight] * n_base + [settings.arm_effort] * 7 + [weight] * 6
        )
        C = np.zeros(n + 6)
        C[:n] = -linearisation.gradient
        C[model.turning] -= settings.heading_gain * linearisation.heading_error
        equality = np.hstack([linearisation.J, np.eye(6)])
        start = np.concatenate([np.zeros(n), twist])
        answer = minimize(
            lambda x, Q=Q, C=C: 0.5 * x @ Q @ x + C @ x,
            start,
            jac=lambda x, Q=Q, C=C: Q @ x + C,
            bounds=[*zip(qp.lower, qp.upper, strict=True), *[(-50.0, 50.0)] * 6],
            constraints={
                "type": "eq",
                "fun": lambda x, A=equality, v=twist: A @ x - v,
                "jac": lambda x, A=equality: A,
            },
            method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 500},
        )
        x = Solver(SLACK_COSTS).solve(qp)
        np.testing.assert_allclose(x, answer.x[:n], atol=2e-4)
