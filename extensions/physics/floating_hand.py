"""Hand without an arm in the physical world, to try grasps."""

from collections.abc import Callable
from math import remainder, tau

import mujoco
import numpy as np
from pinocchio import SE3, exp3, log3

from extensions.physics.mjcf import CARRIER, DOWN, TIMESTEP, hand_model_in
from extensions.physics.simulation import Simulation, addresses, between_fingers
from hw.sim import SimObject, World
from robots import Array, RobotDescription

_STILL = 0.002  # below this speed an object is at rest [m/s]; rotation counts with a lever [m]
_LEVER = 0.05
_OPENING_FORCE = 20.0  # of the fingers except at closing [N]
_TURN_RATE = 2.0  # fastest rotation of the hand [rad/s]
_INTERVAL = 0.1  # between two checks for rest [s]


class FloatingHand(Simulation):
    """The hand of a robot in a world, which keeps its direction: it turns about that alone.

    HardwareError: the simulation diverged.
    """

    def __init__(self, description: RobotDescription, world: World, wTe: SE3) -> None:
        self._wTa = SE3(wTe.rotation @ DOWN.rotation.T, np.zeros(3))
        super().__init__(hand_model_in(description, world, self._wTa), world)
        self._objects = tuple(world.objects)
        self._q, self._v = addresses(self._model, CARRIER)
        self._motors = [self._model.actuator(name).id for name in CARRIER]
        self.hardest = 0.0  # the largest contact force on the hand since `put` [N]
        self.opening = description.gripper.opening  # Between the pads of the open hand [m]
        self._speed = description.gripper.speed
        self._width_now = self.opening
        self.put(wTe, self._width_now)

    @property
    def wTe(self) -> SE3:
        """The end effector in the world."""
        x, y, z, yaw = self._data.qpos[self._q]
        aRe = exp3(np.array([0.0, 0.0, yaw])) @ DOWN.rotation
        return self._wTa * SE3(aRe, np.array([x, y, z]))

    def put(self, wTe: SE3, width: float) -> None:
        """Put the hand somewhere at rest, its pads at a width [m]."""
        goal = self._on_carrier(wTe)
        self._data.qpos[self._q] = self._data.ctrl[self._motors] = goal
        self._data.qvel[self._v] = 0.0
        self._data.qpos[self._finger_q] = width / 2.0
        self._width_now = width
        self.press(width, _OPENING_FORCE)
        mujoco.mj_forward(self._model, self._data)
        self.hardest = 0.0

    def move(self, wTe: SE3, speed: float) -> None:
        """Move the hand straight to a pose at a speed [m/s]; obstacles are only pressed."""
        start, goal = self._data.ctrl[self._motors].copy(), self._on_carrier(wTe)
        goal[3] = start[3] + remainder(goal[3] - start[3], tau)
        duration = max(
            float(np.linalg.norm(goal[:3] - start[:3])) / speed,
            abs(goal[3] - start[3]) / _TURN_RATE,
        )
        self._lead(lambda t: start + (goal - start) * _smooth(t / duration), duration)

    def shake(self, size: Array, rate: float, duration: float) -> None:
        """Shake the hand by (4,) amplitudes along x, y, z and about z of a [m, rad]; rate in Hz."""
        start = self._data.ctrl[self._motors].copy()
        phases = np.array([0.0, 0.5, 0.25, 0.75]) * np.pi

        def at(t: float) -> Array:
            envelope = min(1.0, 2.0 * t * rate, 2.0 * (duration - t) * rate)
            swing: Array = start + envelope * size * np.sin(tau * rate * t + phases)
            return swing

        self._lead(at, duration)

    def close(self, force: float, duration: float) -> None:
        """Close the fingers, each with at most a force [N], and hold for a time [s]."""
        closing = self._width_now / self._speed
        for _ in range(round((closing + duration) / TIMESTEP)):
            self._width_now = max(0.0, self._width_now - self._speed * TIMESTEP)
            self.press(self._width_now, force)
            self.step()
        self._update_objects()

    def open(self, width: float) -> None:
        """Open the fingers to a width [m]."""
        while self._width_now < width:
            self._width_now = min(width, self._width_now + self._speed * TIMESTEP)
            self.press(self._width_now, _OPENING_FORCE)
            self.step()
        self._update_objects()

    def settle(self, most: float) -> bool:
        """Wait until all objects rest, at most a time [s]; whether they do."""
        for _ in range(round(most / _INTERVAL)):
            before = [obj.pose for obj in self._objects]
            for _ in range(round(_INTERVAL / TIMESTEP)):
                self.step()
            self._update_objects()
            if all(
                _moved(a, obj.pose) < _STILL * _INTERVAL
                for a, obj in zip(before, self._objects, strict=True)
            ):
                return True
        return False

    def place(self, obj: SimObject, wTs: SE3) -> None:
        """Put an object somewhere, at rest."""
        number = self._objects.index(obj)
        self.put_object(number, wTs)
        obj.pose = wTs

    def pinched(self) -> SimObject | None:
        """The object that both fingers press on, if any."""
        return between_fingers(self.presses(None))

    def _lead(self, at: Callable[[float], Array], duration: float) -> None:
        """Command coordinates (4,) over a time [s]."""
        count = max(1, round(duration / TIMESTEP))
        for number in range(1, count + 1):
            self._data.ctrl[self._motors] = at(duration * number / count)
            self.step()
        self._update_objects()

    def step(self) -> None:
        """One `TIMESTEP`."""
        super().step()
        pressed = float(np.linalg.norm(self._data.qfrc_constraint[self._v[:3]]))
        self.hardest = max(self.hardest, pressed)

    def _on_carrier(self, wTe: SE3) -> Array:
        """(4,) x, y, z, yaw of the carrier for a pose along the approach."""
        aTe = self._wTa.actInv(wTe)
        x_axis = aTe.rotation[:, 0]
        return np.array([*aTe.translation, np.arctan2(x_axis[1], x_axis[0])])

    def _update_objects(self) -> None:
        for number, obj in enumerate(self._objects):
            obj.pose = self.object_pose(number)


def _smooth(share: float) -> float:
    return share * share * (3.0 - 2.0 * share)


def _moved(before: SE3, after: SE3) -> float:
    """How far an object moved, or turned with a lever [m]."""
    turn = float(np.linalg.norm(log3(before.rotation.T @ after.rotation)))
    return max(float(np.linalg.norm(after.translation - before.translation)), _LEVER * turn)
