"""Opens a real robot from its file: drivers, lock and speed limits."""

from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack, nullcontext

from controller import Command
from hw.clock import WallClock
from hw.composition import ComposedRobot
from hw.hardware.arming import TooSlowError, check_armed, prove, speed_note, speed_percent, too_slow
from hw.hardware.lock import RobotLock
from hw.real_parts import parts_of
from hw.robot import Preparing, Robot, RobotWrapper
from hw.state import RobotState
from hw.system import run_at
from hw.truth import Knowing, Truth
from hw.worlds import Backend, WorldOptions
from robots import RealRobot, at_pace, load_real_robot, load_robot

_PRIORITY = 2  # below that of the arm's own process


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
        run_at(_PRIORITY)  # of this thread, and of the drivers' threads that start now
        super().connect()
        try:
            self._prepare()
        except BaseException:
            super().close()
            raise
        run_at(_PRIORITY, inherited=False)  # but not of later threads

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
            run_at(0)
            self._lock.release()
            self._after()


def open_hardware(robot: str, options: WorldOptions) -> Backend:
    """Open the real robot of a file.

    UserError: it is not armed, too slow, or commanded by another program.
    """
    real = load_real_robot(robot)
    assert real is not None
    return open_parts(real, options, nullcontext(), "hardware")


def open_parts(
    real: RealRobot,
    options: WorldOptions,
    surroundings: AbstractContextManager[Truth | None],
    world: str,
) -> Backend:
    """A robot made of the parts in its file, with its lock.

    Its surroundings are there from when it is locked, before the drivers are made, until it is
    closed; they tell what is true of its world.
    """
    announce = options.announce
    check_armed(real, options.armed)
    if problem := too_slow(real):
        raise TooSlowError(problem)
    with ExitStack() as undo:
        lock = RobotLock(real.hardware).take()
        undo.callback(lock.release)
        truth = undo.enter_context(surroundings)
        clock = WallClock()
        description = at_pace(load_robot(real.path), speed_percent(real) / 100.0)
        parts = parts_of(real, description, clock, options.scene, options.seed)
        told = (one.truth for one in parts.values() if isinstance(one, Knowing))
        truth = truth or next(told, None)
        robot = ComposedRobot(description, **parts, clock=clock, rest_together=True)
        after = undo.pop_all().close

    def prepare() -> None:
        for part in parts.values():
            if announce and isinstance(part, Preparing):
                part.prepare(announce)

    if announce and (note := speed_note(real)):
        announce(note)
    return Backend(
        robot=CommandedRobot(robot, real, lock, after, prepare),
        clock=clock,
        truth=truth,
        world=world,
        map=real.map,
        of_scene=truth is not None,
    )
