"""Candidates of grasps in an image, and the sources that need no network: points of the image.

They tell what a network adds to the feasibility check: with `RandomPoints` the check gets what
chance offers, with `SpreadPoints` it chooses for itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from perception.frame import Array, Image, Indices, Mask
from perception.grasps.refinement import ALL_DIRECTIONS, TURN_COST


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidates:
    """Where a grasp may be good, best first."""

    pixel: Array
    """(N, 2) input pixel (u, v), subpixel."""
    angle: Array
    """(N,) closing direction, from u towards v [rad]."""
    width: Array
    """(N,) opening [input px]; 0 if unknown."""
    quality: Array
    """(N,) 0 to 1."""


class Proposals(NamedTuple):
    """The candidates of one image."""

    candidates: Candidates
    """Best first."""
    quality: Image
    """(INPUT_SIZE, INPUT_SIZE) quality, for display; 0 where no grasp is allowed."""
    directions: int
    """Closing directions to assess at each candidate. GG-CNN needs all: where several are good, its
    angle is their average, which may be bad."""
    turn_cost: float = TURN_COST
    """Share of its score that a grasp loses at right angles to its candidate's direction."""
    most: int = 8
    """Grasps that are left of them, at most."""


class CandidateSource(Protocol):
    """What proposes grasps: a network, or what stands in for one."""

    @property
    def name(self) -> str:
        """For tables."""

    def propose(self, image: Image, allowed: Mask) -> Proposals:
        """Candidates in one image.

        Args:
            image: (INPUT_SIZE, INPUT_SIZE) depth less its mean, clipped to [-1, 1] [m].
            allowed: (INPUT_SIZE, INPUT_SIZE) where a grasp may be.
        """


class RandomPoints:
    """Points by chance where a grasp may be, the same ones in the same image.

    Args:
        count: of the points.
    """

    name = "none"

    def __init__(self, count: int = 16) -> None:
        self._count = count

    def propose(self, image: Image, allowed: Mask) -> Proposals:
        """See `CandidateSource`."""
        v, u = np.nonzero(allowed)
        rng = np.random.default_rng(len(u))
        chosen = rng.choice(len(u), min(self._count, len(u)), replace=False)
        return _equally_good(u[chosen], v[chosen], rng.uniform(0.0, np.pi, len(chosen)), allowed)


class SpreadPoints:
    """Points evenly spread over all that may be grasped, so that the check alone decides.

    Args:
        count: of the points, at most.
    """

    name = "check"

    def __init__(self, count: int = 128) -> None:
        self._count = count

    def propose(self, image: Image, allowed: Mask) -> Proposals:
        """See `CandidateSource`."""
        step = max(1, int(np.sqrt(np.count_nonzero(allowed) / self._count)))
        v, u = (
            step // 2 + step * at
            for at in np.nonzero(allowed[step // 2 :: step, step // 2 :: step])
        )
        few = np.linspace(0, len(u) - 1, min(self._count, len(u))).astype(int)
        return _equally_good(u[few], v[few], np.zeros(len(few)), allowed)


def _equally_good(u: Indices, v: Indices, angle: Array, allowed: Mask) -> Proposals:
    n = len(u)
    points = np.stack([u, v], axis=1).astype(float)
    found = Candidates(pixel=points, angle=angle, width=np.zeros(n), quality=np.ones(n))
    return Proposals(found, allowed.astype(np.float32), ALL_DIRECTIONS, turn_cost=0.0)


WITHOUT_NETWORK: Mapping[str, Callable[[], CandidateSource]] = {
    RandomPoints.name: RandomPoints,
    SpreadPoints.name: SpreadPoints,
}
"""What can be named where a network is wanted, and is none."""
