"""Ground truth of a simulated world, for scoring and drawing only. Hardware has none."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from pinocchio import SE3

from controller import Obstacle
from robots import Geom

MAY_TOUCH = ("fingers", "held object")  # parts of the robot that touch things at work


@dataclass(frozen=True, kw_only=True)
class Touch:
    """A collision of the robot."""

    stamp: float  # [s]
    part: str  # `base`, `link0` to the last link, `camera`, `hand`, `fingers` or `held object`
    thing: str  # name of the obstacle or object
    text: str  # for people


class TrueObject(Protocol):
    """An object of the world, or an obstacle that moves."""

    @property
    def name(self) -> str:
        """Unique in the world."""

    @property
    def parts(self) -> tuple[Geom, ...]:
        """Its shapes, in its own frame."""

    @property
    def pose(self) -> SE3:
        """Its present pose in the world."""


class Truth(Protocol):
    """The true state of the world."""

    @property
    def fixtures(self) -> Sequence[Geom]:
        """Static shapes, in the world."""

    @property
    def mapped(self) -> Sequence[Geom]:
        """Those fixtures that are on the robot's map."""

    @property
    def objects(self) -> Sequence[TrueObject]:
        """Objects that can be picked up, always in the same order."""

    @property
    def walkers(self) -> Sequence[TrueObject]:
        """Moving obstacles, always in the same order."""

    @property
    def touches(self) -> Sequence[Touch]:
        """The collisions of the robot until now, in order."""

    @property
    def base(self) -> SE3 | None:
        """Where the base of the robot is, in the world; None where that is not told."""

    def moving(self) -> Sequence[Obstacle]:
        """Pose and velocity of the moving obstacles, as a tracker would report them."""

    def supports(self) -> Mapping[str, str]:
        """What carries each object, by its name: `table`, `hand`, ...; empty for nothing."""


@runtime_checkable
class DisturbableWorld(Truth, Protocol):
    """A world whose objects can be moved from outside during a run."""

    def put(self, name: str, wTs: SE3) -> None:
        """Move an object, out of the hand if it is held; it falls onto what is below."""

    def give(self, name: str) -> None:
        """A person holds an object between the fingers, until they have it."""


@runtime_checkable
class Knowing(Protocol):
    """A part that knows what is true of its world."""

    @property
    def truth(self) -> Truth | None:
        """None where its world is no more than the map."""
