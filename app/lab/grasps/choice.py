"""Which network to evaluate, and evaluating it on many items at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

import cv2

from app.lab import progress, run_all
from app.lab.grasps.scenes import ROBOT
from perception import GraspDetector

Item = TypeVar("Item")
Result = TypeVar("Result")


@dataclass(frozen=True, kw_only=True)
class NetworkChoice:
    """The network to evaluate; see `GraspDetector`."""

    weights: Path | None = None
    network: str | None = None
    by_check: bool = False
    """Whether grasps are ranked by check and network, and not by how likely they hold."""

    @property
    def name(self) -> str:
        """For tables."""
        name = str(self.weights) if self.weights else self.detector().proposer.name
        return f"{name}, by check" if self.by_check else name

    def detector(self) -> GraspDetector:
        """A detector on one thread; made once per process."""
        return _detector(self)


@lru_cache(maxsize=8)
def _detector(choice: NetworkChoice) -> GraspDetector:
    import torch

    cv2.setNumThreads(1)
    torch.set_num_threads(1)
    return GraspDetector(
        choice.weights, choice.network, gripper=ROBOT.gripper, by_check=choice.by_check
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
