"""Choice of the detector to evaluate, and its evaluation on many items in parallel."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Literal, TypeVar

import cv2
import numpy as np
import numpy.typing as npt

from config import extra
from config.reader import ConfigError
from lab.grasps.scenes import ROBOT
from lab.shared import progress, run_in_order
from perception import Candidates, CandidateSource, GraspDetector, Proposals, SpreadPoints

Item = TypeVar("Item")
Result = TypeVar("Result")


class RandomPoints:
    """Proposes random points where a grasp is allowed, the same in the same image."""

    name = "none"
    count = 16

    def propose(self, image: npt.NDArray[np.float32], allowed: npt.NDArray[np.bool_]) -> Proposals:
        """See `CandidateSource`."""
        v, u = np.nonzero(allowed)
        rng = np.random.default_rng(len(u))
        at = rng.choice(len(u), min(self.count, len(u)), replace=False)
        found = Candidates(
            pixel=np.stack([u[at], v[at]], axis=1).astype(float),
            angle=rng.uniform(0.0, np.pi, len(at)),
            width=np.zeros(len(at)),
            quality=np.ones(len(at)),
        )
        return Proposals(found, allowed.astype(np.float32), turn_cost=0.0)


WITHOUT_NETWORK: Mapping[str, Callable[[], CandidateSource]] = {
    RandomPoints.name: RandomPoints,
    SpreadPoints.name: SpreadPoints,
}
"""Sources that can be named instead of a network, to show what it adds to the check."""


@dataclass(frozen=True, kw_only=True)
class NetworkChoice:
    """What to evaluate; see `GraspDetector`."""

    weights: Path | None = None  # of GG-CNN; None are the shipped ones
    network: str | None = None  # one of `WITHOUT_NETWORK` in its place
    ranked: str | None = None
    """`likelihood` (to hold) or `check` (score of check and network); None is that of a run."""

    @property
    def name(self) -> str:
        """For tables."""
        name = str(self.weights) if self.weights else self.detector().sources[0].name
        return name if self.ranked in (None, self._default) else f"{name}, {self.ranked} ranking"

    @property
    def _default(self) -> str:
        return "check" if self.network else "likelihood"

    def detector(self) -> GraspDetector:
        """A detector on one thread; made once per process."""
        return _detector(self.weights, self.network, (self.ranked or self._default) == "check")


@lru_cache(maxsize=8)
def _detector(weights: Path | None, network: str | None, by_check: bool) -> GraspDetector:
    cv2.setNumThreads(1)
    shipped = GraspDetector.shipped(ROBOT.gripper, weights)
    sources = [WITHOUT_NETWORK[network]()] if network else shipped.sources
    return GraspDetector(ROBOT.gripper, sources, *(() if by_check else shipped.holds))


def all_results(
    name: str,
    work: Callable[[Item], Result],
    items: Sequence[Item],
    workers: int | None,
    good: Callable[[Result], bool],
) -> list[Result]:
    """Results in the order of the items, with a progress bar.

    `good` tells whether a result counts as a success in the bar; `workers` as in `run_all`.
    """
    if not items:
        return []
    with progress(name, len(items)) as advance:
        return run_in_order(work, items, lambda result: advance(not good(result)), workers=workers)


def require(package: Literal["mujoco", "torch"], command: str) -> None:
    """Refuse a command that needs a package of an extra where it is not installed.

    Raises ConfigError: it is missing.
    """
    if find_spec(package) is None:
        name = {"mujoco": "physics", "torch": "training"}[package]
        raise ConfigError(f"{command} needs an extra: {extra(name)}")
