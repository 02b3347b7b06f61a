"""Fit of the hold network to outcomes of grasps."""

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn
from torch.nn import functional

from lab.grasps.torch_networks import HoldNetwork, as_tensors
from perception import GraspPatches, hold_inputs
from robots import GripperDescription

_MIRRORS = ((), (2,), (3,), (2, 3))  # a grasp that is mirrored or turned by 180° holds as well


@dataclass(frozen=True, kw_only=True)
class FitSettings:
    """Length and speed of the fit."""

    seed: int = 0
    rounds: int = 16  # passes over the data
    batch: int = 128
    learning_rate: float = 2e-3  # the highest, of one cycle (Smith and Topin, 2019)
    weight_decay: float = 1e-3


@dataclass(frozen=True, kw_only=True)
class FitReport:
    """Progress, after a round."""

    round: int
    loss: float  # mean binary cross entropy in this round, with dropout


def fit_hold(
    patches: GraspPatches,
    good: npt.NDArray[np.bool_],
    gripper: GripperDescription,
    settings: FitSettings,
    report: Callable[[FitReport], None],
    start: HoldNetwork | None = None,
) -> HoldNetwork:
    """A network fitted to whether N grasps held (N,); the same for the same ones on one thread.

    It begins with the weights of `start`, or with random ones.
    """
    torch.manual_seed(settings.seed)
    rng = np.random.default_rng(settings.seed)
    network = HoldNetwork() if start is None else deepcopy(start)
    inputs = as_tensors(hold_inputs(patches, gripper))
    truth = torch.from_numpy(good.astype(np.float32))
    batches = max(1, len(truth) // settings.batch)
    optimizer = torch.optim.AdamW(
        network.parameters(), settings.learning_rate, weight_decay=settings.weight_decay
    )
    schedule = torch.optim.lr_scheduler.OneCycleLR(
        optimizer, settings.learning_rate, total_steps=settings.rounds * batches
    )
    for number in range(1, settings.rounds + 1):
        network.train()
        order = torch.from_numpy(rng.permutation(len(truth)))
        total = 0.0
        for chosen in order[: batches * settings.batch].chunk(batches):
            some = _mirrored(tuple(each[chosen] for each in inputs), rng)
            loss = functional.binary_cross_entropy_with_logits(network(*some), truth[chosen])
            optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            nn.utils.clip_grad_norm_(network.parameters(), 1.0)
            optimizer.step()
            schedule.step()
            total += float(loss.detach())
        report(FitReport(round=number, loss=total / batches))
    return network.eval()


def _mirrored(inputs: tuple[Tensor, ...], rng: np.random.Generator) -> tuple[Tensor, ...]:
    axes = _MIRRORS[int(rng.integers(len(_MIRRORS)))]
    # What is no map is the same for a mirrored grasp.
    return tuple(each.flip(axes) if axes and each.ndim == 4 else each for each in inputs)
