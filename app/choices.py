"""Choices of the command line, without imports that take time."""

from enum import StrEnum


class Speed(StrEnum):
    """Pace of simulated time."""

    REAL = "real"
    MAX = "max"


class ObstacleSource(StrEnum):
    """Source of the obstacles that the controller avoids."""

    MAP = "map"  # the map of static geometry, and a tracker of moving obstacles
    CAMERA = "camera"  # the wrist camera only: unseen space is unknown, and no routes are planned
    BOTH = "both"


class RegistrationForm(StrEnum):
    """What is matched to the map, to correct where the robot believes to be."""

    BOTH = "both"
    LASER = "laser"
    CAMERA = "camera"
    NONE = "none"

    @property
    def sensors(self) -> tuple[str, ...]:
        """The sensors that are used."""
        return {"both": ("laser", "camera"), "none": ()}.get(self.value, (self.value,))


class View(StrEnum):
    """How a run is shown."""

    AUTO = "auto"
    SPAWN = "spawn"
    WEB = "web"
    NONE = "none"


class Form(StrEnum):
    """Pose of a robot that is taught."""

    HAND = "hand"
    BASE = "base"
    ARM = "arm"
