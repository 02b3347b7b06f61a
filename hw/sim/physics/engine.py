"""MuJoCo behind plain numbers: what is commanded, where everything is, and what presses on what."""

from __future__ import annotations

from typing import Any, NamedTuple

import mujoco
import numpy as np
from pinocchio import SE3, Quaternion

from hw.robot import HardwareError
from hw.sim.members import HELD
from hw.sim.physics.mjcf import robot_model_in
from hw.sim.physics.robot import ARM, AXES, SIDES
from hw.sim.sim_object import SimObject
from hw.sim.walker import Walker
from hw.sim.world import World
from robots import Array, RobotDescription

_WINDUP = 0.05
"""A joint's servo may be ahead of the joint by this much more than its lag; what it cannot do is
forgotten then [rad]."""


mujoco.set_mju_user_warning(lambda text: None)  # else it writes a file; `step` raises instead


class Press(NamedTuple):
    """A part of the robot presses on something, or what it holds does."""

    part: str
    side: str
    """Of the hand, if it is a finger."""
    thing: str
    owner: SimObject | Walker | None
    """What is pressed on, if it can move."""
    force: float
    """[N]."""


class _Identity(NamedTuple):
    """Who a geom belongs to."""

    part: str = ""
    """Of the robot."""
    side: str = ""
    thing: str = ""
    """That is not of the robot."""
    owner: SimObject | Walker | None = None


class Engine:
    """One robot in one world, stepped by `TIMESTEP`.

    Args:
        description: of the robot.
        world: around it, as it is now.
    """

    def __init__(self, description: RobotDescription, world: World) -> None:
        self._model = model = robot_model_in(description, world)
        self._data = data = mujoco.MjData(model)
        joints = [model.joint(name) for name in (*AXES, *ARM, *SIDES)]
        places = np.array([joint.qposadr[0] for joint in joints])
        rates = np.array([joint.dofadr[0] for joint in joints])
        self._base_q, self._arm_q, self._finger_q = np.split(places, [3, 10])
        self._base_v, self._arm_v, self._finger_v = np.split(rates, [3, 10])
        self._drive = np.array([model.actuator(name).id for name in AXES])
        self._servos = np.array([model.actuator(name).id for name in ARM])
        self._set_points = model.actuator_actadr[self._servos]
        self._gripper = model.actuator("fingers").id
        self._tool = model.site("tool").id
        frees = [model.joint(f"object/{number}") for number in range(len(world.objects))]
        self._object_q = [free.qposadr[0] for free in frees]
        self._object_v = [free.dofadr[0] for free in frees]
        self._places = np.full((len(frees), 7), np.nan)
        self._poses = [obj.pose for obj in world.objects]
        self._mocaps = [model.body(f"walker/{n}").mocapid[0] for n in range(len(world.walkers))]
        self._geoms = [_identity(model.geom(geom), model, world) for geom in range(model.ngeom)]
        self._is_robot = np.array([bool(geom.part) for geom in self._geoms])
        self._is_of = {
            obj.name: np.array([geom.owner is obj for geom in self._geoms]) for obj in world.objects
        }
        self._arm_lag = description.arm.lag
        data.qpos[self._arm_q] = data.act[self._set_points] = description.arm.ready
        data.ctrl[self._gripper] = description.gripper.opening
        mujoco.mj_forward(model, data)

    def step(self) -> None:
        """One `TIMESTEP`.

        Raises:
            HardwareError: the motion has become impossible to compute.
        """
        mujoco.mj_step(self._model, self._data)
        if (numbers := self._data.warning.number).any():
            what = mujoco.mjtWarning(int(numbers.argmax())).name.removeprefix("mjWARN_")
            raise HardwareError(f"the physical world cannot be computed any further ({what})")

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

    def press(self, width: float, force: float) -> None:
        """Bring the fingers to a width [m] with at most a force of each [N], from now on."""
        self._data.ctrl[self._gripper] = width
        self._model.actuator_forcerange[self._gripper] = (-force, force)

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

    @property
    def width(self) -> float:
        """Between the pads [m]."""
        return float(self._data.qpos[self._finger_q].sum())

    @property
    def finger_speed(self) -> float:
        """[m/s]."""
        return float(np.abs(self._data.qvel[self._finger_v]).max())

    def object_pose(self, number: int) -> SE3:
        """Of an object in the world; the same one again while it lies still."""
        first = self._object_q[number]
        place = self._data.qpos[first : first + 7]
        if not np.array_equal(place, self._places[number]):
            self._places[number] = place
            w, x, y, z = place[3:]
            turn = Quaternion(w, x, y, z).normalized().toRotationMatrix()
            self._poses[number] = SE3(turn, place[:3].copy())
        return self._poses[number]

    def put_object(self, number: int, wTo: SE3) -> None:
        """Put an object somewhere, at rest but awake."""
        first, rate = self._object_q[number], self._object_v[number]
        x, y, z, w = Quaternion(wTo.rotation).coeffs()
        self._data.qpos[first : first + 7] = (*wTo.translation, w, x, y, z)
        self._data.qvel[rate : rate + 6] = (0.0, 0.0, -1e-6, 0.0, 0.0, 0.0)

    def push_object(self, number: int, xy: Array, velocity: Array) -> None:
        """Move an object over what carries it: to a place (2,) with a velocity (2,) [m, m/s]."""
        first, rate = self._object_q[number], self._object_v[number]
        self._data.qpos[first : first + 2] = xy
        self._data.qvel[rate : rate + 2] = velocity

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

    def presses(self, held: SimObject | None) -> list[Press]:
        """What robot and held object press on; objects do not count for the held one."""
        contacts = self._data.contact
        pairs, rows, is_robot = contacts.geom, contacts.efc_address, self._is_robot
        is_ours = is_robot if held is None else is_robot | self._is_of[held.name]
        found = []
        for number in np.flatnonzero(is_ours[pairs].any(axis=1) & (rows >= 0)):
            mine, other = pairs[number].tolist()
            if is_robot[other] or not is_ours[mine]:
                mine, other = other, mine
            force = float(self._data.efc_force[rows[number]])
            part, side, _, _ = self._geoms[mine]
            _, _, thing, owner = self._geoms[other]
            if force > 0.0 and (part or not isinstance(owner, SimObject)):
                found.append(Press(part or HELD, side, thing, owner, force))
        return found


def _identity(geom: Any, model: mujoco.MjModel, world: World) -> _Identity:
    kind, number, *_ = geom.name.split("/")
    match kind:
        case "fixture":
            return _Identity(thing=world.fixtures[int(number)].name)
        case "object":
            obj = world.objects[int(number)]
            return _Identity(thing=obj.name, owner=obj)
        case "walker":
            walker = world.walkers[int(number)]
            return _Identity(thing=walker.name, owner=walker)
        case part:
            body = model.body(geom.bodyid[0]).name
            return _Identity(part, side=body if body in SIDES else "")
