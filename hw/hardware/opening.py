"""A real robot from its file: drivers, lock, speeds, and emulators where it is not there."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import NamedTuple

from config import UserError
from controller import Command
from hw.clock import WallClock
from hw.composition import ComposedRobot
from hw.hardware.arming import check_armed, check_speed, prove, speed_note, speed_percent
from hw.hardware.drivers import arm_of, base_of, camera_of, hand_of
from hw.hardware.emulation import Emulation
from hw.hardware.lock import RobotLock
from hw.panda import PandaHand
from hw.robot import Robot, RobotWrapper
from hw.state import RobotState
from hw.truth import Truth
from robots import RealRobot, at_pace, load_robot

_PRIORITY = 2
"""Below that of the arm's own process."""


class OtherWorldError(UserError):
    """The emulators that run are not those that a person wants."""


class CommandedRobot(RobotWrapper):
    """A robot that one program commands.

    Args:
        robot: the parts together.
        real: what its file says.
        lock: the right to command it.
        after: done when it is closed.
        prepare: done when it is connected.
    """

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
        """Take the right to command it, connect every part, and home a hand if that is wanted."""
        self._lock.take()
        _hurry(os.SCHED_FIFO)  # this thread, and those of the drivers, which are started now
        super().connect()
        try:
            self._prepare()
        except BaseException:
            super().close()
            raise
        _hurry(os.SCHED_FIFO | os.SCHED_RESET_ON_FORK)  # but nothing that comes later

    def send(self, command: Command) -> Command:
        """Hand a command on, and tell that somebody commands."""
        self._lock.beat()
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
        """Stop, let go of every part, and of the right to command it."""
        try:
            super().close()
            is_real = self._real.hardware.emulated is None
            if is_real and self._has_moved and self._is_sound:
                prove(self._real)
        finally:
            _hurry(os.SCHED_OTHER)
            self._lock.release()
            self._after()


class OpenedHardware(NamedTuple):
    """A real robot, not yet connected."""

    robot: CommandedRobot
    clock: WallClock
    truth: Truth | None
    """Of the world of an emulated robot."""


def open_hardware(
    real: RealRobot,
    *,
    world: str,
    scene: str,
    seed: int,
    armed: bool,
    announce: Callable[[str], None] | None = None,
) -> OpenedHardware:
    """A real robot; the emulators of one that is not there are started where they do not run.

    Args:
        real: what its file says.
        world: what moves an emulated robot.
        scene: what is around it.
        seed: of that.
        armed: whether a person has said that it may move.
        announce: told how fast it moves, and before the hand is homed: that is done when the robot
            is connected, if it was not done since the hand was switched on. Without it nothing
            moves then.

    Raises:
        NotArmedError: nobody has.
        TooSlowError: the base cannot go as slowly as it is to go.
        CommandedError: another program commands it.
        OtherWorldError: emulators run with another world.
        HardwareError: the emulators do not begin.
    """
    check_armed(real, armed)
    check_speed(real)
    hardware, lock = real.hardware, RobotLock(real.hardware).take()
    emulation: Emulation | None = None
    try:
        if hardware.emulated is not None:
            emulation = Emulation(real, world, scene, seed)
            _check_world(emulation, (world, scene, seed))
    except BaseException:
        if emulation is not None:
            emulation.close()
        lock.release()
        raise
    clock = WallClock()
    hand = hand_of(hardware, clock)
    description = at_pace(load_robot(real.path), speed_percent(real) / 100.0)
    robot = ComposedRobot(
        description,
        arm=arm_of(hardware, clock),
        base=base_of(hardware, description.limits, clock),
        gripper=hand,
        camera=camera_of(hardware, description.camera, clock),
        clock=clock,
        rest_together=True,
    )
    after = emulation.close if emulation else lambda: None
    truth = emulation.truth if emulation else None
    prepare = partial(_home, hand, announce) if announce else lambda: None
    commanded = CommandedRobot(robot, real, lock, after, prepare)
    if announce and (note := speed_note(real)):
        announce(note)
    return OpenedHardware(commanded, clock, truth)


def _home(hand: PandaHand, announce: Callable[[str], None]) -> None:
    """Home a hand that needs it."""
    if not hand.reading().is_homed:
        announce("the hand was not homed since it was switched on: now its fingers close and open")
        hand.home()


def _check_world(emulation: Emulation, wanted: tuple[str, str, int]) -> None:
    truth = emulation.truth
    world, scene, seed = there = truth.world, truth.scene, truth.seed
    if there != wanted:
        raise OtherWorldError(
            f"emulators run with --world {world} --scene {scene} --seed {seed}: "
            "say the same, or end them"
        )


def _hurry(policy: int) -> None:
    """Have the system run this thread before what is in no hurry, if it lets us, or no more."""
    with suppress(OSError):
        priority = 0 if policy == os.SCHED_OTHER else _PRIORITY
        os.sched_setscheduler(0, policy, os.sched_param(priority))
