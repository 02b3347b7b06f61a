"""A RealSense of the D400 series as the camera of a robot."""

from __future__ import annotations

import threading
from dataclasses import asdict, dataclass

from hw.clock import Clock, stopwatch
from hw.frame import DepthImage
from hw.processes.mailbox import PAGE, Mailbox
from hw.processes.process import DriverProcess
from hw.realsense.album import Album, Grey, Picture
from hw.realsense.images import Wanted
from hw.realsense.library import missing
from hw.realsense.records import STATUS, Status
from hw.realsense.settings import RealSenseSettings
from hw.robot import HardwareError
from hw.state import Fault, FaultKind
from robots import CameraDescription

_LOOK = 0.02
"""How often something that is waited for is looked at [s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GreyImage:
    """One image of the left imager; the same object is the same image."""

    grey: Grey
    """(H, W) brightness."""
    stamp: float
    """When it was captured, on the session's clock [s]."""


@dataclass(frozen=True, kw_only=True)
class CameraReport:
    """What is known of a camera that delivers images."""

    status: Status
    images: int
    """That the driver was given."""
    lost: int
    """Images in between that it was not given."""
    age: float
    """How old the newest image was on arrival [s]."""


class RealSenseCamera:
    """A depth camera; a process of its own holds it.

    Images are brought to the intrinsics of the description, whatever those of this camera are. A
    camera that is lost is opened again by itself when it is back; until then there is a fault.

    Args:
        description: the camera as the robot file describes it.
        clock: session time, for the stamps.
        settings: which camera, and how it is set up.

    Raises:
        HardwareError: more than one of serial number, file and emulator is given.
    """

    def __init__(
        self,
        description: CameraDescription,
        clock: Clock,
        settings: RealSenseSettings | None = None,
    ) -> None:
        self._settings = settings = settings or RealSenseSettings()
        given = [one for one in (settings.emulator, settings.file, settings.serial) if one]
        if len(given) > 1:
            raise HardwareError(f"a camera is one of these, not all: {', '.join(given)}")
        self._clock, self._offset = clock, 0.0
        camera = description.intrinsics
        wanted = Wanted(**asdict(camera), near=description.min_range, far=description.max_range)
        told = {"settings": asdict(settings), "wanted": asdict(wanted)}
        pages = 1 - (-Album.size(camera.width, camera.height) // PAGE)
        self._process = DriverProcess(
            "hw.realsense.camera_process",
            "RealSense",
            given[0] if given else "USB",
            told,
            pages,
            settings.connecting,
            missing,
        )
        self._status = Mailbox(self._process.memory, 0, STATUS)
        self._album = Album(self._process.memory, PAGE, camera.width, camera.height)
        self._images: tuple[DepthImage, GreyImage | None] | None = None
        self._number = 0
        self._reading = threading.Lock()

    def connect(self) -> None:
        """Start the process, and wait for the first image.

        Raises:
            HardwareError: there is none; the text says why and what to do.
        """
        self._offset = self._clock.now() - stopwatch()
        self._process.start()

    def latest(self) -> DepthImage | None:
        """The newest depth image, the same object until there is a newer one."""
        images = self._newest()
        return None if images is None else images[0]

    def latest_grey(self) -> GreyImage | None:
        """The newest infrared image; None without `infrared` in the settings."""
        images = self._newest()
        return None if images is None else images[1]

    def faults(self) -> tuple[Fault, ...]:
        """That the camera is lost, and why."""
        cause = self._trouble()
        if not cause:
            return ()
        text = f"the {self._process.what}: {cause}"
        return (Fault(kind=FaultKind.CONNECTION, text=text, clearable=True),)

    def report(self) -> CameraReport:
        """What is known of the camera.

        Raises:
            HardwareError: nothing, it was never connected.
        """
        status, picture = Status.get(self._status), self._picture()
        if status is None or picture is None:
            raise HardwareError(f"the {self._process.what}: {self._process.end_of_it()}")
        return CameraReport(
            status=status,
            images=picture.number,
            lost=picture.frames - picture.number,
            age=picture.arrived - picture.stamp,
        )

    def recover(self) -> None:
        """Wait until the camera is back; its process is started again if that has ended or hangs.

        Raises:
            HardwareError: it does not come back; the text says what to do.
        """
        if not self._trouble():
            return
        if self._process.end_of_it():
            self._process.start()
        until, pause = stopwatch() + self._settings.recovering, threading.Event()
        while cause := self._trouble():
            if stopwatch() > until:
                status = Status.get(self._status)
                if status is None or not status.trouble:
                    self._process.kill()  # it is silent without a reason: the next one starts anew
                raise HardwareError(f"the {self._process.what}: {cause}")
            pause.wait(_LOOK)

    def stop(self) -> None:
        """A camera does not move."""

    def close(self) -> None:
        """End the process."""
        self._process.end()

    def _trouble(self) -> str:
        """Why there are no images; empty if there are."""
        if ended := self._process.end_of_it():
            return ended
        arrived = self._album.arrival()
        if arrived is not None and stopwatch() - arrived <= self._settings.silence:
            return ""
        status = Status.get(self._status)
        cause = "" if status is None else status.trouble
        return cause or "it sends no images any more: look at its cable"

    def _picture(self) -> Picture | None:
        return self._album.get(infrared=self._settings.infrared)

    def _newest(self) -> tuple[DepthImage, GreyImage | None] | None:
        with self._reading:
            if self._album.newest_number() != self._number and (picture := self._picture()):
                self._number = picture.number
                stamp = picture.stamp + self._offset
                grey = picture.infrared
                self._images = (
                    DepthImage(depth=picture.depth, stamp=stamp),
                    None if grey is None else GreyImage(grey=grey, stamp=stamp),
                )
            return self._images
