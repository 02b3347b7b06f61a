"""Candidate grasps in an image, and a source of them that needs no network."""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from config.arrays import Array, Image, Mask
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


class SpreadPoints:
    """Points evenly spread over all that is allowed: the feasibility check decides alone."""

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
        none = np.zeros(len(few))
        found = Candidates(
            pixel=np.stack([u[few], v[few]], axis=1).astype(float),
            angle=none,
            width=none,
            quality=none + 1.0,
        )
        return Proposals(found, allowed.astype(np.float32), turn_cost=0.0)
