"""A RealSense of the D400 series as the camera of a robot."""

import threading
from collections.abc import Iterator
from dataclasses import asdict, dataclass

from drivers.processes.mailbox import PAGE, Mailbox
from drivers.processes.process import DriverProcess, ProcessPart
from drivers.realsense.device_settings import SILENCE, STATUS, RealSenseSettings, Status, missing
from drivers.realsense.image_buffer import Grey, ImageBuffer
from drivers.realsense.rectifier import ImageSpec
from hw import (
    Clock,
    DepthImage,
    Fault,
    FaultKind,
    Finding,
    HardwareError,
    Verdict,
    is_good,
    stopwatch,
    watched,
)
from robots import CameraDescription, RobotDescription

_CONNECTING = 10.0  # longest time to the first image [s]
_RECOVERING = 5.0  # how long a recovery waits for an image [s]
_POLL = 0.02  # polling interval of a recovery [s]
_OLD_IMAGE = 100.0  # largest age of an image on arrival that is good [ms]


@dataclass(frozen=True, kw_only=True, eq=False)
class GreyImage:
    """One image of the left imager; the same object is the same image."""

    grey: Grey  # (H, W) brightness
    stamp: float  # capture time on the session's clock [s]


@dataclass(frozen=True, kw_only=True)
class CameraReport:
    """Diagnostics of a connected camera."""

    status: Status
    images: int  # received by the driver
    lost: int  # frames in between that the driver did not receive
    age: float  # age of the newest image on arrival [s]


class RealSenseCamera(ProcessPart):
    """A depth camera; a process of its own holds it.

    Images are rectified to the intrinsics of the description. A lost camera is reopened
    automatically when it is back; until then there is a fault.
    """

    def __init__(
        self,
        description: CameraDescription,
        clock: Clock,
        settings: RealSenseSettings | None = None,
    ) -> None:
        settings = settings or RealSenseSettings()
        self._infrared, self._rate = settings.infrared, settings.rate
        camera = description.intrinsics
        spec = ImageSpec(**asdict(camera), near=description.min_range, far=description.max_range)
        pages = 1 - (-ImageBuffer.size(camera.width, camera.height) // PAGE)
        process = DriverProcess(
            "drivers.realsense.camera_process",
            "RealSense",
            settings.emulator or settings.serial or "USB",
            {"settings": asdict(settings), "spec": asdict(spec)},
            pages,
            _CONNECTING,
            missing,
        )
        super().__init__(process, clock)
        self._status = Mailbox(self._process.memory, 0, STATUS)
        self._buffer = ImageBuffer(self._process.memory, PAGE, camera.width, camera.height)
        self._images: tuple[DepthImage, GreyImage | None] | None = None
        self._number = 0
        self._reading = threading.Lock()

    def latest(self) -> DepthImage | None:
        """The newest depth image, the same object until there is a newer one."""
        images = self._newest()
        return None if images is None else images[0]

    def latest_grey(self) -> GreyImage | None:
        """The newest infrared image; None without `infrared` in the settings."""
        images = self._newest()
        return None if images is None else images[1]

    def faults(self) -> tuple[Fault, ...]:
        """A fault with the cause while no images come."""
        cause = self._trouble()
        return (self._fault(FaultKind.CONNECTION, cause),) if cause else ()

    def report(self) -> CameraReport:
        """Diagnostics."""
        status, image = Status.get(self._status), self._buffer.get(infrared=self._infrared)
        if status is None or image is None:
            raise HardwareError(f"the {self._process.what}: {self._process.end_of_it()}")
        return CameraReport(
            status=status,
            images=image.number,
            lost=image.frames - image.number,
            age=image.arrived - image.stamp,
        )

    def examine(self, robot: RobotDescription) -> Iterator[Finding]:
        """Model, firmware, frame rate, age of images."""
        begun, reports = stopwatch(), watched(self.report)
        seconds, before, report = stopwatch() - begun, reports[0], reports[-1]
        status = report.status
        usb = f", USB {status.usb}" if status.usb else ""
        firmware = f", firmware {status.firmware}" if status.firmware else ""
        yield Finding("camera", Verdict.GOOD, f"{status.name} {status.serial}{firmware}{usb}")
        if status.usb and not status.usb.startswith("3"):
            text = "it is connected by USB 2: use a cable and a port of USB 3"
            yield Finding("camera", Verdict.BAD, text)
        if _version(status.firmware) < _version(status.recommended):
            text = f"the library is made for firmware {status.recommended} or newer: rs-fw-update"
            yield Finding("camera", Verdict.OPEN, text)
        rate = (report.images - before.images) / seconds
        lost, age = report.lost - before.lost, 1000.0 * report.age
        good = rate > 0.8 * self._rate and age < _OLD_IMAGE
        text = f"{rate:.0f} images/s, {lost} lost, {age:.0f} ms old on arrival"
        yield is_good("camera", good, text)

    def recover(self) -> None:
        """Wait until it is back; restart a process that has ended; raises HardwareError."""
        if not self._trouble():
            return
        if self._process.end_of_it():
            self._process.start()
        until, pause = stopwatch() + _RECOVERING, threading.Event()
        while cause := self._trouble():
            if stopwatch() > until:
                status = Status.get(self._status)
                if status is None or not status.trouble:
                    self._process.kill()  # silent without a reason: the next recovery restarts it
                raise HardwareError(f"the {self._process.what}: {cause}")
            pause.wait(_POLL)

    def _trouble(self) -> str:
        """Why there are no images; empty if there are."""
        if ended := self._process.end_of_it():
            return ended
        arrived = self._buffer.arrival()
        if arrived is not None and stopwatch() - arrived <= SILENCE:
            return ""
        status = Status.get(self._status)
        cause = "" if status is None else status.trouble
        return cause or "it sends no images any more: look at its cable"

    def _newest(self) -> tuple[DepthImage, GreyImage | None] | None:
        with self._reading:
            if self._buffer.newest_number() != self._number and (
                image := self._buffer.get(infrared=self._infrared)
            ):
                self._number = image.number
                stamp = image.stamp + self._offset
                grey = image.infrared
                self._images = (
                    DepthImage(depth=image.depth, stamp=stamp),
                    None if grey is None else GreyImage(grey=grey, stamp=stamp),
                )
            return self._images


def _version(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in text.split(".") if part.isdigit())
