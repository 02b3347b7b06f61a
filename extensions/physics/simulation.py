"""MuJoCo simulation of a gripper or robot in a world: commands, poses and contact forces."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np
from pinocchio import SE3, Quaternion

from extensions.physics.mjcf import robot_model_in
from extensions.physics.mujoco_robot import AXES, FINGER_MOTOR, SIDES, arm_names
from hw import HardwareError
from hw.sim import HELD, SimObject, Walker, World
from robots import Array, RobotDescription

_WINDUP = 0.05  # largest lead of a servo over its joint, besides its lag [rad]

mujoco.set_mju_user_warning(lambda text: None)  # else it writes a file; `step` raises instead


class Press(NamedTuple):
    """A contact force of a part of the robot, or of the held object, on an obstacle or object."""

    part: str
    side: str  # Of the hand, if it is a finger
    thing: str
    owner: SimObject | Walker | None  # the obstacle or object, if it can move
    force: float  # [N]
    towards: Array  # (3,) unit normal from the robot to it, in the world


class _Identity(NamedTuple):
    """What a geom belongs to: a part of the robot, an obstacle or an object."""

    part: str = ""  # Of the robot
    side: str = ""
    thing: str = ""  # not of the robot
    owner: SimObject | Walker | None = None


class Simulation:
    """A gripper in one world, stepped by `TIMESTEP`."""

    def __init__(self, model: mujoco.MjModel, world: World) -> None:
        self._model, self._data = model, mujoco.MjData(model)
        self._finger_q, self._finger_v = addresses(model, SIDES)
        self._gripper = model.actuator(FINGER_MOTOR).id
        frees = [f"object/{number}" for number in range(len(world.objects))]
        self._object_q, self._object_v = addresses(model, frees)
        self._coordinates = np.full((len(frees), 7), np.nan)
        self._poses = [obj.pose for obj in world.objects]
        self._geoms = [_identity(model.geom(geom), model, world) for geom in range(model.ngeom)]
        self._is_robot = np.array([bool(geom.part) for geom in self._geoms])
        self._is_of = {
            obj.name: np.array([geom.owner is obj for geom in self._geoms]) for obj in world.objects
        }

    def step(self) -> None:
        """One `TIMESTEP`; HardwareError: the simulation has diverged."""
        mujoco.mj_step(self._model, self._data)
        if (numbers := self._data.warning.number).any():
            what = mujoco.mjtWarning(int(numbers.argmax())).name.removeprefix("mjWARN_")
            raise HardwareError(f"the physical world cannot be computed any further ({what})")

    def press(self, width: float, force: float) -> None:
        """Close or open the fingers to a width [m] with at most a force of each [N]."""
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
        """Of an object in the world; the same object again while it lies still."""
        first = self._object_q[number]
        place = self._data.qpos[first : first + 7]
        if not np.array_equal(place, self._coordinates[number]):
            self._coordinates[number] = place
            w, x, y, z = place[3:]
            turn = Quaternion(w, x, y, z).normalized().toRotationMatrix()
            self._poses[number] = SE3(turn, place[:3].copy())
        return self._poses[number]

    def put_object(self, number: int, wTs: SE3) -> None:
        """Move an object, at rest but awake."""
        first, rate = self._object_q[number], self._object_v[number]
        x, y, z, w = Quaternion(wTs.rotation).coeffs()
        self._data.qpos[first : first + 7] = (*wTs.translation, w, x, y, z)
        self._data.qvel[rate : rate + 6] = (0.0, 0.0, -1e-6, 0.0, 0.0, 0.0)

    def push_object(self, number: int, xy: Array, velocity: Array) -> None:
        """Move an object horizontally, to a position (2,) with a velocity (2,) [m, m/s]."""
        first, rate = self._object_q[number], self._object_v[number]
        self._data.qpos[first : first + 2] = xy
        self._data.qvel[rate : rate + 2] = velocity

    def presses(self, held: SimObject | None) -> list[Press]:
        """Contact forces of robot and held object, except those of the held one on objects."""
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


class RobotSimulation(Simulation):
    """One robot in one world, stepped by `TIMESTEP`."""

    def __init__(self, description: RobotDescription, world: World) -> None:
        super().__init__(robot_model_in(description, world), world)
        model, data = self._model, self._data
        self._base_q, self._base_v = addresses(model, AXES)
        arm = arm_names(description)
        self._arm_q, self._arm_v = addresses(model, arm)
        self._drive = np.array([model.actuator(name).id for name in AXES])
        self._servos = np.array([model.actuator(name).id for name in arm])
        self._set_points = model.actuator_actadr[self._servos]
        self._tool = model.site("tool").id
        self._mocaps = [model.body(f"walker/{n}").mocapid[0] for n in range(len(world.walkers))]
        self._arm_lag = description.arm.lag
        data.qpos[self._arm_q] = data.act[self._set_points] = description.arm.ready
        data.ctrl[self._gripper] = description.gripper.opening
        mujoco.mj_forward(model, data)

    def drive(self, twist: Array) -> None:
        """Command a twist (3,) of the base."""
        self._data.ctrl[self._drive] = twist

    def turn(self, qd: Array) -> None:
        """Command joint velocities (j,)."""
        data = self._data
        ahead = data.qpos[self._arm_q] + self._arm_lag * data.qvel[self._arm_v]
        data.ctrl[self._servos] = qd
        data.act[self._set_points] = np.clip(
            data.act[self._set_points], ahead - _WINDUP, ahead + _WINDUP
        )

    def relax(self) -> None:
        """Hold the joints where they are, without pressing further."""
        self._data.act[self._set_points] = self._data.qpos[self._arm_q]
        self._data.ctrl[self._servos] = 0.0

    def state(self) -> tuple[list[float], list[float], Array, Array]:
        """x, y and heading of the base and their rates in the world; q (j,) and qd (j,)."""
        q, v = self._data.qpos, self._data.qvel
        base = q[self._base_q].tolist(), v[self._base_v].tolist()
        return *base, np.asarray(q[self._arm_q]), np.asarray(v[self._arm_v])

    def put_walker(self, number: int, pose: SE3) -> None:
        """Move a walker."""
        self._data.mocap_pos[self._mocaps[number]] = pose.translation

    @property
    def load(self) -> Array:
        """(j,) torques of contacts and of the held object on the arm [Nm]."""
        return np.asarray(self._data.qfrc_constraint[self._arm_v])

    def force_at_tool(self, load: Array) -> float:
        """The force at the end effector that fits torques (j,) of the arm best [N]."""
        jacobian = np.zeros((6, self._model.nv))
        mujoco.mj_jacSite(self._model, self._data, jacobian[:3], jacobian[3:], self._tool)
        wrench, *_ = np.linalg.lstsq(jacobian[:, self._arm_v].T, load, rcond=1e-2)
        return float(np.linalg.norm(wrench[:3]))


def between_fingers(presses: list[Press]) -> SimObject | None:
    """The object that both fingers press on, if any."""
    for press in presses:
        if press.side == SIDES[0] and isinstance(press.owner, SimObject):
            for other in presses:
                if other.side == SIDES[1] and other.owner is press.owner:
                    return press.owner
    return None


def addresses(model: mujoco.MjModel, joints: Sequence[str]) -> tuple[Array, Array]:
    """Addresses of the positions and of the velocities of joints."""
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
