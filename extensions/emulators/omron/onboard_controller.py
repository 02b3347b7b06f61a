"""Emulated on-board controller: modes, teleoperation by ratios, limits, emergency stop.

`ratioDrive` as in ARIA: full-scale values, dead zones, a timeout, a triple deceleration on a
reversal. Accelerations are those of the LD's drive base. Calls come from one thread.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import copysign, inf, radians, sqrt
from typing import Protocol

from config.planar import ORIGIN, Pose2D
from hw import stopwatch

BUMPED = "Bumped"  # status of a base that has hit something


@dataclass
class Teleop:
    """The section "Teleop settings" of the configuration."""

    timeout: float = 2.0  # without a new ratio for this long the base stops; 0: never [s]
    forwards: float = 1.0
    backwards: float = 0.25
    turn_at_rest: float = radians(50.0)
    turn_forwards: float = radians(25.0)
    turn_backwards: float = radians(25.0)
    dead_translation: float = 10.0
    dead_rotation: float = 5.0
    tells_forwards: float | None = None  # reported value of `forwards`, if different


@dataclass
class Motion:
    """Limits of the drive base, and the interval of set-points `latch` [s]."""

    acceleration: float = 0.5
    deceleration: float = 0.6
    turn_acceleration: float = radians(150.0)
    turn_deceleration: float = radians(200.0)
    latch: float = 0.1


class Drive(Protocol):
    """Wheels and world; called every 10 ms from the emulator's thread."""

    def command(self, v: float, w: float) -> None:
        """Move at these velocities from now on [m/s, rad/s]."""

    def pose(self) -> Pose2D:
        """True pose in the world."""

    def encoders(self) -> Pose2D:
        """Odometry, from where it was switched on."""

    def localised(self) -> Pose2D:
        """Where it takes itself to be on its map; while it is lost, anything."""

    @property
    def is_lost(self) -> bool:
        """Whether it knows that it does not know that."""

    def twist(self) -> tuple[float, float]:
        """Velocities as its wheels tell [m/s, rad/s]."""

    def echoes(self) -> Sequence[tuple[float, float]]:
        """What the laser sees now: points in the base [m]."""


class Unicycle:
    """An empty world with ideal wheels."""

    def __init__(self, pose: Pose2D = ORIGIN) -> None:
        self._at = stopwatch()
        self._pose = self._start = pose
        self._twist = (0.0, 0.0)

    def command(self, v: float, w: float) -> None:
        """Move at these velocities from now on [m/s, rad/s]."""
        self._pose = self.pose()
        self._twist = (v, w)

    def pose(self) -> Pose2D:
        """True pose."""
        (v, w), now = self._twist, stopwatch()
        dt, self._at = now - self._at, now
        self._pose = self._pose.moved(v * dt, turn=w * dt)
        return self._pose

    def encoders(self) -> Pose2D:
        """Where it has gone, exactly."""
        pose = self.pose()
        return pose.relative_to(self._start)._replace(heading=pose.heading - self._start.heading)

    def localised(self) -> Pose2D:
        """The true pose."""
        return self.pose()

    @property
    def is_lost(self) -> bool:
        """Never."""
        return False

    def twist(self) -> tuple[float, float]:
        """Commanded velocities [m/s, rad/s]."""
        return self._twist

    def echoes(self) -> Sequence[tuple[float, float]]:
        """Nothing stands there."""
        return ()


@dataclass
class Controller:
    """The state of the on-board controller; `step` moves it on."""

    drive: Drive
    teleop: Teleop = field(default_factory=Teleop)
    motion: Motion = field(default_factory=Motion)
    say: Callable[[str], None] = lambda line: None  # receives what the text interface announces
    mode: str = "Stop"
    status: str = "Stopped"
    locked: bool = False
    pressed: bool = False  # the emergency stop
    motors_on: bool = True
    clearance: Callable[[], float] = lambda: inf  # free way in front, for safe driving [m]
    direction: float = 1.0  # -1: forwards is backwards
    needs_button: bool = False  # after an emergency stop only `push_button` helps
    wanted: tuple[float, float] = (0.0, 0.0)  # current set-point [m/s, rad/s]
    moved_at: float = -inf  # when the set-point was last not zero [s]
    v: float = 0.0
    w: float = 0.0
    ratios: tuple[float, float, float] = (0.0, 0.0, 100.0)
    _ratios_at: float = -inf
    _latched_at: float = -inf
    _stepped_at: float | None = None

    def ratio_drive(self, translation: float, rotation: float, throttle: float, now: float) -> None:
        """Command ratios [%]; ignored in a locked mode, or while it comes to a stop."""
        if self.locked or not self.motors_on or self.status in ("Stopping", BUMPED):
            return
        self.ratios = (
            max(-100.0, min(100.0, translation)),
            max(-100.0, min(100.0, rotation)),
            max(0.0, min(100.0, throttle)),
        )
        self._ratios_at = now
        if self.mode != "Drive":
            self.wanted = (0.0, 0.0)
            self.mode, self.status = "Drive", "Driving"

    def stop(self) -> None:
        """Stop, unless the mode is locked."""
        if self.locked:
            return
        self.wanted = (0.0, 0.0)
        self.mode, self.status = "Stop", "Stopping"
        self.ratios = (0.0, 0.0, 100.0)

    def dock(self) -> None:
        """Dock, in a locked mode."""
        self.wanted, self.locked = (0.0, 0.0), True
        self.mode, self.status = "Dock", "Docking"

    def undock(self) -> None:
        """Leave the dock and its mode."""
        self.locked, self.mode, self.status = False, "Stop", "Stopped"

    def bump(self) -> None:
        """Hit something: the wheels stand at once, until a `stop`."""
        if self.status != BUMPED:
            self.wanted = (0.0, 0.0)
            self.v = self.w = 0.0
            self.ratios, self.status = (0.0, 0.0, 100.0), BUMPED
            self.drive.command(0.0, 0.0)
            self.say(BUMPED)

    def press(self) -> None:
        """Press the emergency stop: the wheels stand at once, the motors are off."""
        self.pressed, self.motors_on = True, False
        self.v = self.w = 0.0
        self.wanted = (0.0, 0.0)
        self.mode, self.status = "Stop", "Estop pressed"
        self.drive.command(0.0, 0.0)
        self.say("EStop pressed")
        self.say("Motors disabled")

    def release(self) -> None:
        """Release the emergency stop; the motors stay off."""
        self.pressed = False
        self.status = "Motors disabled"
        self.say("EStop relieved but motors still disabled")

    def push_button(self) -> None:
        """Switch the motors on at the base."""
        if not self.pressed and not self.motors_on:
            self.motors_on, self.mode, self.status = True, "Stop", "Stopped"
            self.say("Motors enabled")

    def enable_motors(self) -> bool:
        """Switch the motors on by a program; whether they are."""
        if not self.needs_button:
            self.push_button()
        return self.motors_on

    def step(self, now: float) -> None:
        """Advance to a time [s]."""
        dt = 0.0 if self._stepped_at is None else min(now - self._stepped_at, 0.2)
        self._stepped_at = now
        if now - self._latched_at >= self.motion.latch:
            self._latched_at = now
            self.wanted = self._set_point(now)
        if any(self.wanted):
            self.moved_at = now
        if not self.motors_on:
            return
        self.v = self._ramp(self.v, self.wanted[0], dt, turning=False)
        self.w = self._ramp(self.w, self.wanted[1], dt, turning=True)
        self.drive.command(self.v, self.w)
        if self.status == "Stopping" and self.v == self.w == 0.0:
            self.status = "Stopped"
            self.say("Stopped")

    def _set_point(self, now: float) -> tuple[float, float]:
        teleop = self.teleop
        if not self.motors_on or self.mode != "Drive":
            return (0.0, 0.0)
        if teleop.timeout and now - self._ratios_at > teleop.timeout:
            self.ratios = (0.0, 0.0, 100.0)
        translation, rotation, throttle = (one / 100.0 for one in self.ratios)
        forwards = translation > 0.0
        v = 0.0
        turn = teleop.turn_at_rest
        if abs(translation) * 100.0 > teleop.dead_translation:
            v = translation * (teleop.forwards if forwards else teleop.backwards) * throttle
            at_full = teleop.turn_forwards if forwards else teleop.turn_backwards
            turn += (at_full - turn) * abs(self.drive.twist()[0]) / teleop.forwards
        w = rotation * turn * throttle if abs(rotation) * 100.0 >= teleop.dead_rotation else 0.0
        if v > 0.0:
            free = max(0.0, self.clearance() - 0.1)
            v = min(v, sqrt(2.0 * self.motion.deceleration * free))
        return (self.direction * v, w)

    def _ramp(self, now: float, wanted: float, dt: float, *, turning: bool) -> float:
        motion = self.motion
        faster = motion.turn_acceleration if turning else motion.acceleration
        slower = motion.turn_deceleration if turning else motion.deceleration
        ratio = self.ratios[1] if turning else self.ratios[0]
        if self.mode == "Drive" and ratio * now < 0.0 and abs(ratio) > 50.0:
            slower *= 3.0
        if now * wanted < 0.0 or abs(wanted) < abs(now):
            goal = wanted if now * wanted > 0.0 else 0.0
            return now + copysign(min(slower * dt, abs(goal - now)), goal - now)
        return now + copysign(min(faster * dt, abs(wanted - now)), wanted - now)
