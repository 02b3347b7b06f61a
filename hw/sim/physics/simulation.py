"""Rigid bodies in MuJoCo behind plain numbers: objects, fingers, and what presses on what."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np
from pinocchio import SE3, Quaternion

from hw.robot import HardwareError
from hw.sim.physics.robot import FINGER_MOTOR, SIDES
from hw.sim.robot_shapes import HELD
from hw.sim.sim_object import SimObject
from hw.sim.walker import Walker
from hw.sim.world import World
from robots import Array

mujoco.set_mju_user_warning(lambda text: None)  # else it writes a file; `step` raises instead


class Press(NamedTuple):
    """A part of the robot presses on something, or what it holds does."""

    part: str
    side: str  # Of the hand, if it is a finger
    thing: str
    owner: SimObject | Walker | None  # What is pressed on, if it can move
    force: float  # [N]
    towards: Array  # (3,) unit normal from the robot to the thing, in the world


class _Identity(NamedTuple):
    """Who a geom belongs to."""

    part: str = ""  # Of the robot
    side: str = ""
    thing: str = ""  # That is not of the robot
    owner: SimObject | Walker | None = None


class Simulation:
    """A gripper, whatever moves it, in one world, stepped by `TIMESTEP`.

    Args:
        model: of both.
        world: as it is now.
    """

    def __init__(self, model: mujoco.MjModel, world: World) -> None:
        self._model, self._data = model, mujoco.MjData(model)
        self._finger_q, self._finger_v = addresses(model, SIDES)
        self._gripper = model.actuator(FINGER_MOTOR).id
        frees = [f"object/{number}" for number in range(len(world.objects))]
        self._object_q, self._object_v = addresses(model, frees)
        self._places = np.full((len(frees), 7), np.nan)
        self._poses = [obj.pose for obj in world.objects]
        self._geoms = [_identity(model.geom(geom), model, world) for geom in range(model.ngeom)]
        self._is_robot = np.array([bool(geom.part) for geom in self._geoms])
        self._is_of = {
            obj.name: np.array([geom.owner is obj for geom in self._geoms]) for obj in world.objects
        }

    def step(self) -> None:
        """One `TIMESTEP`.

        Raises:
            HardwareError: the motion has become impossible to compute.
        """
        mujoco.mj_step(self._model, self._data)
        if (numbers := self._data.warning.number).any():
            what = mujoco.mjtWarning(int(numbers.argmax())).name.removeprefix("mjWARN_")
            raise HardwareError(f"the physical world cannot be computed any further ({what})")

    def press(self, width: float, force: float) -> None:
        """Bring the fingers to a width [m] with at most a force of each [N], from now on."""
        self._data.ctrl[self._gripper] = width
        self._model.actuator_forcerange[self._gripper] = (-force, force)

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

    def presses(self, held: SimObject | None) -> list[Press]:
        """What robot and held object press on; objects do not count for the held one."""
        contacts = self._data.contact
        pairs, rows, is_robot = contacts.geom, contacts.efc_address, self._is_robot
        is_ours = is_robot if held is None else is_robot | self._is_of[held.name]
        found = []
        for number in np.flatnonzero(is_ours[pairs].any(axis=1) & (rows >= 0)):
            mine, other = pairs[number].tolist()
            towards = contacts.frame[number, :3].copy()
            if is_robot[other] or not is_ours[mine]:
                mine, other, towards = other, mine, -towards
            force = float(self._data.efc_force[rows[number]])
            part, side, _, _ = self._geoms[mine]
            _, _, thing, owner = self._geoms[other]
            if force > 0.0 and (part or not isinstance(owner, SimObject)):
                found.append(Press(part or HELD, side, thing, owner, force, towards))
        return found


def between_fingers(presses: list[Press]) -> SimObject | None:
    """The object that both fingers press on, if any."""
    for press in presses:
        if press.side == SIDES[0] and isinstance(press.owner, SimObject):
            for other in presses:
                if other.side == SIDES[1] and other.owner is press.owner:
                    return press.owner
    return None


def addresses(model: mujoco.MjModel, joints: Sequence[str]) -> tuple[Array, Array]:
    """Where the positions and the velocities of joints begin among those of all."""
    found = [model.joint(name) for name in joints]
    places = np.array([joint.qposadr[0] for joint in found], dtype=int)
    return places, np.array([joint.dofadr[0] for joint in found], dtype=int)


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
