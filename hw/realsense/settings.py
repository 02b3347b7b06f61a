"""What a person tells about one RealSense: which it is, and how it is set up."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class RealSenseSettings:
    """One camera of the D400 series. Without serial number, file and emulator: the only one."""

    serial: str = ""
    """Of the camera, where there are several."""
    file: str = ""
    """A recording (.db3, or .bag of older libraries) instead of a camera."""
    repeat: bool = True
    """Whether a recording begins again at its end."""
    emulator: str = ""
    """HOST:PORT of an emulated camera instead of a camera."""
    width: int = 640
    """Of the images that it delivers; they are brought to the intrinsics of the description."""
    height: int = 480
    rate: int = 30
    """Frames per second [Hz]."""
    infrared: bool = False
    """Whether the left infrared image is delivered as well; calibration needs it."""
    emitter: bool = True
    """Whether the projector is on; its dots disturb infrared images."""
    preset: str = "High Density"
    """Of the stereo matching, as the camera names it; empty: as it is set."""
    spatial: bool = False
    """Whether depth is smoothed within an image, edges kept; delays by about 10 ms."""
    temporal: bool = False
    """Whether depth is smoothed over images: for a camera that stands still."""
    delay: float = 0.0
    """How old an image is at the stamp that the camera gives it [s]."""
    silence: float = 0.5
    """Without an image for this long the camera is lost [s]."""
    connecting: float = 10.0
    """How long it may take to the first image [s]."""
    recovering: float = 5.0
    """How long a recovery waits for an image [s]."""
