"""Settings and status of one RealSense, and whether the vendor's library is installed."""

import json
import struct
from ctypes import CDLL
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from typing import Self

from drivers.processes.mailbox import Mailbox

WIDTH, HEIGHT = 640, 480  # of the images that the camera delivers, before they are rectified [px]
SILENCE = 0.5  # without an image for this long the camera is lost [s]
STATUS = struct.Struct("<900s")
_USB = "libusb-1.0.so.0"


@dataclass(frozen=True, kw_only=True)
class RealSenseSettings:
    """One camera of the D400 series; without serial number and emulator the only one plugged in."""

    serial: str = ""
    emulator: str = ""  # HOST:PORT of an emulated camera, used instead of a real one
    rate: int = 30  # frame rate [Hz]
    infrared: bool = False  # with the left infrared image, for calibration
    emitter: bool = True  # whether the projector is on; its dots disturb infrared images
    preset: str = "High Density"  # stereo preset of the camera; empty: as it is
    delay: float = 0.0  # age of an image at the time stamp that the camera gives it [s]


@dataclass(frozen=True, kw_only=True)
class Status:
    """Which camera is connected, or why there are no images."""

    trouble: str = ""  # why there are no images; empty while there are
    name: str = ""
    serial: str = ""
    firmware: str = ""
    recommended: str = ""  # firmware that the library recommends; empty if it does not say
    usb: str = ""  # USB version; empty without a cable

    def put(self, mailbox: Mailbox) -> None:
        """Publish it."""
        values = asdict(self) | {"trouble": self.trouble[:400]}
        mailbox.put(json.dumps(values, ensure_ascii=True).encode()[: STATUS.size])

    @classmethod
    def get(cls, mailbox: Mailbox) -> Self | None:
        """The newest one; None if none was published."""
        record = mailbox.get()
        if record is None:
            return None
        return cls(**json.loads(record[0].rstrip(b"\0")))


def missing() -> str:
    """Why the vendor's library cannot be loaded; empty if it can."""
    from config import extra  # not for the processes of the driver

    if find_spec("pyrealsense2") is None:
        return f"the driver of the RealSense is not installed: {extra('hardware')}"
    try:
        CDLL(_USB)
    except OSError:
        return f"the driver of the RealSense needs {_USB}: on Debian, apt install libusb-1.0-0"
    return ""
