"""Candidate grasps in an image, and sources of them that need no network.

The sources show what a network adds to the feasibility check: with `RandomPoints` the check gets
random points, with `SpreadPoints` it decides alone.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from perception.frame import Array, Image, Indices, Mask
from perception.grasps.refinement import DIRECTIONS, TURN_COST


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidates:
    """Candidate grasps, best first."""

    pixel: Array  # (N, 2) input pixel (u, v), subpixel
    angle: Array  # (N,) closing direction, from u towards v [rad]
    width: Array  # (N,) opening [input px]; 0 if unknown
    quality: Array  # (N,) 0 to 1


class Proposals(NamedTuple):
    """The candidates of one image."""

    candidates: Candidates
    quality: Image  # (INPUT_SIZE, INPUT_SIZE) quality, for display; 0 where no grasp is allowed
    directions: int = DIRECTIONS  # closing directions that are assessed at each candidate
    turn_cost: float = TURN_COST  # see `refinement.TURN_COST`
    most: int = 8  # largest number of refined grasps


class CandidateSource(Protocol):
    """A source of candidates: a network, or what replaces one."""

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
    """Random points where a grasp is allowed, the same in the same image."""

    name = "none"
    count = 16

    def propose(self, image: Image, allowed: Mask) -> Proposals:
        """See `CandidateSource`."""
        v, u = np.nonzero(allowed)
        rng = np.random.default_rng(len(u))
        chosen = rng.choice(len(u), min(self.count, len(u)), replace=False)
        return _equally_good(u[chosen], v[chosen], rng.uniform(0.0, np.pi, len(chosen)), allowed)


class SpreadPoints:
    """Points evenly spread over all that is allowed."""

    name = "check"
    count = 128

    def propose(self, image: Image, allowed: Mask) -> Proposals:
        """See `CandidateSource`."""
        step = max(1, int(np.sqrt(np.count_nonzero(allowed) / self.count)))
        v, u = (
            step // 2 + step * at
            for at in np.nonzero(allowed[step // 2 :: step, step // 2 :: step])
        )
        few = np.linspace(0, len(u) - 1, min(self.count, len(u))).astype(int)
        return _equally_good(u[few], v[few], np.zeros(len(few)), allowed)


def _equally_good(u: Indices, v: Indices, angle: Array, allowed: Mask) -> Proposals:
    n = len(u)
    points = np.stack([u, v], axis=1).astype(float)
    found = Candidates(pixel=points, angle=angle, width=np.zeros(n), quality=np.ones(n))
    return Proposals(found, allowed.astype(np.float32), turn_cost=0.0)


WITHOUT_NETWORK: Mapping[str, Callable[[], CandidateSource]] = {
    RandomPoints.name: RandomPoints,
    SpreadPoints.name: SpreadPoints,
}
"""Sources that can be named instead of a network."""
