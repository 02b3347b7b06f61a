"""Kinematics of a mobile manipulator: one Pinocchio chain over base and arm; its lag.

The base is a chain of virtual joints that stay at zero: poses are in the base frame.
"""

from math import exp, prod
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config.poses import Pose
from controller.command import Array, Command
from robots import RobotDescription, load_robot

_SINGULAR = 1e-9  # manipulability below which the gradient is zero

_BASE_JOINTS = (pin.JointModelPX, pin.JointModelPY, pin.JointModelRZ)


def _chain(description: RobotDescription) -> pin.Model:
    chain = pin.Model()
    joint = 0
    for number, axis in enumerate(description.base.axes.T, start=1):
        virtual = _BASE_JOINTS[int(np.argmax(axis))]
        joint = chain.addJoint(joint, virtual(), SE3.Identity(), f"base{number}")
    arm, foot = description.arm, description.bTa
    for number, (placement, slides) in enumerate(zip(arm.joints, arm.slides, strict=True), start=1):
        kind = pin.JointModelPZ if slides else pin.JointModelRZ
        joint = chain.addJoint(joint, kind(), foot * placement, f"arm{number}")
        foot = SE3.Identity()
    lTe = arm.lTh * description.gripper.hTe
    chain.addFrame(pin.Frame("tool", joint, 0, lTe, pin.FrameType.OP_FRAME))
    return chain


class Kinematics(NamedTuple):
    """Pose, Jacobian and Hessian of the end effector at one posture."""

    bTe: SE3
    J: Array  # (6, n) Jacobian at the end effector, linear first, in base axes, base first (eq. 5)
    screws: Array  # (6, n) Jacobian at the base's origin; a view that is valid until the next call
    hessian: Array  # (n, n, 6) derivative of the screws: [k, i] is that of screw i by joint k


class RobotModel:
    """Forward kinematics, Jacobian and Hessian of a mobile manipulator.

    Not thread-safe: Pinocchio's workspace is reused from call to call.
    """

    def __init__(self, description: RobotDescription) -> None:
        self.description = description
        self.name = description.name
        self.limits = description.limits
        self.n_base = description.base.axes.shape[1]
        self.n_arm = len(description.arm.joints)
        self.n = self.n_base + self.n_arm
        axes, limits = description.base.axes, description.limits
        back = np.array([limits.base_reverse, *limits.base_twist[1:]])
        self.velocity_limits = np.array(
            [
                np.concatenate([-(axes.T @ back), -limits.qd]),
                np.concatenate([axes.T @ limits.base_twist, limits.qd]),
            ]
        )
        """(2, n) lower and upper velocity of every degree of freedom, base first."""
        self.acceleration_limits = np.concatenate([axes.T @ limits.base_acceleration, limits.qdd])
        """(n,) largest acceleration of every degree of freedom, base first."""
        free = np.full(self.n_base, np.inf)
        self.position_limits = np.array([[*-free, *limits.q_min], [*free, *limits.q_max]])
        """(2, n) lower and upper positions of every degree of freedom, base first."""
        self._base_axes = axes.argmax(axis=0)
        self.turning = int(axes[2].argmax())  # the degree of freedom that turns the base
        self.chain = _chain(description)  # the Pinocchio model: base joints, then the arm's
        self._data = self.chain.createData()
        self._tool = self.chain.getFrameId("tool")
        self._bTe, self._screws = self._data.oMf[self._tool], self._data.J  # views of the data
        self._joints = np.zeros(self.n)

    def command(self, velocities: Array) -> Command:
        """The command for velocities (n,) of all degrees of freedom, base first."""
        twist = np.zeros(3)
        twist[self._base_axes] = velocities[: self.n_base]
        return Command(base_twist=twist, qd=velocities[self.n_base :])

    def velocities(self, command: Command) -> Array:
        """(n,) velocities of all degrees of freedom, base first: the inverse of `command`."""
        return np.concatenate([command.base_twist[self._base_axes], command.qd])

    def joints(self, q: Array) -> Array:
        """(n,) joint positions of the chain for arm joints q (7,): the base's are zero."""
        self._joints[self.n_base :] = q
        return self._joints

    def bTe(self, q: Array) -> SE3:
        """End effector in the base, for joint positions q (j,) [rad]."""
        pin.framesForwardKinematics(self.chain, self._data, self.joints(q))
        return self._bTe.copy()

    def end_effector(self, base: Pose, q: Array) -> Pose:
        """End effector in the frame of a base pose, for joint positions q (j,) [rad]."""
        end_effector: Pose = base * self.bTe(q)
        return end_effector

    def link_poses(self, base: Pose, q: Array) -> tuple[Pose, ...]:
        """The arm's foot, its j links and the hand in the frame of a base pose; q (j,) [rad]."""
        pin.forwardKinematics(self.chain, self._data, self.joints(q))
        arm = range(self.n_base + 1, self.n + 1)
        links = [base * self._data.oMi[joint] for joint in arm]
        return (base * self.description.bTa, *links, links[-1] * self.description.arm.lTh)

    def tool(self, q: Array) -> tuple[SE3, Array]:
        """Pose of the end effector in the base and its Jacobian, as `kinematics`."""
        chain, data, axes = self.chain, self._data, pin.LOCAL_WORLD_ALIGNED
        J = pin.computeFrameJacobian(chain, data, self.joints(q), self._tool, axes)
        pin.updateFramePlacement(chain, data, self._tool)
        return self._bTe.copy(), J

    def kinematics(self, q: Array) -> Kinematics:
        """Pose, Jacobian and Hessian of the end effector for joint positions q (j,) [rad]."""
        chain, data = self.chain, self._data
        pin.computeJointKinematicHessians(chain, data, self.joints(q))
        pin.updateFramePlacement(chain, data, self._tool)
        return Kinematics(
            self._bTe.copy(),
            pin.getFrameJacobian(chain, data, self._tool, pin.LOCAL_WORLD_ALIGNED),
            self._screws,
            # Pinocchio hands out the memory of a column-major tensor (6, n, n).
            pin.getJointKinematicHessian(chain, data, self.n, pin.WORLD).reshape(self.n, self.n, 6),
        )


def robot_model(robot: str | Path) -> RobotModel:
    """The model of a robot, by the name of a shipped one or the path of its file.

    Raises:
        ConfigError: as `load_robot` does.
    """
    return RobotModel(load_robot(robot))


def manipulability(screws: Array, hessian: Array) -> tuple[float, Array]:
    """Yoshikawa's manipulability m = sqrt(det(J Jᵀ)) and its gradient (Haviland 2022, eq. 12).

    J (6, n) are the screws of a part of the chain, `hessian` (n, n, 6) their derivative, H_k =
    hessian[k]ᵀ. The gradient (n,) is m vec(J H_kᵀ)ᵀ vec((J Jᵀ)⁻¹) for every joint k, and zero where
    that part is singular.
    """
    from scipy.linalg import lapack  # imported here: only what moves a robot needs it

    n = screws.shape[1]
    cholesky, inverse, singular = lapack.dposv(screws @ screws.T, screws)
    m = 0.0 if singular else prod(cholesky.diagonal().tolist())
    if m < _SINGULAR:
        return m, np.zeros(n)
    return m, m * (hessian.reshape(n, 6 * n) @ inverse.T.reshape(6 * n))


class Lag:
    """Predicts the velocities of a robot that follows its commands late; `period` in seconds."""

    def __init__(self, model: RobotModel, period: float) -> None:
        base, arm = model.description.base.lag, model.description.arm.lag
        n_base = self._n_base = model.n_base
        self.constants = np.array([base] * n_base + [arm] * (model.n - n_base))
        """(n,) time constants [s]."""
        self._shares = 1.0 - np.exp(-period / self.constants)
        self.response = float(self._shares[0])
        """Share of a commanded change of velocity that the base has taken up after one period."""
        self._lead = 1.0 - exp(-arm / base)
        self.commanded = self.velocities = np.zeros(model.n)
        """(n,) of the last command, and those that the robot has now."""
        self.period, self._starts = period, True

    def update(self, commanded: Array) -> None:
        """Note the velocities (n,) that were commanded in the last period."""
        before = commanded if self._starts else self.velocities
        self._starts, self.commanded = False, commanded
        self.velocities = before + self._shares * (commanded - before)

    @property
    def base(self) -> Array:
        """(n_base,) of the base once the joints have followed, if the same is commanded again."""
        now, commanded = self.velocities[: self._n_base], self.commanded[: self._n_base]
        return now + self._lead * (commanded - now)

    def surplus(self, commanded: Array) -> Array:
        """(n_base,) by which the base is faster then than it is commanded now, (n_base,)."""
        return (1.0 - self._lead) * (self.velocities[: self._n_base] - commanded)
