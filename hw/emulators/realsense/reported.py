"""How real cameras were reported to behave, as far as the emulated one usually does not."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from hw.emulators.reported import Reported

_LIBREALSENSE = "realsenseai/librealsense issue"

AS_REPORTED: Mapping[str, Reported] = MappingProxyType(
    {
        "stamps-back": Reported(
            "stamps go back by 0.3 s, for a second out of three",
            f"{_LIBREALSENSE}s 11320, 7922: whenever the camera's clock of 32 bits wraps",
        ),
        "stamps-future": Reported(
            "stamps are 0.2 s in the future, for a second out of three",
            f"{_LIBREALSENSE}s 13122, 10775",
        ),
        "stamps-far": Reported(
            "after a while stamps are 50 years in the future, for good", f"{_LIBREALSENSE} 4505"
        ),
        "metadata-lost": Reported(
            "after a while stamps are those of the arrival",
            "librealsense, rs_frame.h: RS2_TIMESTAMP_DOMAIN_SYSTEM_TIME, without metadata",
        ),
        "hangs-until-reset": Reported(
            "it stops sending and begins again after a hardware reset",
            f"{_LIBREALSENSE}s 6628, 7252",
        ),
        "hangs-until-replugged": Reported(
            "it stops sending, and a hardware reset does not help", f"{_LIBREALSENSE} 14242"
        ),
        "repeats-images": Reported(
            "every third image comes twice, number and stamp too", f"{_LIBREALSENSE}s 1686, 14932"
        ),
        "freezes": Reported(
            "one image again and again, number and stamp too, for a second out of three",
            f"{_LIBREALSENSE} 3906",
        ),
        "picture-frozen": Reported(
            "one picture with new numbers and stamps, for a second out of three",
            f"{_LIBREALSENSE} 14932: frames whose contents are those of the one before",
        ),
        "zero-depth": Reported(
            "depth is 0 nearly everywhere, for a second out of three", f"{_LIBREALSENSE} 5209"
        ),
        "incomplete": Reported(
            "the lower half of an image is missing, one in five", f"{_LIBREALSENSE} 5154: by USB 2"
        ),
        "usb2": Reported(
            "it offers 15 images a second at most",
            f"{_LIBREALSENSE} 10837; the vendor's data sheet of the D400 series",
        ),
        "old-firmware": Reported(
            "its firmware is older than the library",
            f"{_LIBREALSENSE} 5154: what an update changes",
        ),
    }
)
"""By name, for `emulate realsense --as-reported`."""
