"""One robot out of an arm, a base, a gripper and a camera."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future
from contextlib import ExitStack
from math import inf
from typing import Self

from pinocchio import SE3

from controller import Command, RobotModel
from hw.background import one_thread
from hw.clock import Clock
from hw.frame import DepthFrame, DepthImage
from hw.history import History
from hw.robot import Arm, Base, DepthCamera, Gripper, HardwareError
from hw.state import (
    Fault,
    FaultKind,
    PartStamps,
    RobotState,
    interpolate_arm,
    interpolate_base,
)
from robots import RobotDescription

_BETWEEN_RECOVERIES = 2.0
"""The arm is not recovered again sooner than this, whoever asks [s]."""

_ROUNDING = 1e-6
"""Stamps are sums of periods [s]."""


class ComposedRobot:
    """A robot made of parts, each read at its own time.

    Arm and base are brought to a common moment by interpolation, and so is the place of the camera
    when it captured an image. Operations of the parts that take time run beside the loop.

    Args:
        description: what is true of the robot.
        arm: its arm.
        base: its base.
        gripper: its gripper.
        camera: the camera on its wrist.
        clock: session time.
        background: makes an executor for one kind of operation that takes time.
        rest_together: whether a fault of one part brings all to rest at once, whatever else is
            commanded; else the parts that have none go on, until whoever commands them says so.
    """

    def __init__(
        self,
        description: RobotDescription,
        *,
        arm: Arm,
        base: Base,
        gripper: Gripper,
        camera: DepthCamera,
        clock: Clock,
        background: Callable[[], Executor] = one_thread,
        rest_together: bool = False,
    ) -> None:
        self.description = description
        self._arm, self._base, self._gripper, self._camera = arm, base, gripper, camera
        self._parts = (arm, base, gripper, camera)
        self._arms = History(interpolate_arm)
        self._bases = History(interpolate_base)
        self._model = RobotModel(description)
        self._grips, self._recoveries = background(), background()
        self._clock, self._arm_recovered = clock, -inf
        self._operations: dict[str, Future[None]] = {}
        self._rest_together, self._has_fault = rest_together, False
        self.camera = WristCamera(description, camera, clock, self._wTe_at)

    def connect(self) -> None:
        """Connect every part; closes those before if one cannot be reached.

        Raises:
            HardwareError: as the part says.
        """
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
        faults = (
            *arm.faults,
            *base.faults,
            *gripper.faults,
            *self._camera.faults(),
            *self._failures(),
        )
        self._has_fault = bool(faults)
        return RobotState(
            stamp=stamp,
            wTb=base_then.wTb,
            base_twist=base_then.twist,
            q=arm_then.q,
            qd=arm_then.qd,
            gripper_width=gripper.width,
            gripper_moving=gripper.moving or self._is_under_way("grip"),
            recovering=self._is_under_way("recovery"),
            faults=faults,
            battery=base.battery,
            stamps=PartStamps(arm.stamp, base.stamp, gripper.stamp),
        )

    def send(self, command: Command) -> Command:
        """Hand a command on to base and arm.

        Where parts rest together, all are told to rest on a reading with a fault: each brakes as
        hard as its own limits allow.
        """
        if self._rest_together and self._has_fault:
            command = Command.stop()
        twist = self._base.send(command.base_twist)
        return Command(base_twist=twist, qd=self._arm.send(command.qd))

    def grip(self, width: float, force: float) -> None:
        """Start a grip; one that is under way ends first."""
        self._operations["grip"] = self._grips.submit(self._gripper.grip, width, force)

    def recover(self) -> None:
        """Start a recovery of all parts, unless one is under way.

        The arm is left out for 2 s after it was recovered: what throws it into its reflex again
        and again is not to shake it.
        """
        if self._is_under_way("recovery"):
            return
        parts: list[Arm | Base | Gripper | DepthCamera] = [self._base, self._gripper, self._camera]
        now = self._clock.now()
        if now - self._arm_recovered >= _BETWEEN_RECOVERIES - _ROUNDING:
            self._arm_recovered = now
            parts.insert(0, self._arm)
        under_way = {name: f for name, f in self._operations.items() if not f.done()}
        recovery = self._recoveries.submit(_recover, parts)
        self._operations = under_way | {"recovery": recovery}

    def stop(self) -> None:
        """Stop every part, whatever the others do; raises the last error in the end."""
        with ExitStack() as calls:
            for part in self._parts:
                calls.callback(part.stop)

    def close(self) -> None:
        """Stop and close every part, whatever the others do; raises the last error in the end."""
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

    def _is_under_way(self, operation: str) -> bool:
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

    def _wTe_at(self, stamp: float) -> SE3:
        """End effector in the world at a stamp [s], as the newest readings tell."""
        self._arms.add(self._arm.read())
        self._bases.add(self._base.read())
        return self._model.wTe(self._bases.at(stamp).wTb, self._arms.at(stamp).q)


def _recover(parts: Sequence[Arm | Base | Gripper | DepthCamera]) -> None:
    for part in parts:
        part.recover()


class WristCamera:
    """Turns the images of a camera into frames that know where they were taken from.

    Args:
        description: of the robot; its camera's mount and intrinsics.
        camera: delivers images.
        clock: session time.
        wTe_at: where the end effector was at a stamp [s].
    """

    def __init__(
        self,
        description: RobotDescription,
        camera: DepthCamera,
        clock: Clock,
        wTe_at: Callable[[float], SE3],
    ) -> None:
        self._description = description.camera
        self._camera = camera
        self._clock = clock
        self._wTe_at = wTe_at
        self._image: DepthImage | None = None
        self._frame: DepthFrame | None = None

    def latest(self, max_age: float) -> DepthFrame | None:
        """The newest frame, unless it is older than `max_age` [s]."""
        image = self._camera.latest()
        if image is not None and image is not self._image:
            self._image = image
            self._frame = DepthFrame(
                depth=image.depth,
                intrinsics=self._description.intrinsics,
                wTc=self._wTe_at(image.stamp) * self._description.eTc,
                stamp=image.stamp,
                paint=image.paint,
            )
        if self._frame is None or self._clock.now() - self._frame.stamp > max_age:
            return None
        return self._frame
