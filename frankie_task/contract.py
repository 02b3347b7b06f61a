"""The contract of drivers, checked on an emulator or a machine that may move."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from functools import partial
from threading import Thread
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from hw import Array, Clock, DriverContext, Fault, FaultKind, WallClock, begun, stopwatch
from robots import RobotDescription, load_robot

_PERIOD = 0.01  # of the loop [s]
_BLOCKED = 0.05  # a call that takes longer has waited [s]
_RESTS = 0.01  # a slower part rests [m/s, rad/s]
_COASTS = 1.0  # a part that moves for so much longer than it may is stopped [s]
_FORCE, _WIDTH = 20.0, 5e-3  # of the fingers [N], and tolerance of their width [m]


class BrokenContractError(AssertionError):
    """What a driver does not keep, a line each."""


class _CallError(Exception):
    """What a driver raised, in words."""


class _Calls:
    """A part whose calls are watched: the one that has not returned, and since when [s]."""

    def __init__(self, part: Any) -> None:
        self._part, self._over = part, False
        self._running: tuple[str, float] | None = None

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._part, name)
        if not callable(found):
            return found

        def call(*arguments: object) -> Any:
            if self._over:
                raise _CallError("the check was given up")
            self._running = name, stopwatch()
            try:
                return found(*arguments)
            except Exception as error:
                raise _CallError(f"`{name}` raises {type(error).__name__}: {error}") from error
            finally:
                self._running = None

        return call

    def within(self, patience: float, work: Callable[[], object]) -> str:
        """Do work on a thread; why it failed, which is that a call takes more than that [s]."""
        thread, said = self.aside(work)
        try:
            while thread.is_alive():
                thread.join(_PERIOD)
                if (running := self._running) and stopwatch() - running[1] > patience:
                    return f"`{running[0]}` has not returned after {patience:g} s"
        finally:
            self._over = thread.is_alive()
        return "".join(said)

    def aside(self, work: Callable[[], object]) -> tuple[Thread, list[str]]:
        """Do work on another thread; also what will have failed there."""
        said: list[str] = []

        def listened() -> None:
            try:
                work()
            except Exception as error:
                said.append(str(error) if isinstance(error, _CallError) else repr(error))

        return begun(listened, "check"), said

    def again(self) -> "_Calls":
        """The same part, called from another thread."""
        return _Calls(self._part)


class _Trial(NamedTuple):
    """A connected part, and what is expected of it."""

    kind: str
    part: Any
    robot: RobotDescription
    clock: Clock
    fault: Callable[[], AbstractContextManager[Any]] | None
    speed: float
    age: float
    rest: float
    patience: float

    def command(self, way: float = 1.0) -> Array:
        """A velocity: of the last joint, or of the base; `way` is 1 forth, -1 back."""
        axes = np.eye(3 if self.kind == "base" else len(self.robot.arm.ready))
        return np.asarray(way * self.speed * axes[0 if self.kind == "base" else -1])

    def newest(self) -> Any:
        """The newest reading, image or scan."""
        return self.part.latest() if self.kind in ("camera", "laser") else self.part.read()

    def velocity(self) -> Array:
        """As measured."""
        reading = self.part.read()
        return np.asarray(reading.qd if self.kind == "arm" else reading.twist)

    def rests(self) -> bool:
        """Whether it hardly moves."""
        return bool(np.abs(self.velocity()).max() < _RESTS)

    def faults(self) -> Sequence[Fault]:
        """Those that the part reports; a laser reports none."""
        tell = getattr(self.part, "faults", tuple)
        return self.part.read().faults if hasattr(self.part, "read") else tell()

    def ticks(self, seconds: float) -> Iterator[float]:
        """The times of a loop on the clock."""
        end = self.clock.now() + seconds
        while (now := self.clock.now()) < end:
            yield now
            self.clock.sleep_until(now + _PERIOD)

    def wait(self, done: Callable[[], Any]) -> bool:
        """Whether something comes true in time."""
        return any(done() for _ in self.ticks(self.patience))

    def drive(self, way: float = 1.0) -> float:
        """Command the velocity for a second; when the last command was given."""
        given = 0.0
        for _ in self.ticks(1.0):
            self.part.read()
            self.part.send(self.command(way))
            given = self.clock.now()
        return given


Check: TypeAlias = Callable[[_Trial], Iterator[str]]


def _readings(trial: _Trial) -> Iterator[str]:
    """Readings come at once, are whole and finite, and their stamps are true."""
    if not trial.wait(trial.newest):
        yield f"there is none within {trial.patience:g} s"
        return
    slowest, ages, stamps, ahead = 0.0, [], [], 0.0
    for now in trial.ticks(1.0):
        reading, after = trial.newest(), trial.clock.now()
        slowest = max(slowest, after - now)
        ages.append(after - reading.stamp)
        ahead = max(ahead, reading.stamp - after)
        stamps.append(reading.stamp)
    if slowest > _BLOCKED:
        yield f"a call took {1e3 * slowest:.0f} ms"
    if ahead > 1e-3:
        yield f"a stamp is {1e3 * ahead:.0f} ms ahead of the clock"
    if np.any(np.diff(stamps) < 0.0):
        yield "stamps go back"
    if stamps[-1] == stamps[0]:
        yield "stamps stand still"
    if (age := float(np.median(ages))) > trial.age:
        yield f"they are {1e3 * age:.0f} ms old, of {1e3 * trial.age:.0f}"
    yield from _shapes(trial, reading)
    yield from (f"a healthy part reports: {fault.text}" for fault in trial.faults())


def _shapes(trial: _Trial, reading: Any) -> Iterator[str]:
    joints, camera = (len(trial.robot.arm.ready),), trial.robot.camera.intrinsics
    is_seen = trial.kind in ("camera", "laser")
    shapes: dict[str, dict[str, tuple[int, ...]]] = {
        "arm": {"q": joints, "qd": joints},
        "base": {"twist": (3,)},
        "gripper": {"width": ()},
        "camera": {"depth": (camera.height, camera.width)},
        "laser": {"ranges": (len(getattr(reading, "points", ())),)},
    }
    for name, shape in shapes[trial.kind].items():
        values = np.asarray(getattr(reading, name))
        if values.shape != shape:
            yield f"`{name}` has the shape {values.shape}, not {shape}"
        if is_seen and np.any(values <= 0.0):
            yield f"`{name}` is not positive; what is missing is NaN"
        elif not is_seen and not np.isfinite(values).all():
            yield f"`{name}` is not finite"


def _identity(trial: _Trial) -> Iterator[str]:
    """The same object is the same image or scan, and a newer one is another."""
    first = trial.newest()
    if not trial.wait(lambda: trial.newest() is not first):
        yield f"no other comes within {trial.patience:g} s"
    elif trial.newest().stamp <= first.stamp:
        yield "the newer one has no newer stamp"
    if not any(trial.newest() is trial.newest() for _ in range(5)):
        yield "each call gives another object"


def _follows(trial: _Trial) -> Iterator[str]:
    """It rests until it is commanded, then follows; `send` returns what was applied."""
    if not trial.rests():
        yield "it moves without a command"
    kept = trial.newest()
    values = kept.q if trial.kind == "arm" else kept.oTb.homogeneous
    before, off = values.copy(), 0.5 * abs(trial.speed)
    for command, way in ((trial.command(way), way) for way in (1.0, -1.0)):
        trial.drive(way)
        applied, velocity = np.asarray(trial.part.send(command)), trial.velocity()
        if not np.allclose(applied, command, atol=off):
            yield f"told {command}, it says that it applies {applied}"
        if not np.abs(velocity - command).max() <= off:
            yield f"told {command} for 1 s, it moves at {velocity.round(3)}"
    if not np.array_equal(values, before):
        yield "an earlier reading has changed"


def _refuses(trial: _Trial) -> Iterator[str]:
    """What is not finite is not applied."""
    for bad in (np.nan, np.inf):
        applied = np.asarray(trial.part.send(np.full(trial.command().shape, bad)))
        if np.any(applied):  # NaN counts
            yield f"told {bad}, it applies {applied}"


def _rests_alone(trial: _Trial) -> Iterator[str]:
    """It rests when commands cease: its own watchdog."""
    yield from _rests(trial, trial.drive())


def _rests_told(trial: _Trial) -> Iterator[str]:
    """`stop` from another thread brings it to rest."""
    trial.drive(-1.0)
    stopped = trial.clock.now()
    stopping, said = trial.part.aside(trial.part.again().stop)
    yield from _rests(trial, stopped)
    stopping.join(trial.patience)
    yield from said or ["it has not returned"] * stopping.is_alive()


def _rests(trial: _Trial, since: float) -> Iterator[str]:
    longest = trial.rest + _COASTS
    if not any(trial.rests() for _ in trial.ticks(longest)):
        yield f"it still moves after {longest:g} s"
    elif (after := trial.part.read().stamp - since) > trial.rest:
        yield f"it rests after {after:.2f} s, of {trial.rest:g}"


def _grips(trial: _Trial) -> Iterator[str]:
    """The fingers go to a width, and `moving` says so meanwhile."""
    for share in (1.0, 0.5):
        width, seen = share * trial.robot.gripper.opening, list[bool]()
        grip, said = trial.part.aside(partial(trial.part.again().grip, width, _FORCE))
        for _ in trial.ticks(trial.patience):
            seen.append(trial.part.read().moving)
            if not grip.is_alive():
                break
        if grip.is_alive():
            yield f"`grip` has not ended after {trial.patience:g} s"
        if said or grip.is_alive():
            yield from said
            return
        if not any(seen) or trial.part.read().moving:
            yield "`moving` is wrong"
        if abs(trial.part.read().width - width) > _WIDTH:
            yield f"told {width:.3f} m, its fingers are {trial.part.read().width:.3f} m apart"


def _faults(trial: _Trial) -> Iterator[str]:
    """A fault is told in words that stay, moves nothing, and is cleared by `recover`."""
    if trial.fault is None:
        return
    with trial.fault():
        if not trial.wait(trial.faults):
            yield f"it is not told within {trial.patience:g} s"
            return
        texts = {one.text for _ in trial.ticks(0.5) for one in trial.faults()}
        if len(texts) > len(trial.faults()) or not all(texts):
            yield f"its words change, or are empty: {sorted(texts)}"
        if not all(isinstance(one.kind, FaultKind) for one in trial.faults()):
            yield "its kind is no FaultKind"
        if trial.kind in ("arm", "base") and np.any(trial.part.send(trial.command())):
            yield "commands are applied"
        trial.part.stop()
    said = [""]
    if not trial.wait(lambda: _recovered(trial, said)):
        yield f"it is not cleared: {[one.text for one in trial.faults()]} {said[-1]}".rstrip()


def _recovered(trial: _Trial, said: list[str]) -> bool:
    try:
        if any(one.clearable for one in trial.faults()):
            trial.part.recover()
    except _CallError as error:
        said.append(str(error))
        return False
    return not trial.faults()


def _check(trial: _Trial, broken: list[str]) -> None:
    trial.part.connect()
    for check in _CHECKS[trial.kind]:
        promise = (check.__doc__ or "").strip()
        try:
            for what in check(trial):
                broken.append(f"{promise} But {what}")
        except _CallError as error:
            broken.append(f"{promise} But {error}")
        if check in _MOVING:
            trial.part.stop()


_MOVING: tuple[Check, ...] = (_follows, _refuses, _rests_alone, _rests_told)
_CHECKS: dict[str, tuple[Check, ...]] = {
    "arm": (_readings, *_MOVING, _faults),
    "base": (_readings, *_MOVING, _faults),
    "gripper": (_readings, _grips, _faults),
    "camera": (_readings, _identity, _faults),
    "laser": (_readings, _identity),
}


def check_driver(
    kind: str,
    make: Callable[[DriverContext], Any],
    *,
    robot: RobotDescription | None = None,
    fault: Callable[[], AbstractContextManager[Any]] | None = None,
    speed: float = 0.1,
    age: float = 0.1,
    rest: float = 0.3,
    patience: float = 10.0,
) -> None:
    """Check a driver on a machine or emulator, which moves forth and back, a second at a time.

    Args:
        kind: `arm`, `base`, `gripper`, `camera` or `laser`.
        make: the driver, not yet connected.
        robot: what it is a part of; None: Frankie.
        fault: brings about a fault until its `with` ends, as a cable that is pulled.
        speed: that it is driven at, first forth; below zero first back [m/s, rad/s].
        age: the greatest age of a reading on arrival, in the middle [s].
        rest: the longest time to rest from the last command on [s].
        patience: for everything else, such as one call of the driver [s].

    Raises:
        BrokenContractError: with a line for each promise that is not kept, also where the driver
            raises something or hangs.
        ValueError: the speed is that of a part at rest.
    """
    if not abs(speed) > 2.0 * _RESTS:
        raise ValueError(f"speed: {speed} m/s or rad/s is rest; give more than {2.0 * _RESTS:g}")
    robot, clock = robot or load_robot("frankie"), WallClock()
    part, broken = _Calls(make(DriverContext(robot=robot, clock=clock))), list[str]()
    trial = _Trial(kind, part, robot, clock, fault, speed, age, rest, patience)
    try:
        broken.append(part.within(patience, lambda: _check(trial, broken)))
    finally:
        closing = part.again()
        broken += [closing.within(patience, closing.close) for _ in range(2)]
    if told := list(dict.fromkeys(filter(None, broken))):
        raise BrokenContractError("\n".join(told))
