"""The vendor's library, which is loaded only where a camera is used."""

from __future__ import annotations

from ctypes import CDLL
from importlib.util import find_spec

_USB = "libusb-1.0.so.0"


def missing() -> str:
    """What to tell a person if the library cannot be loaded; empty if it can be."""
    if find_spec("pyrealsense2") is None:
        return 'the driver of the RealSense is not installed: pip install "frankie-task[hardware]"'
    try:
        CDLL(_USB)
    except OSError:
        return f"the driver of the RealSense needs {_USB}: on Debian, apt install libusb-1.0-0"
    return ""
