"""MuJoCo behind plain numbers: what is commanded, where everything is, and what presses on what."""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np
from pinocchio import SE3, Quaternion

from hw.sim.physics.mjcf import ARM, AXES, SIDES, robot_model_in
from hw.sim.sim_object import SimObject
from hw.sim.walker import Walker
from hw.sim.world import World
from robots import Array, RobotDescription

_WINDUP = 0.05
"""A joint's servo may be ahead of the joint by this much; more is forgotten [rad]."""
_NOBODY = -1
_PAD = "pad"


class Press(NamedTuple):
    """A part of the robot presses on something, or what it holds does."""

    part: str
    thing: str
    owner: SimObject | Walker | None
    """The thing, if it can move."""
    force: float
    """[N]."""


class Engine:
    """One robot in one world, stepped by `TIMESTEP`.

    Args:
        description: of the robot.
        world: around it, as it is now.
    """

    def __init__(self, description: RobotDescription, world: World) -> None:
        self._model = model = robot_model_in(description, world)
        self._data = data = mujoco.MjData(model)
        self._world = world
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
        self._read_names(description)
        data.qpos[self._arm_q] = data.act[self._set_points] = description.arm.ready
        data.ctrl[self._gripper] = description.gripper.opening
        mujoco.mj_forward(model, data)

    def _read_names(self, description: RobotDescription) -> None:
        """Who each geom belongs to."""
        model, world = self._model, self._world
        self._objects = [model.joint(f"object/{n}").qposadr[0] for n in range(len(world.objects))]
        self._object_v = [model.joint(f"object/{n}").dofadr[0] for n in range(len(world.objects))]
        self._trees = [
            model.body_treeid[model.body(f"object/{n}").id] for n in range(len(world.objects))
        ]
        self._mocaps = [model.body(f"walker/{n}").mocapid[0] for n in range(len(world.walkers))]
        movable = [*world.objects, *world.walkers]
        self._owners: list[SimObject | Walker | None] = []
        self._things: list[str] = []
        self._parts: list[str] = []
        for geom in range(model.ngeom):
            kind, number, *_ = model.geom(geom).name.split("/")
            owner, part, thing = None, "", ""
            if kind == "fixture":
                thing = world.fixtures[int(number)].name
            elif kind in ("object", "walker"):
                first = 0 if kind == "object" else len(world.objects)
                owner = movable[first + int(number)]
                thing = owner.name
            else:
                part = kind
            self._owners.append(owner)
            self._things.append(thing)
            self._parts.append(part)
        self._is_robot = np.array([bool(part) for part in self._parts])
        fingers = [model.body(side).id for side in SIDES]
        self._side_of = {
            geom: SIDES[fingers.index(body)]
            for geom, body in enumerate(model.geom_bodyid)
            if body in fingers
        }
        self._geoms_of = {
            id(owner): frozenset(g for g, o in enumerate(self._owners) if o is owner)
            for owner in world.objects
        }

    def step(self) -> None:
        """One `TIMESTEP`."""
        mujoco.mj_step(self._model, self._data)

    # what is commanded

    def drive(self, twist: Array) -> None:
        """Turn the wheels for a twist (3,) of the base, from now on."""
        self._data.ctrl[self._drive] = twist

    def turn(self, qd: Array) -> None:
        """Turn the joints at velocities (7,), from now on."""
        data, q = self._data, self._data.qpos[self._arm_q]
        data.ctrl[self._servos] = qd
        data.act[self._set_points] = np.clip(data.act[self._set_points], q - _WINDUP, q + _WINDUP)

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
        return self._data.qpos[self._base_q]

    @property
    def base_velocity(self) -> Array:
        """(3,) in the world [m/s, m/s, rad/s]."""
        return self._data.qvel[self._base_v]

    @property
    def q(self) -> Array:
        """(7,) of the arm [rad]."""
        return self._data.qpos[self._arm_q]

    @property
    def qd(self) -> Array:
        """(7,) of the arm [rad/s]."""
        return self._data.qvel[self._arm_v]

    @property
    def width(self) -> float:
        """Between the pads [m]."""
        return float(self._data.qpos[self._finger_q].sum())

    @property
    def finger_speed(self) -> float:
        """[m/s]."""
        return float(np.abs(self._data.qvel[self._finger_v]).max())

    def object_pose(self, number: int) -> SE3 | None:
        """Of an object in the world; None while it is asleep and has not moved."""
        if not self._data.tree_awake[self._trees[number]]:
            return None
        first = self._objects[number]
        w, x, y, z = self._data.qpos[first + 3 : first + 7]
        turn = Quaternion(w, x, y, z).normalized().toRotationMatrix()
        return SE3(turn, self._data.qpos[first : first + 3].copy())

    def put_object(self, number: int, wTo: SE3) -> None:
        """Put an object somewhere, at rest but awake."""
        first, rate = self._objects[number], self._object_v[number]
        x, y, z, w = Quaternion(wTo.rotation).coeffs()
        self._data.qpos[first : first + 7] = (*wTo.translation, w, x, y, z)
        self._data.qvel[rate : rate + 6] = (0.0, 0.0, -1e-6, 0.0, 0.0, 0.0)

    def push_object(self, number: int, xy: Array, velocity: Array) -> None:
        """Move an object over what carries it: to a place (2,) with a velocity (2,) [m, m/s]."""
        first, rate = self._objects[number], self._object_v[number]
        self._data.qpos[first : first + 2] = xy
        self._data.qvel[rate : rate + 2] = velocity

    def put_walker(self, number: int, pose: SE3) -> None:
        """Put a walker somewhere."""
        self._data.mocap_pos[self._mocaps[number]] = pose.translation

    # what presses on what

    @property
    def load(self) -> Array:
        """(7,) torques with which contacts, and what is held, press on the arm [Nm]."""
        return self._data.qfrc_constraint[self._arm_v]

    def force_at_tool(self, load: Array) -> float:
        """The force at the end effector that fits torques (7,) of the arm best [N]."""
        jacobian = np.zeros((6, self._model.nv))
        mujoco.mj_jacSite(self._model, self._data, jacobian[:3], jacobian[3:], self._tool)
        wrench, *_ = np.linalg.lstsq(jacobian[:, self._arm_v].T, load, rcond=1e-2)
        return float(np.linalg.norm(wrench[:3]))

    def presses(self, held: SimObject | None) -> list[Press]:
        """What robot and held object press on, in any order; other objects do not count for it."""
        found = []
        carried = self._geoms_of[id(held)] if held is not None else frozenset()
        for mine, other, force in self._robot_contacts(carried):
            if self._is_robot[mine]:
                owner = self._owners[other]
                found.append(Press(self._parts[mine], self._things[other], owner, force))
            elif self._owners[other] is None:
                found.append(Press("held object", self._things[other], None, force))
        return found

    def pinched(self) -> SimObject | None:
        """The object that both fingers press on, if any."""
        sides: dict[int, set[str]] = {}
        for mine, other, _ in self._robot_contacts(frozenset()):
            owner, side = self._owners[other], self._side_of.get(mine)
            if side is not None and isinstance(owner, SimObject):
                pressing = sides.setdefault(id(owner), set())
                pressing.add(side)
                if len(pressing) == len(SIDES):
                    return owner
        return None

    def _robot_contacts(self, carried: frozenset[int]) -> list[tuple[int, int, float]]:
        """Pairs of geoms that press on each other, one of the robot or what it carries first."""
        contacts = self._data.contact
        pairs, rows = contacts.geom, contacts.efc_address
        mine = self._is_robot[pairs]
        if carried:
            mine |= np.isin(pairs, list(carried))
        found = []
        for number in np.flatnonzero(mine.any(axis=1) & (rows >= 0)):
            first, second = pairs[number].tolist()
            force = float(self._data.efc_force[rows[number]])
            if force <= 0.0:
                continue
            if self._is_robot[second] or not (self._is_robot[first] or first in carried):
                first, second = second, first
            found.append((first, second, force))
        return found
