"""The robot in MuJoCo behind plain numbers: what is commanded, and where it is."""

from __future__ import annotations

import mujoco
import numpy as np
from pinocchio import SE3

from hw.sim.physics.mjcf import robot_model_in
from hw.sim.physics.robot import ARM, AXES
from hw.sim.physics.simulation import Simulation, addresses
from hw.sim.world import World
from robots import Array, RobotDescription

_WINDUP = 0.05
"""A joint's servo may be ahead of the joint by this much more than its lag; what it cannot do is
forgotten then [rad]."""


class Engine(Simulation):
    """One robot in one world, stepped by `TIMESTEP`.

    Args:
        description: of the robot.
        world: around it, as it is now.
    """

    def __init__(self, description: RobotDescription, world: World) -> None:
        super().__init__(robot_model_in(description, world), world)
        model, data = self._model, self._data
        self._base_q, self._base_v = addresses(model, AXES)
        self._arm_q, self._arm_v = addresses(model, ARM)
        self._drive = np.array([model.actuator(name).id for name in AXES])
        self._servos = np.array([model.actuator(name).id for name in ARM])
        self._set_points = model.actuator_actadr[self._servos]
        self._tool = model.site("tool").id
        self._mocaps = [model.body(f"walker/{n}").mocapid[0] for n in range(len(world.walkers))]
        self._arm_lag = description.arm.lag
        data.qpos[self._arm_q] = data.act[self._set_points] = description.arm.ready
        data.ctrl[self._gripper] = description.gripper.opening
        mujoco.mj_forward(model, data)

    # what is commanded

    def drive(self, twist: Array) -> None:
        """Turn the wheels for a twist (3,) of the base, from now on."""
        self._data.ctrl[self._drive] = twist

    def turn(self, qd: Array) -> None:
        """Turn the joints at velocities (7,), from now on."""
        data = self._data
        ahead = data.qpos[self._arm_q] + self._arm_lag * data.qvel[self._arm_v]
        data.ctrl[self._servos] = qd
        data.act[self._set_points] = np.clip(
            data.act[self._set_points], ahead - _WINDUP, ahead + _WINDUP
        )

    def relax(self) -> None:
        """Press no further with the arm: its joints hold where they are."""
        self._data.act[self._set_points] = self._data.qpos[self._arm_q]
        self._data.ctrl[self._servos] = 0.0

    # where everything is

    @property
    def base(self) -> Array:
        """(3,) x, y, heading [m, m, rad]."""
        values: Array = self._data.qpos[self._base_q]
        return values

    @property
    def base_velocity(self) -> Array:
        """(3,) in the world [m/s, m/s, rad/s]."""
        values: Array = self._data.qvel[self._base_v]
        return values

    @property
    def q(self) -> Array:
        """(7,) of the arm [rad]."""
        values: Array = self._data.qpos[self._arm_q]
        return values

    @property
    def qd(self) -> Array:
        """(7,) of the arm [rad/s]."""
        values: Array = self._data.qvel[self._arm_v]
        return values

    def put_walker(self, number: int, pose: SE3) -> None:
        """Put a walker somewhere."""
        self._data.mocap_pos[self._mocaps[number]] = pose.translation

    # what presses on what

    @property
    def load(self) -> Array:
        """(7,) torques with which contacts, and what is held, press on the arm [Nm]."""
        values: Array = self._data.qfrc_constraint[self._arm_v]
        return values

    def force_at_tool(self, load: Array) -> float:
        """The force at the end effector that fits torques (7,) of the arm best [N]."""
        jacobian = np.zeros((6, self._model.nv))
        mujoco.mj_jacSite(self._model, self._data, jacobian[:3], jacobian[3:], self._tool)
        wrench, *_ = np.linalg.lstsq(jacobian[:, self._arm_v].T, load, rcond=1e-2)
        return float(np.linalg.norm(wrench[:3]))
