"""The kinematics of Frankie and Omni-Frankie: one Pinocchio arm on a base, and what both may do.

The arm's numbers are those of the Franka Emika Robot's published description. The base is a chain
of virtual joints before the arm, always at zero: the robot is looked at from its own base.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi, prod, sqrt
from typing import NamedTuple

import eigenpy
import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller.command import N_ARM, Array, Command

ARM_JOINTS = (
    # translation to the next joint [m], turn about x [quarter turns]
    ((0.0, 0.0, 0.333), 0),
    ((0.0, 0.0, 0.0), -1),
    ((0.0, -0.316, 0.0), 1),
    ((0.0825, 0.0, 0.0), 1),
    ((-0.0825, 0.384, 0.0), -1),
    ((0.0, 0.0, 0.0), 1),
    ((0.088, 0.0, 0.0), 1),
)
"""How each joint of the arm stands on the one before: all turn about their own z."""
LINK7_TO_HAND = SE3(pin.utils.rotate("z", -pi / 4.0), np.array([0.0, 0.0, 0.107]))
"""Seventh link of the arm to the hand."""
HAND_TO_TOOL = SE3(np.eye(3), np.array([0.0, 0.0, 0.1034]))
"""Flange of the hand to the grasp centre between the finger tips."""

_SINGULAR = 1e-9
"""Less manipulability than this has no gradient."""

READY = np.array([0.0, -0.3, 0.0, -2.2, 0.0, 2.0, pi / 4.0])
"""(7,) the arm's ready posture [rad]: hand in front, pointing down."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Limits:
    """What the robot may do; the defaults are the arm's data sheet and a careful base."""

    q_min: Array
    """(7,) lower joint positions [rad]."""
    q_max: Array
    """(7,) upper joint positions [rad]."""
    qd: Array
    """(7,) joint speeds [rad/s]."""
    qdd: Array
    """(7,) joint accelerations [rad/s^2]."""
    base_twist: Array
    """(3,) base speeds along x, y and about z [m/s, m/s, rad/s]."""
    base_reverse: float
    """Base speed along -x [m/s]."""
    base_acceleration: Array
    """(3,) base accelerations along x, y and about z [m/s^2, m/s^2, rad/s^2]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotDescription:
    """The numbers that tell one robot from another."""

    name: str
    base_axes: Array
    """(3, n_base) how the base's degrees of freedom make up its twist, in their order (eq. 4)."""
    bTa: SE3
    """Arm's foot in the base frame, on top of the base."""
    base_size: tuple[float, float]
    """Length along x and width along y of the base [m]."""
    limits: Limits


def _limits(base_twist: tuple[float, float, float]) -> Limits:
    return Limits(
        q_min=np.array([-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973]),
        q_max=np.array([2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973]),
        qd=np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61]),
        qdd=np.array([6.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0]),
        base_twist=np.array(base_twist),
        base_reverse=base_twist[0],
        base_acceleration=np.array([1.5, 1.5, 3.0]),
    )


FRANKIE = RobotDescription(
    name="frankie",
    base_axes=np.array([[0.0, 1.0], [0.0, 0.0], [1.0, 0.0]]),
    bTa=SE3(np.eye(3), np.array([0.15, 0.0, 0.38])),
    base_size=(0.70, 0.50),
    limits=_limits((1.0, 0.0, 1.05)),
)
"""Differential drive; degrees of freedom (ω, v), as in the paper."""

OMNI = RobotDescription(
    name="omni",
    base_axes=np.eye(3),
    bTa=SE3(np.eye(3), np.array([0.0, 0.0, 0.28])),
    base_size=(0.70, 0.50),
    limits=_limits((1.0, 1.0, 1.05)),
)
"""Holonomic base; degrees of freedom (vx, vy, ω)."""

ROBOTS = {robot.name: robot for robot in (FRANKIE, OMNI)}
"""The robots by name."""


def with_base_speed(
    description: RobotDescription, speed: float, turn_rate: float | None = None
) -> RobotDescription:
    """The same robot with another largest base speed [m/s] and, if given, turn rate [rad/s].

    The reverse speed keeps its ratio to the forward speed.
    """
    limits = description.limits
    drives = limits.base_twist[:2] > 0.0
    turn = limits.base_twist[2] if turn_rate is None else turn_rate
    twist = np.array([*np.where(drives, speed, 0.0), turn])
    reverse = speed * (limits.base_reverse / float(limits.base_twist[0]))
    limits = replace(limits, base_twist=twist, base_reverse=reverse)
    return replace(description, limits=limits)


_BASE_JOINTS = (pin.JointModelPX, pin.JointModelPY, pin.JointModelRZ)


def _chain(description: RobotDescription) -> pin.Model:
    """The virtual joints of the base, then the arm's, and the tool as a frame."""
    chain = pin.Model()
    joint = 0
    for number, axis in enumerate(description.base_axes.T):
        kind = _BASE_JOINTS[int(np.argmax(axis))]
        joint = chain.addJoint(joint, kind(), SE3.Identity(), f"base{number + 1}")
    for number, (translation, quarter_turns) in enumerate(ARM_JOINTS):
        placement = SE3(pin.utils.rotate("x", quarter_turns * pi / 2.0), np.array(translation))
        foot = description.bTa if number == 0 else SE3.Identity()
        joint = chain.addJoint(joint, pin.JointModelRZ(), foot * placement, f"arm{number + 1}")
    tool = pin.Frame("tool", joint, 0, LINK7_TO_HAND * HAND_TO_TOOL, pin.FrameType.OP_FRAME)
    chain.addFrame(tool)
    return chain


class Kinematics(NamedTuple):
    """Where the end effector is and how the joints move it, for one posture."""

    bTe: SE3
    J: Array
    """(6, n) Jacobian at the end effector, linear first, in base axes, base first (eq. 5)."""
    screws: Array
    """(6, n) the same at the base's origin instead, the screws of the joints; a view into
    Pinocchio's workspace that holds until the model is asked again."""
    hessian: Array
    """(n, n, 6) derivative of the screws by the joints: [k, i] is of screw i by joint k."""


class RobotModel:
    """Forward kinematics, Jacobian and Hessian of a mobile manipulator.

    Not to be shared between threads: Pinocchio's workspace is reused from call to call.

    Args:
        description: which robot.
    """

    def __init__(self, description: RobotDescription = FRANKIE) -> None:
        self.description = description
        self.name = description.name
        self.limits = description.limits
        self.n_base = description.base_axes.shape[1]
        self.n = self.n_base + N_ARM
        axes, limits = description.base_axes, description.limits
        backwards = -limits.base_twist
        backwards[0] = -limits.base_reverse
        self.velocity_limits = np.array(
            [[*axes.T @ backwards, *-limits.qd], [*axes.T @ limits.base_twist, *limits.qd]]
        )
        """(2, n) lower and upper velocities of every degree of freedom, base first."""
        self.acceleration_limits = np.concatenate([axes.T @ limits.base_acceleration, limits.qdd])
        """(n,) largest acceleration of every degree of freedom, base first."""
        free = np.full(self.n_base, np.inf)
        self.position_limits = np.array([[*-free, *limits.q_min], [*free, *limits.q_max]])
        """(2, n) lower and upper positions of every degree of freedom, base first."""
        self.base_turn = axes[2]
        """(n_base,) how much every degree of freedom of the base turns it."""
        self.chain = _chain(description)
        """The robot in Pinocchio: base joints, then the arm's."""
        self._data = self.chain.createData()
        self._tool = self.chain.getFrameId("tool")
        self._joints = np.zeros(self.n)

    def command(self, velocities: Array) -> Command:
        """The command for velocities (n,) of all degrees of freedom, base first."""
        base = self.description.base_axes @ velocities[: self.n_base]
        return Command(base_twist=base, qd=velocities[self.n_base :].copy())

    def velocities(self, command: Command) -> Array:
        """(n,) velocities of all degrees of freedom, base first: the inverse of `command`."""
        return np.concatenate([command.base_twist @ self.description.base_axes, command.qd])

    def joints(self, q: Array) -> Array:
        """(n,) positions of all joints of the chain for arm joints q (7,): the base's are zero."""
        self._joints[self.n_base :] = q
        return self._joints

    def bTe(self, q: Array) -> SE3:
        """End effector in the base, for joint positions q (7,) [rad]."""
        pin.framesForwardKinematics(self.chain, self._data, self.joints(q))
        return self._data.oMf[self._tool].copy()

    def wTe(self, wTb: SE3, q: Array) -> SE3:
        """End effector in the world, for a base pose and joint positions q (7,) [rad]."""
        return wTb * self.bTe(q)

    def link_poses(self, wTb: SE3, q: Array) -> tuple[SE3, ...]:
        """The arm's foot, its seven links and the hand in the world: 9 poses, for q (7,) [rad]."""
        pin.forwardKinematics(self.chain, self._data, self.joints(q))
        arm = range(self.n_base + 1, self.n + 1)
        links = [wTb * self._data.oMi[joint] for joint in arm]
        return (wTb * self.description.bTa, *links, links[-1] * LINK7_TO_HAND)

    def kinematics(self, q: Array) -> Kinematics:
        """Pose, Jacobian and Hessian of the end effector for joint positions q (7,) [rad]."""
        chain, data = self.chain, self._data
        pin.computeJointKinematicHessians(chain, data, self.joints(q))
        pin.updateFramePlacement(chain, data, self._tool)
        return Kinematics(
            data.oMf[self._tool].copy(),
            pin.getFrameJacobian(chain, data, self._tool, pin.LOCAL_WORLD_ALIGNED),
            data.J,
            # Pinocchio hands out the memory of a column-major tensor (6, n, n).
            pin.getJointKinematicHessian(chain, data, self.n, pin.WORLD).reshape(self.n, self.n, 6),
        )


def robot_model(name: str) -> RobotModel:
    """The model of the robot called `name`.

    Raises:
        KeyError: there is no such robot; `ROBOTS` has the names.
    """
    return RobotModel(ROBOTS[name])


def manipulability(screws: Array, hessian: Array) -> tuple[float, Array]:
    """Yoshikawa's manipulability m = sqrt(det(J Jᵀ)) and its gradient (Haviland 2022, eq. 10).

    The gradient is J_m of the paper: m vec(J H_kᵀ)ᵀ vec((J Jᵀ)⁻¹) for every joint k. Both are the
    same at whatever point of the end effector and in whatever axes J is written.

    Args:
        screws: (6, n) J of a part of the chain.
        hessian: (n, n, 6) its derivative, H_k = hessian[k]ᵀ.

    Returns:
        m and its gradient (n,) by the joints; the gradient is zero where that part is singular.
    """
    squares = eigenpy.LDLT(screws @ screws.T)
    m = sqrt(max(prod(squares.vectorD().tolist()), 0.0))
    n = screws.shape[1]
    if m < _SINGULAR:
        return m, np.zeros(n)
    return m, m * (hessian.reshape(n, 6 * n) @ squares.solve(screws).T.reshape(6 * n))
