"""Options and reported behaviours of an emulated camera."""

from dataclasses import dataclass

from extensions.emulators.common import reported
from robots import Intrinsics

_D435 = Intrinsics(width=640, height=480, fx=383.0, fy=383.0, cx=319.5, cy=239.5)


@dataclass(kw_only=True)
class Options:
    """Of one emulated camera; they may be changed while it runs."""

    host: str = "127.0.0.1"
    port: int = 0  # 0: any free one
    name: str = "Emulated RealSense D435"
    serial: str = "000000000001"
    rate: int = 30  # frame rate [Hz]
    intrinsics: Intrinsics = _D435  # of the images that its source gives
    infrared: bool = False  # whether its source gives infrared images, too
    depth_units: float = 1e-3  # one unit of a depth image [m]
    baseline: float = 0.05  # between the imagers [m]
    seed: int = 0  # of lost images and jitter
    drop: float = 0.0  # probability that an image is lost
    delay: float = 0.0  # from the capture of an image until it is sent [s]
    jitter: float = 0.0  # largest additional delay [s]
    frozen: bool = False  # whether no images come over an open connection
    unplugged: bool = False  # whether connections are closed and refused
    firmware: str = "05.16.00.01"
    as_reported: frozenset[str] = frozenset()  # names of `AS_REPORTED`


AS_REPORTED = reported("""
stamps-back | stamps go back by 0.3 s, for a second out of three | librealsense #11320, #7922
stamps-future | stamps are 0.2 s in the future, for a second out of three | librealsense #13122
stamps-far | after a while stamps are 50 years in the future, for good | librealsense #4505
metadata-lost | after a while stamps are those of the arrival | librealsense, rs_frame.h
hangs-until-reset | it stops sending until a hardware reset | librealsense #6628, #7252
hangs-until-replugged | it stops sending, and a hardware reset does not help | librealsense #14242
repeats-images | every third image comes twice, number and stamp too | librealsense #1686, #14932
freezes | one image again and again, stamp too, for a second out of three | librealsense #3906
picture-frozen | one picture with new stamps, for a second out of three | librealsense #14932
zero-depth | depth is 0 nearly everywhere, for a second out of three | librealsense #5209
incomplete | the lower half of one image in five is missing | librealsense #5154: by USB 2
usb2 | it offers 15 images a second at most | librealsense #10837
old-firmware | its firmware is older than the library | librealsense #5154
""")
"""Reported behaviours by name, for `emulate realsense --as-reported`."""
