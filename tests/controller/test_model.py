"""Kinematics against numbers that were published or can be computed another way."""

import numpy as np
import pinocchio as pin
import pytest
from pinocchio import SE3

from controller import Command, RobotModel, manipulability, robot_model
from robots import load_robot, robot_names

READY = load_robot("frankie").arm.ready


@pytest.fixture(params=robot_names())
def model(request) -> RobotModel:
    return robot_model(request.param)


def random_postures(model: RobotModel, count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(
        model.limits.q_min, model.limits.q_max, size=(count, 7)
    )


def test_forward_kinematics_is_the_product_of_the_published_transforms(model):
    """The arm's modified Denavit-Hartenberg table, multiplied out by hand."""
    table = [  # a, d, alpha of the joints in order
        (0.0, 0.333, 0.0),
        (0.0, 0.0, -np.pi / 2),
        (0.0, 0.316, np.pi / 2),
        (0.0825, 0.0, np.pi / 2),
        (-0.0825, 0.384, -np.pi / 2),
        (0.0, 0.0, np.pi / 2),
        (0.088, 0.0, np.pi / 2),
    ]
    for q in random_postures(model, 20):
        T = model.description.bTa.homogeneous
        for (a, d, alpha), angle in zip(table, q, strict=True):
            ca, sa, c, s = np.cos(alpha), np.sin(alpha), np.cos(angle), np.sin(angle)
            T = T @ np.array(
                [
                    [c, -s, 0, a],
                    [s * ca, c * ca, -sa, -d * sa],
                    [s * sa, c * sa, ca, d * ca],
                    [0, 0, 0, 1],
                ]
            )
        c = np.cos(np.pi / 4)
        T = T @ np.array([[c, c, 0, 0], [-c, c, 0, 0], [0, 0, 1, 0.107 + 0.1034], [0, 0, 0, 1]])
        np.testing.assert_allclose(model.bTe(q).homogeneous, T, atol=1e-12)


def test_jacobian_is_the_derivative_of_the_pose(model):
    step = 1e-6
    for q in random_postures(model, 10):
        J = model.kinematics(q).J
        for axis in range(model.n):
            velocities = np.zeros(model.n)
            velocities[axis] = 1.0
            moved = model.command(velocities)
            ahead, behind = (
                model.end_effector(drift(moved, sign * step), q + sign * step * moved.qd)
                for sign in (1, -1)
            )
            linear = (ahead.translation - behind.translation) / (2 * step)
            angular = pin.log3(ahead.rotation @ behind.rotation.T) / (2 * step)
            np.testing.assert_allclose(J[:, axis], [*linear, *angular], atol=1e-8)


def drift(command: Command, dt: float) -> SE3:
    vx, vy, w = command.base_twist * dt
    return pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, w]))


@pytest.mark.parametrize("whole", [True, False], ids=["whole body", "arm"])
def test_manipulability_is_the_volume_of_the_ellipsoid_and_the_gradient_its_derivative(
    model, whole
):
    part = slice(0 if whole else model.n_base, None)

    def manipulable(q: np.ndarray) -> tuple[float, np.ndarray]:
        where = model.kinematics(q)
        return manipulability(where.screws[:, part], where.hessian[part, part])

    for q in random_postures(model, 10):
        m, gradient = manipulable(q)
        singular = np.linalg.svd(model.kinematics(q).J[:, part])[1]
        assert m == pytest.approx(float(np.prod(singular)), rel=1e-9)
        for joint, d in enumerate(1e-6 * np.eye(7)):
            expected = (manipulable(q + d)[0] - manipulable(q - d)[0]) / 2e-6
            assert gradient[joint - 7] == pytest.approx(expected, abs=1e-6)
        assert not whole or gradient[model.turning] == pytest.approx(0.0, abs=1e-9)


def test_a_singular_arm_has_no_gradient(model):
    m, gradient = manipulability(np.zeros((6, 7)), np.zeros((7, 7, 6)))
    assert m == 0.0
    assert not gradient.any()


@pytest.mark.parametrize(
    ("robot", "order", "turning"), [("frankie", [2, 0], 0), ("omni", [0, 1, 2], 2)]
)
def test_the_degrees_of_freedom_of_the_base_are_in_the_order_of_the_page(robot, order, turning):
    """docs/control_library.md: turn and drive, or x, y and turn; then the joints."""
    model, twist, qd = robot_model(robot), np.array([1.0, 2.0, 3.0]), np.arange(7.0)
    velocities = model.velocities(Command(base_twist=twist, qd=qd))
    np.testing.assert_array_equal(velocities, [*twist[order], *qd])
    assert model.turning == turning
