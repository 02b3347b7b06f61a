"""Opens a real robot from its file: drivers, lock, speed limits, and emulators if emulated."""

import os
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import partial

from config import UserError
from controller import Command
from hw.clock import WallClock
from hw.composition import ComposedRobot
from hw.drivers import parts_of
from hw.hardware.arming import TooSlowError, check_armed, prove, speed_note, speed_percent, too_slow
from hw.hardware.emulation import Emulation
from hw.hardware.lock import RobotLock
from hw.registry import DEFAULT_LEVEL, Backend, WorldOptions
from hw.robot import Preparing, Robot, RobotWrapper
from hw.state import RobotState
from robots import RealRobot, at_pace, load_robot

_PRIORITY = 2  # below that of the arm's own process


class OtherWorldError(UserError):
    """The running emulators have another world."""


class CommandedRobot(RobotWrapper):
    """A robot with its lock."""

    def __init__(
        self,
        robot: Robot,
        real: RealRobot,
        lock: RobotLock,
        after: Callable[[], None],
        prepare: Callable[[], None] = lambda: None,
    ) -> None:
        super().__init__(robot)
        self._real, self._lock, self._prepare, self._after = real, lock, prepare, after
        self._has_moved = self._is_sound = False

    def connect(self) -> None:
        """Take the lock, connect every part, and prepare."""
        self._lock.take()
        _hurry(os.SCHED_FIFO)  # of this thread, and of the drivers' threads that start now
        super().connect()
        try:
            self._prepare()
        except BaseException:
            super().close()
            raise
        _hurry(os.SCHED_FIFO | os.SCHED_RESET_ON_FORK)  # but not of later threads

    def send(self, command: Command) -> Command:
        """Send a command."""
        applied = super().send(command)
        self._has_moved |= bool(applied.base_twist.any() or applied.qd.any())
        return applied

    def read(self) -> RobotState:
        """The newest reading."""
        self._is_sound = False
        state = super().read()
        self._is_sound = not state.faults
        return state

    def close(self) -> None:
        """Stop, close every part, and release the lock."""
        try:
            super().close()
            is_real = self._real.hardware.emulated is None
            if is_real and self._has_moved and self._is_sound:
                prove(self._real)
        finally:
            _hurry(os.SCHED_OTHER)
            self._lock.release()
            self._after()


def open_hardware(real: RealRobot, world: str, options: WorldOptions) -> Backend:
    """Open a real robot; start the emulators of an emulated one where they do not run.

    UserError: it is not armed, too slow, commanded by another program, or emulated in another
    world. HardwareError: the emulators do not start.
    """
    scene, seed, announce = options.scene, options.seed, options.announce
    level = options.localisation or DEFAULT_LEVEL
    check_armed(real, options.armed)
    if problem := too_slow(real):
        raise TooSlowError(problem)
    hardware, lock = real.hardware, RobotLock(real.hardware).take()
    emulation: Emulation | None = None
    try:
        if hardware.emulated is not None:
            emulation = Emulation(real, world, scene, seed, level)
            _check_world(emulation, (world, scene, seed, level))
        clock = WallClock()
        description = at_pace(load_robot(real.path), speed_percent(real) / 100.0)
        parts = parts_of(real, description, clock)
        robot = ComposedRobot(description, **parts, clock=clock, rest_together=True)
    except BaseException:
        if emulation is not None:
            emulation.close()
        lock.release()
        raise
    after = emulation.close if emulation else lambda: None
    truth = emulation.truth if emulation else None
    prepare = partial(_prepare, parts.values(), announce) if announce else lambda: None
    commanded = CommandedRobot(robot, real, lock, after, prepare)
    if announce and (note := speed_note(real)):
        announce(note)
    name = "hardware" if truth is None else "emulated"
    return Backend(robot=commanded, clock=clock, truth=truth, world=name, map=real.map)


def _prepare(parts: Iterable[object], announce: Callable[[str], None]) -> None:
    for part in parts:
        if isinstance(part, Preparing):
            part.prepare(announce)


def _check_world(emulation: Emulation, wanted: tuple[str, str, int, str]) -> None:
    truth = emulation.truth
    world, scene, seed, level = there = truth.world, truth.scene, truth.seed, truth.localisation
    if there != wanted:
        raise OtherWorldError(
            f"emulators run with --world {world} --scene {scene} --seed {seed} "
            f"--localisation {level}: say the same, or end them"
        )


def _hurry(policy: int) -> None:
    with suppress(OSError):
        priority = 0 if policy == os.SCHED_OTHER else _PRIORITY
        os.sched_setscheduler(0, policy, os.sched_param(priority))
