"""How an emulated camera is set up, and what can be made to go wrong with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from hw.emulators.errors import NoFaultError
from robots import Intrinsics


def _d435() -> Intrinsics:
    return Intrinsics(width=640, height=480, fx=383.0, fy=383.0, cx=319.5, cy=239.5)


@dataclass(kw_only=True)
class Options:
    """Of one emulated camera; what concerns faults may be changed while it runs."""

    host: str = "127.0.0.1"
    port: int = 0
    """0: one that is free."""
    name: str = "Emulated RealSense D435"
    serial: str = "000000000001"
    rate: int = 30
    """Images per second [Hz]."""
    intrinsics: Intrinsics = field(default_factory=_d435)
    """Of the images that its source gives."""
    infrared: bool = False
    """Whether its source gives infrared images, too."""
    depth_units: float = 1e-3
    """[m]"""
    baseline: float = 0.05
    """Between its imagers [m]."""
    seed: int = 0
    """Of lost images and jitter."""
    drop: float = 0.0
    """Probability that an image is lost."""
    delay: float = 0.0
    """From the capture of an image until it is sent [s]."""
    jitter: float = 0.0
    """Images are sent up to so much later [s]."""
    frozen: bool = False
    """Whether no images come, over a connection that stands."""
    unplugged: bool = False
    """Whether there is no connection, nor a new one."""
    firmware: str = "05.16.00.01"
    as_reported: frozenset[str] = frozenset()
    """Names of `AS_REPORTED`."""


FAULTS: Mapping[str, str] = MappingProxyType(
    {
        "drops": "every tenth image, at random, is lost",
        "delay": "images come 50 ms late",
        "jitter": "images come up to 40 ms late, each by another time",
        "frozen": "the connection stands and no images come",
        "unplugged": "the cable is not plugged in",
    }
)
"""What can be wrong from the beginning, by name."""


def with_fault(options: Options, name: str) -> Options:
    """The same options with something wrong.

    Raises:
        NoFaultError: nothing is called so.
    """
    match name:
        case "frozen" | "unplugged":
            setattr(options, name, True)
        case "drops":
            options.drop = 0.1
        case "delay":
            options.delay = 0.05
        case "jitter":
            options.jitter = 0.04
        case _:
            raise NoFaultError(name, FAULTS)
    return options
