"""What a person chooses between for a run.

The command line lists them before anything that takes a second to import, so nothing is imported
here.
"""

from __future__ import annotations

from enum import StrEnum


class Speed(StrEnum):
    """How fast simulated time goes."""

    REAL = "real"
    MAX = "max"


class VisionForm(StrEnum):
    """How images are searched for grasps."""

    STEP = "step"
    """In step with the tick, which waits: a simulated run is the same every time."""
    BESIDE = "beside"
    """Beside the loop: no tick waits, as on hardware."""


class MotionForm(StrEnum):
    """How the robot gets to its goals."""

    HOLISTIC = "holistic"
    """Base and arm as one, anew in every period."""
    PLANNING = "planning"
    """The base first, then the arm along a plan: what the holistic way is compared with."""


class ObstacleSource(StrEnum):
    """What tells the controller what stands around the robot."""

    MAP = "map"
    """The map of what never moves, and a tracker of what does."""
    CAMERA = "camera"
    """The wrist camera alone: what it has not seen is not known, and no way is found around it."""
    BOTH = "both"
    """Map, tracker and camera."""


class View(StrEnum):
    """How a run is shown while it goes on."""

    AUTO = "auto"
    """A window if there is a screen, else nothing."""
    SPAWN = "spawn"
    """The native viewer, in a window."""
    WEB = "web"
    """The viewer as a page for a browser."""
    NONE = "none"
