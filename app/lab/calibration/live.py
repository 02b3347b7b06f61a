"""A real arm, a real base and a real camera, to be calibrated."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from pinocchio import SE3

from app.lab.calibration.board import Array, Grey
from hw import Clock, HardwareError, WallClock
from hw.omron import OmronBase, OmronSettings
from hw.panda import PandaArm
from hw.realsense import RealSenseCamera, RealSenseSettings
from robots import CameraDescription

_SETTLED = 0.5
"""After a motion, until nothing swings any more [s]."""
_PATIENCE = 3.0
"""For an image [s]."""
_LOOK = 0.01
"""[s]"""


class Eye:
    """The infrared images of a connected camera.

    Args:
        camera: with `infrared` on and the `emitter` off.
        clock: that it stamps with.
    """

    def __init__(self, camera: RealSenseCamera, clock: Clock) -> None:
        self._camera, self._clock = camera, clock
        self._pause = threading.Event()

    def image(self) -> Grey:
        """One that is captured after this call.

        Raises:
            HardwareError: none comes.
        """
        asked = self._clock.now()
        while self._clock.now() < asked + _PATIENCE:
            image = self._camera.latest_grey()
            if image is not None and image.stamp > asked:
                return image.grey
            self._pause.wait(_LOOK)
        faults = self._camera.faults()
        raise HardwareError(faults[0].text if faults else "the camera sends no infrared images")


class LiveArm(Eye):
    """A Panda that takes a camera around. Nothing looks out for obstacles.

    Args:
        arm: connected.
        camera: connected.
        clock: of both.
        speed: of the fastest joint [rad/s].
    """

    def __init__(
        self, arm: PandaArm, camera: RealSenseCamera, clock: Clock, speed: float = 0.2
    ) -> None:
        super().__init__(camera, clock)
        self._arm, self._speed = arm, speed

    def q(self) -> Array:
        """As the arm tells."""
        return self._arm.read().q

    def move_to(self, q: Array) -> None:
        """Straight in joint space.

        Raises:
            HardwareError: it does not get there.
        """
        self._arm.move_to([float(one) for one in q], self._speed)
        self._pause.wait(_SETTLED)


class LiveBase(Eye):
    """A base that a person drives from place to place; nothing here commands a motion.

    Args:
        base: connected.
        arm: connected; it rests.
        camera: connected.
        clock: of all.
        ask: asks the person for another place, and waits; False if that was the last.
    """

    def __init__(
        self,
        base: OmronBase,
        arm: PandaArm,
        camera: RealSenseCamera,
        clock: Clock,
        ask: Callable[[], bool],
    ) -> None:
        super().__init__(camera, clock)
        self._base, self._arm, self._ask = base, arm, ask

    def next_place(self) -> bool:
        """Wait for the person."""
        return self._ask()

    def wTb(self) -> SE3:
        """As the base tells."""
        return self._base.read().wTb

    def q(self) -> Array:
        """As the arm tells."""
        return self._arm.read().q


@contextmanager
def live_arm(camera: CameraDescription, panda: str, realsense: str) -> Iterator[LiveArm]:
    """Connect an arm and its camera.

    Args:
        camera: of the robot file.
        panda: address of the arm.
        realsense: serial number of the camera, or HOST:PORT of an emulated one; empty: the only
            one.

    Raises:
        HardwareError: one of them cannot be reached.
    """
    clock = WallClock()
    with ExitStack() as parts:
        arm = PandaArm(panda, clock)
        arm.connect()
        parts.callback(arm.close)
        yield LiveArm(arm, _eye(parts, camera, realsense, clock), clock)


@contextmanager
def live_base(
    camera: CameraDescription,
    panda: str,
    realsense: str,
    omron: OmronSettings,
    ask: Callable[[], bool],
) -> Iterator[LiveBase]:
    """Connect a base, an arm and its camera.

    Args:
        camera: of the robot file.
        panda: address of the arm.
        realsense: as for `live_arm`.
        omron: address and account of the base.
        ask: asks the person for another place, and waits; False if that was the last.

    Raises:
        HardwareError: one of them cannot be reached.
    """
    clock = WallClock()
    with ExitStack() as parts:
        base, arm = OmronBase(omron, clock), PandaArm(panda, clock)
        for part in (base, arm):
            part.connect()
            parts.callback(part.close)
        yield LiveBase(base, arm, _eye(parts, camera, realsense, clock), clock, ask)


def _eye(
    parts: ExitStack, camera: CameraDescription, realsense: str, clock: Clock
) -> RealSenseCamera:
    """A connected camera that takes infrared images, without the dots of its projector."""
    is_emulated = ":" in realsense
    settings = RealSenseSettings(
        serial="" if is_emulated else realsense,
        emulator=realsense if is_emulated else "",
        infrared=True,
        emitter=False,
    )
    eye = RealSenseCamera(camera, clock, settings)
    eye.connect()
    parts.callback(eye.close)
    return eye
