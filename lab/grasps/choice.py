"""What to evaluate: a network and how its grasps are ranked; and that on many items at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple, TypeVar

import cv2

from behaviours import LOOKS
from lab.grasps.scenes import ROBOT
from lab.shared import progress, run_all
from perception import WITHOUT_NETWORK, GraspDetector

Item = TypeVar("Item")
Result = TypeVar("Result")


class Ranking(NamedTuple):
    """What puts one grasp before another."""

    by_likelihood: bool
    """How likely it holds; else the score of the check, with the network's."""
    lever_arm: bool
    """Grasps near the middle of a thing are preferred."""
    looks: int
    """How often the camera looks again, where there is no grasp or only a doubtful one."""


RANKINGS: Mapping[str, Ranking] = {
    "likelihood": Ranking(by_likelihood=True, lever_arm=True, looks=LOOKS),
    "check": Ranking(by_likelihood=False, lever_arm=True, looks=LOOKS),
    "first": Ranking(by_likelihood=False, lever_arm=False, looks=0),
}
"""By name: that of a run, that of a run without a network, and that of the first version."""


@dataclass(frozen=True, kw_only=True)
class NetworkChoice:
    """What to evaluate; see `GraspDetector`."""

    weights: Path | None = None
    network: str | None = None
    """Of the shipped ones, or one of `WITHOUT_NETWORK`."""
    ranked: str | None = None
    """One of `RANKINGS`; None is that of a run."""

    @property
    def name(self) -> str:
        """For tables."""
        name = str(self.weights) if self.weights else self.detector().proposer.name
        return name if self.ranked in (None, self._usual) else f"{name}, {self.ranked} ranking"

    @property
    def ranking(self) -> Ranking:
        """What puts one grasp before another."""
        return RANKINGS[self.ranked or self._usual]

    @property
    def _usual(self) -> str:
        return "check" if self.network in WITHOUT_NETWORK else "likelihood"

    def detector(self) -> GraspDetector:
        """A detector on one thread; made once per process."""
        return _detector(self)


@lru_cache(maxsize=8)
def _detector(choice: NetworkChoice) -> GraspDetector:
    import torch

    cv2.setNumThreads(1)
    torch.set_num_threads(1)
    return GraspDetector(
        choice.weights,
        choice.network,
        gripper=ROBOT.gripper,
        by_check=not choice.ranking.by_likelihood,
        lever_arm=choice.ranking.lever_arm,
    )


def all_results(
    name: str,
    work: Callable[[Item], Result],
    items: Sequence[Item],
    workers: int,
    good: Callable[[Result], bool],
) -> list[Result]:
    """Results in the order of the items, with a progress bar.

    Args:
        name: of the items, for people.
        work: a function that other processes can import.
        items: its arguments.
        workers: number of processes.
        good: whether a result is none of those that are counted as failures.
    """
    results: dict[int, Result] = {}
    if items:
        with progress(name, len(items)) as advance:
            for number, result in run_all(work, items, workers=workers):
                results[number] = result
                advance(not good(result))
    return [results[number] for number in range(len(items))]
