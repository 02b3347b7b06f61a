"""A robot composed of parts, such as arm and base, with readings of their own stamps."""

from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future
from contextlib import ExitStack
from itertools import chain
from math import inf
from typing import Generic, ParamSpec, Self, TypeVar

from pinocchio import SE3

from controller import Command, RobotModel
from hw.clock import Clock
from hw.robot import (
    Arm,
    Base,
    Complaining,
    DepthCamera,
    Gripper,
    HardwareError,
    LaserScanner,
    Part,
    Sensor,
)
from hw.state import (
    ArmState,
    BaseState,
    DepthFrame,
    DepthImage,
    Fault,
    FaultKind,
    LaserScan,
    PartStamps,
    RobotState,
)
from hw.threads import one_thread
from robots import RobotDescription

P = ParamSpec("P")
R = TypeVar("R")
Reading = TypeVar("Reading", bound=ArmState | BaseState)

_BETWEEN_RECOVERIES = 2.0  # the arm is not recovered again sooner than this [s]
_ROUNDING = 1e-6  # of stamps, which are sums of periods [s]
_HISTORY = 0.5  # how far back readings are kept [s]


class InlineExecutor(Executor):
    """Does the work in the caller's thread before `submit` returns: deterministic."""

    def submit(self, fn: Callable[P, R], /, *args: P.args, **kwargs: P.kwargs) -> Future[R]:
        """Do the work; the future is done."""
        future: Future[R] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


class ComposedRobot:
    """A robot made of parts; where they `rest_together`, a fault of one stops all.

    `background` makes what grips and recovers: None for a thread, and in simulated time the
    caller's, so that no part may wait there, and a run is the same twice.
    """

    def __init__(
        self,
        description: RobotDescription,
        *,
        arm: Arm,
        base: Base,
        gripper: Gripper,
        camera: DepthCamera,
        laser: LaserScanner | None = None,
        clock: Clock,
        background: Callable[[], Executor] | None = None,
        rest_together: bool = False,
    ) -> None:
        self.description = description
        self._arm, self._base, self._gripper, self._camera = arm, base, gripper, camera
        self._laser = laser
        self._parts: tuple[Part, ...] = (arm, base, gripper, camera, *([laser] if laser else []))
        self._complaining = [part for part in self._parts if isinstance(part, Complaining)]
        self._arms = History(_interpolate_arm)
        self._bases = History(_interpolate_base)
        self._model = RobotModel(description)
        background = background or (one_thread if clock.is_real else InlineExecutor)
        self._grips, self._recoveries = background(), background()
        self._clock, self._arm_recovered = clock, -inf
        self._operations: dict[str, Future[None]] = {}
        self._rest_together, self._has_fault = rest_together, False
        self.camera = Sensor(self._latest_frame)
        self._image: DepthImage | None = None
        self._frame: DepthFrame | None = None
        self.laser = Sensor(self._latest_scan)
        self._scan: LaserScan | None = None

    def connect(self) -> None:
        """Connect every part, or none; raises HardwareError as the part says."""
        with ExitStack() as undo:
            for part in self._parts:
                part.connect()
                undo.callback(part.close)
            undo.pop_all()

    def read(self) -> RobotState:
        """The newest reading; arm and base at the older of their two stamps."""
        arm, base, gripper = self._arm.read(), self._base.read(), self._gripper.read()
        self._arms.add(arm)
        self._bases.add(base)
        stamp = min(arm.stamp, base.stamp)
        arm_then, base_then = self._arms.at(stamp), self._bases.at(stamp)
        parts = arm.faults, base.faults, gripper.faults, self._camera.faults(), self._failures()
        faults = tuple(dict.fromkeys(chain(*parts)))  # two parts may miss the same topic
        self._has_fault = bool(faults)
        return RobotState(
            stamp=stamp,
            oTb=base_then.oTb,
            base_twist=base_then.twist,
            q=arm_then.q,
            qd=arm_then.qd,
            gripper_width=gripper.width,
            gripper_moving=gripper.moving or self._is_running("grip"),
            recovering=self._is_running("recovery"),
            faults=faults,
            battery=base.battery,
            localised=base.localised,
            stamps=PartStamps(arm.stamp, base.stamp, gripper.stamp),
            complaints=tuple(chain(*(part.complaints for part in self._complaining))),
        )

    def send(self, command: Command) -> Command:
        """Hand a command on; where parts rest together, a fault commands rest instead."""
        if self._rest_together and self._has_fault:
            command = Command.stop(len(self.description.limits.qd))
        twist = self._base.send(command.base_twist)
        return Command(base_twist=twist, qd=self._arm.send(command.qd))

    def grip(self, width: float, force: float) -> None:
        """Start a grip; one in progress ends first."""
        self._operations["grip"] = self._grips.submit(self._gripper.grip, width, force)

    def recover(self) -> None:
        """Start a recovery, unless one is in progress; the arm takes part once in 2 s at most."""
        if self._is_running("recovery"):
            return
        parts: list[Part] = [self._base, self._gripper, self._camera]
        now = self._clock.now()
        if now - self._arm_recovered >= _BETWEEN_RECOVERIES - _ROUNDING:
            self._arm_recovered = now
            parts.insert(0, self._arm)
        running = {name: f for name, f in self._operations.items() if not f.done()}
        recovery = self._recoveries.submit(_recover, parts)
        self._operations = running | {"recovery": recovery}

    def stop(self) -> None:
        """Stop every part, even if one fails; raises the last error in the end."""
        with ExitStack() as calls:
            for part in self._parts:
                calls.callback(part.stop)

    def close(self) -> None:
        """Stop and close every part, even if one fails; raises the last error in the end."""
        with ExitStack() as calls:
            for executor in (self._grips, self._recoveries):
                calls.callback(executor.shutdown, wait=False, cancel_futures=True)
            for part in self._parts:
                calls.callback(part.close)

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _is_running(self, operation: str) -> bool:
        future = self._operations.get(operation)
        return future is not None and not future.done()

    def _failures(self) -> Iterator[Fault]:
        """Operations that ended with an error; the next recovery forgets them."""
        for name, future in self._operations.items():
            error = future.exception() if future.done() else None
            if isinstance(error, HardwareError):
                text = f"{name} failed: {error}"
                yield Fault(kind=FaultKind.OPERATION, text=text, clearable=True)
            elif error is not None:
                raise error

    def _latest_frame(self, max_age: float) -> DepthFrame | None:
        image = self._camera.latest()
        if image is not None and image is not self._image:
            self._image = image
            self._arms.add(self._arm.read())
            self._bases.add(self._base.read())
            base, arm = self._bases.at(image.stamp), self._arms.at(image.stamp)
            self._frame = DepthFrame(
                depth=image.depth,
                intrinsics=self.description.camera.intrinsics,
                oTc=self._model.end_effector(base.oTb, arm.q) * self.description.camera.eTc,
                stamp=image.stamp,
                paint=image.paint,
            )
        if self._frame is None or self._clock.now() - self._frame.stamp > max_age:
            return None
        return self._frame

    def _latest_scan(self, max_age: float) -> LaserScan | None:
        reading = self._laser.latest() if self._laser else None
        if reading is not None and (self._scan is None or reading.points is not self._scan.points):
            self._bases.add(self._base.read())
            self._scan = LaserScan(**vars(reading), oTb=self._bases.at(reading.stamp).oTb)
        if self._scan is None or self._clock.now() - self._scan.stamp > max_age:
            return None
        return self._scan


def _recover(parts: Sequence[Part]) -> None:
    for part in parts:
        part.recover()


class History(Generic[Reading]):
    """The last readings of one part, oldest first."""

    def __init__(self, interpolate: Callable[[Reading, Reading, float], Reading]) -> None:
        self._interpolate = interpolate
        self._readings: list[Reading] = []

    def add(self, reading: Reading) -> None:
        """Append a reading; those of the same or a later stamp are discarded."""
        readings = self._readings
        while readings and readings[-1].stamp >= reading.stamp:
            readings.pop()
        readings.append(reading)
        while readings[0].stamp < reading.stamp - _HISTORY:
            readings.pop(0)

    def at(self, stamp: float) -> Reading:
        """The reading at a stamp [s], interpolated; outside of the history the nearest one."""
        index = bisect_left(self._readings, stamp, key=lambda reading: reading.stamp)
        if index == len(self._readings):
            return self._readings[-1]
        later = self._readings[index]
        if index == 0 or later.stamp == stamp:
            return later
        return self._interpolate(self._readings[index - 1], later, stamp)


def _interpolate_arm(a: ArmState, b: ArmState, stamp: float) -> ArmState:
    """The arm between two readings, linearly; faults are those of the later one."""
    s = (stamp - a.stamp) / (b.stamp - a.stamp)
    return ArmState(
        stamp=stamp, q=a.q + s * (b.q - a.q), qd=a.qd + s * (b.qd - a.qd), faults=b.faults
    )


def _interpolate_base(a: BaseState, b: BaseState, stamp: float) -> BaseState:
    """The base between two readings, along the screw from one pose to the other."""
    s = (stamp - a.stamp) / (b.stamp - a.stamp)
    return BaseState(
        stamp=stamp,
        oTb=SE3.Interpolate(a.oTb, b.oTb, s),
        twist=a.twist + s * (b.twist - a.twist),
        battery=b.battery,
        localised=b.localised,
        faults=b.faults,
    )
