"""What a simulated world knows and no robot can: for scoring and drawing. Hardware has none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from pinocchio import SE3

from controller import Obstacle
from robots import Geom

MAY_TOUCH = ("fingers", "held object")
"""Parts of the robot that touch what is around them at work."""


@dataclass(frozen=True, kw_only=True)
class Touch:
    """The robot has hit something: a contact that nobody asked for."""

    stamp: float
    """On the session's clock [s]."""
    part: str
    """Of the robot: `base`, `link0` to `link7`, `camera`, `hand`, `fingers` or `held object`."""
    thing: str
    """Name of what was hit."""
    text: str
    """For people: who hit what."""


class TrueObject(Protocol):
    """An object of the world, or an obstacle that moves."""

    @property
    def name(self) -> str:
        """Unlike that of any other object."""

    @property
    def parts(self) -> tuple[Geom, ...]:
        """Its shapes, in its own frame."""

    @property
    def pose(self) -> SE3:
        """Where it is now, in the world."""


class Truth(Protocol):
    """The world as it is, whatever the robot believes."""

    @property
    def fixtures(self) -> Sequence[Geom]:
        """What never moves, in the world."""

    @property
    def mapped(self) -> Sequence[Geom]:
        """What of it is on the map that the robot is given."""

    @property
    def objects(self) -> Sequence[TrueObject]:
        """What can be picked up, always in the same order."""

    @property
    def walkers(self) -> Sequence[TrueObject]:
        """What moves by itself and is in the way, always in the same order."""

    @property
    def touches(self) -> Sequence[Touch]:
        """What the robot has hit so far, in order."""

    def moving(self) -> Sequence[Obstacle]:
        """What moves by itself, where it is now and how fast: what a tracker would tell."""

    def supports(self) -> Mapping[str, str]:
        """What carries each object, by its name: `table`, `hand`, ...; empty for nothing."""


@runtime_checkable
class DisturbableWorld(Truth, Protocol):
    """A world in which people can be told to interfere with the robot's work."""

    def put(self, name: str, wTo: SE3) -> None:
        """Put an object somewhere, out of the hand if it is held; it falls onto what is below."""
