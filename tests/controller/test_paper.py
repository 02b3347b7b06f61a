"""The preset `paper` against the equations of the paper, written out by hand."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from motion import State
from pinocchio import SE3
from scipy.optimize import lsq_linear

from controller import PAPER, Command, ControllerSettings, HolisticController, PoseGoal, RobotModel
from controller.step_report import StepReport
from robots import load_robot, with_base_speeds

DESCRIPTIONS = {name: load_robot(name) for name in ("frankie", "omni")}


@pytest.fixture(params=sorted(DESCRIPTIONS))
def model(request) -> RobotModel:
    """With the base limits of the published example: 4 m/s and 4 rad/s."""
    robot = with_base_speeds(DESCRIPTIONS[request.param], 4.0, turn_rate=4.0)
    return RobotModel(with_base_speeds(robot, reverse=4.0))


def published_velocities(model: RobotModel, state: State, mTe: SE3) -> np.ndarray:
    """One step of the published example, before it scales its answer, in the paper's order."""
    n, nb = model.n, model.n_base
    bTe = model.bTe(state.q)
    J = jacobian_by_differences(model, state.q)
    eTg = bTe.inverse() * state.mTb.inverse() * mTe
    e = np.abs(eTg.translation).sum()
    # eq. 17: the error as translation and roll, pitch, yaw in the end effector's axes
    R = bTe.rotation
    v = 1.5 * np.concatenate([R @ eTg.translation, 1.3 * (R @ pin.rpy.matrixToRpy(eTg.rotation))])
    # λ_q (eq. 14), C (eq. 11) with Ĵ_m (eq. 12) and ε (eq. 13)
    Q = np.diag([0.01 / e] * nb + [0.01] * 7)
    c = np.zeros(n)
    c[nb:] = -manipulability_gradient_by_differences(model, state.q)
    turning = {2: 0, 3: 2}[nb]
    c[turning] = -0.5 * np.arctan2(bTe.translation[1], bTe.translation[0])
    # dampers (eq. 15, 16)
    upper, lower = np.full(n, 4.0), np.full(n, -4.0)
    upper[nb:], lower[nb:] = model.limits.qd, -model.limits.qd
    for joint in range(7):
        up = model.limits.q_max[joint] - state.q[joint]
        down = state.q[joint] - model.limits.q_min[joint]
        if up < 0.9:
            upper[nb + joint] = min(upper[nb + joint], (up - 0.1) / 0.8)
        if down < 0.9:
            lower[nb + joint] = max(lower[nb + joint], -(down - 0.1) / 0.8)
    # eq. 6 with the slack δ = ν - J q̇ put in: a bounded least-squares problem
    P, linear = Q + J.T @ J / e, c - J.T @ v / e
    L = np.linalg.cholesky(P).T
    return lsq_linear(
        L, -L @ np.linalg.solve(P, linear), (lower, upper), method="bvls", tol=1e-14
    ).x


def jacobian_by_differences(model: RobotModel, q: np.ndarray, step: float = 1e-6) -> np.ndarray:
    J = np.zeros((6, model.n))
    for axis in range(model.n):
        moved = model.command(np.eye(model.n)[axis] * step)
        vx, vy, w = moved.base_twist
        ahead, behind = (
            pin.exp6(sign * np.array([vx, vy, 0, 0, 0, w])) * model.bTe(q + sign * moved.qd)
            for sign in (1, -1)
        )
        J[:3, axis] = (ahead.translation - behind.translation) / (2 * step)
        J[3:, axis] = pin.log3(ahead.rotation @ behind.rotation.T) / (2 * step)
    return J


def manipulability_gradient_by_differences(model: RobotModel, q: np.ndarray) -> np.ndarray:
    def m(q: np.ndarray) -> float:
        J = model.kinematics(q).J[:, model.n_base :]
        return float(np.sqrt(np.linalg.det(J @ J.T)))

    return np.array([(m(q + d) - m(q - d)) / 2e-6 for d in 1e-6 * np.eye(7)])


def test_the_paper_preset_is_the_published_controller(model):
    rng = np.random.default_rng(3)
    controller = HolisticController(model, PAPER)
    limits = model.limits
    for _ in range(40):
        heading = rng.uniform(-3.0, 3.0)
        mTb = SE3(pin.utils.rotate("z", heading), np.array([*rng.uniform(-2, 2, 2), 0.0]))
        state = State(mTb=mTb, q=rng.uniform(limits.q_min + 0.11, limits.q_max - 0.11))
        mTe = SE3(pin.exp3(rng.normal(size=3)), rng.uniform(-3, 3, size=3))
        command, report = controller.step(state, PoseGoal(target=mTe), Command.stop(7))
        assert report.solved
        expected = published_velocities(model, state, mTe)
        np.testing.assert_allclose(model.velocities(command), expected, atol=1e-5)


def first_step(model: RobotModel, settings: ControllerSettings) -> tuple[np.ndarray, StepReport]:
    goal = PoseGoal(target=SE3(pin.utils.rotate("x", np.pi), np.array([2.0, 0.5, 0.6])))
    state = State(q=np.array([0.4, -0.3, 0.3, -2.2, 0.2, 2.0, 0.7]))
    command, report = HolisticController(model, settings).step(state, goal, Command.stop(7))
    return model.velocities(command), report


def test_each_choice_of_what_is_to_be_manipulable_is_another_controller(model):
    """Table III: none, the whole body, only the arm."""
    answers = [
        first_step(model, replace(PAPER, manipulability_of=choice))[0]
        for choice in ("none", "whole body", "arm")
    ]
    for one, other in ((0, 1), (0, 2), (1, 2)):
        assert np.abs(answers[one] - answers[other]).max() > 1e-4
