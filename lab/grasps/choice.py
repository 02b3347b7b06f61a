"""Choice of the detector to evaluate, and its evaluation on many items in parallel."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import TypeVar

import cv2

from config import ConfigError, extra
from lab.grasps.scenes import ROBOT
from lab.shared import progress, run_in_order
from perception import WITHOUT_NETWORK, GraspDetector

Item = TypeVar("Item")
Result = TypeVar("Result")


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
        name = str(self.weights) if self.weights else self.detector().proposer.name
        return name if self.ranked in (None, self._default) else f"{name}, {self.ranked} ranking"

    @property
    def _default(self) -> str:
        return "check" if self.network else "likelihood"

    def detector(self) -> GraspDetector:
        """A detector on one thread; made once per process."""
        return _detector(self.weights, self.network, (self.ranked or self._default) == "check")


@lru_cache(maxsize=8)
def _detector(weights: Path | None, network: str | None, by_check: bool) -> GraspDetector:
    import torch

    cv2.setNumThreads(1)
    torch.set_num_threads(1)
    source = WITHOUT_NETWORK[network]() if network else None
    return GraspDetector(weights, gripper=ROBOT.gripper, proposer=source, by_check=by_check)


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


def require_physics(command: str) -> None:
    """Refuse a command that needs MuJoCo where it is not installed.

    Raises ConfigError: MuJoCo is missing.
    """
    if find_spec("mujoco") is None:
        raise ConfigError(f"{command} needs an extra: {extra('physics')}")
