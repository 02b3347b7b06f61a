"""A real arm, a real base and a real camera, to be calibrated."""

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace

from config import UserError
from config.poses import OdometryPose
from drivers.omron import OmronBase
from drivers.panda import PandaArm
from drivers.realsense import RealSenseCamera
from hw import Clock, HardwareError, WallClock, parts_of
from hw.hardware import RobotLock, check_armed
from lab.calibration.board import Array, Grey
from robots import RealRobot, load_robot

_SETTLED = 0.5  # after a motion, until nothing swings any more [s]
_PATIENCE = 3.0  # for an image [s]
_LOOK = 0.01  # between looks for an image [s]


class Eye:
    """The infrared images of a connected camera, with `infrared` on and the `emitter` off."""

    def __init__(self, arm: PandaArm, camera: RealSenseCamera, clock: Clock) -> None:
        self._arm, self._camera, self._clock = arm, camera, clock
        self._pause = threading.Event()

    def q(self) -> Array:
        """Joint positions (j,) of the arm that holds the camera [rad], as measured."""
        return self._arm.read().q

    def image(self) -> Grey:
        """An image captured after this call. Raises HardwareError: none comes."""
        asked = self._clock.now()
        while self._clock.now() < asked + _PATIENCE:
            image = self._camera.latest_grey()
            if image is not None and image.stamp > asked:
                return image.grey
            self._pause.wait(_LOOK)
        faults = self._camera.faults()
        raise HardwareError(faults[0].text if faults else "the camera sends no infrared images")


class LiveArm(Eye):
    """A Panda with a camera, both connected; nothing watches for obstacles.

    `speed` is that of the fastest joint [rad/s].
    """

    def __init__(
        self, arm: PandaArm, camera: RealSenseCamera, clock: Clock, speed: float = 0.2
    ) -> None:
        super().__init__(arm, camera, clock)
        self._speed = speed

    def move_to(self, q: Array) -> None:
        """Move straight in joint space. Raises HardwareError: the arm does not get there."""
        self._arm.move_to([float(one) for one in q], self._speed)
        self._pause.wait(_SETTLED)


class LiveBase(Eye):
    """A base that a person drives from place to place; arm and camera are connected.

    Its driver is connected only while the base stands and is read: a driver stops a base that
    others move. `ask` asks the person for another place, and waits; False if that was the last.
    """

    def __init__(
        self,
        base: OmronBase,
        arm: PandaArm,
        camera: RealSenseCamera,
        clock: Clock,
        ask: Callable[[], bool],
    ) -> None:
        super().__init__(arm, camera, clock)
        self._base, self._ask = base, ask

    def next_place(self) -> bool:
        """Wait for the person."""
        return self._ask()

    def oTb(self) -> OdometryPose:
        """The pose of the base. Raises HardwareError: it cannot be read."""
        self._base.connect()
        try:
            return self._base.read().oTb
        finally:
            self._base.close()


@contextmanager
def live_arm(real: RealRobot, *, armed: bool) -> Iterator[LiveArm]:
    """Connect the arm and the camera of a real robot.

    `armed` is whether a person has allowed motion. Raises UserError: it is not armed, or another
    program commands it; HardwareError: a part cannot be reached.
    """
    check_armed(real, armed)
    with _parts(real) as (arm, _, camera, clock):
        yield LiveArm(arm, camera, clock)


@contextmanager
def live_base(real: RealRobot, ask: Callable[[], bool]) -> Iterator[LiveBase]:
    """Connect the arm and the camera of a real robot; the base is read when it stands.

    Raises UserError: another program commands it; HardwareError: a part cannot be reached.
    """
    with _parts(real) as (arm, base, camera, clock):
        yield LiveBase(base, arm, camera, clock, ask)


@contextmanager
def _parts(real: RealRobot) -> Iterator[tuple[PandaArm, OmronBase, RealSenseCamera, Clock]]:
    robot, clock, lock = load_robot(real.path), WallClock(), RobotLock(real.hardware)
    infrared = real.hardware.camera.model_copy(update={"infrared": True, "emitter": False})
    seeing = real.hardware.model_copy(update={"camera": infrared})
    parts = parts_of(replace(real, hardware=seeing), robot, clock)
    arm, base, camera = parts["arm"], parts["base"], parts["camera"]
    if not (
        isinstance(arm, PandaArm)
        and isinstance(base, OmronBase)
        and isinstance(camera, RealSenseCamera)
    ):
        raise UserError(f"{real.path.name}: only panda, omron and realsense are calibrated")
    with ExitStack() as undo:
        undo.callback(lock.take().release)
        for part in (camera, arm):
            part.connect()
            undo.callback(part.close)
        yield arm, base, camera, clock
