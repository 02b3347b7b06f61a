"""Training of GG-CNN: the loss and the loop.

After every round of steps the moving average of the weights is evaluated on validation windows; the
best average is kept, and training stops early when it has not improved for some rounds. All
randomness follows from the seed and the round, so a resumed training ends with the same weights,
bit for bit on one thread of the same machine.
"""

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass
from math import cos, isfinite, pi
from pathlib import Path
from typing import Any, NamedTuple

import torch
from torch import Tensor, nn

from lab.grasps.torch_networks import GGCNN
from lab.grasps.training_samples import Batch, SampleStream
from perception import ANGLE_BINS, OUTPUT_STRIDE

_VALIDATION_BATCHES = 16
_AVERAGE_DECAY = 0.998  # of the moving average of the weights, per step
_WARM_UP = 100  # steps until the highest learning rate
_LAST_RATE = 0.02  # learning rate at the end, as a share of the highest
_WEIGHT_DECAY = 1e-4
_MAX_GRADIENT_NORM = 5.0
_U_PREFERENCE = 0.1  # bonus of closing along u over closing along v, which breaks ties
_BACKGROUND = 0.15  # weight of the quality error of GG-CNN beside objects


@dataclass(frozen=True, kw_only=True)
class TrainingSettings:
    """Length and speed of a training."""

    seed: int = 0
    rounds: int = 16
    steps: int = 500  # per round
    batch: int = 16  # windows per step
    learning_rate: float = 2e-3  # highest of AdamW: linear warm-up of 100 steps, then cosine decay
    patience: int = 4  # rounds without a better validation until training stops
    in_memory: int = 8  # shards


@dataclass(frozen=True, kw_only=True)
class RoundReport:
    """The state of a training after a round."""

    round: int
    loss: float  # mean over the round
    validation: float  # loss of the averaged weights on the validation windows
    best: float  # smallest `validation` so far


class TrainingResult(NamedTuple):
    """The result of a training."""

    network: GGCNN  # with the best averaged weights, on the CPU
    validation: float  # its loss on the validation windows


def train(
    network: GGCNN,
    train_on: Sequence[Path],
    validate_on: Sequence[Path],
    settings: TrainingSettings,
    *,
    checkpoint: Path | None = None,
    device: str = "cpu",
    report: Callable[[RoundReport], None] = lambda _: None,
) -> TrainingResult:
    """Train GG-CNN.

    Args:
        network: with its initial weights; it is modified.
        train_on: shards.
        validate_on: other shards.
        settings: length and speed.
        checkpoint: written after every round; training resumes from it if it exists.
        device: of PyTorch.
        report: called after every round.

    Raises:
        ValueError: the checkpoint is of other settings.
    """
    network = network.to(device=device, memory_format=torch.channels_last)  # type: ignore[call-overload]
    average = deepcopy(network).eval()
    optimizer = torch.optim.AdamW(
        network.parameters(), lr=settings.learning_rate, weight_decay=_WEIGHT_DECAY
    )
    validation_stream = SampleStream(validate_on, seed=settings.seed, in_memory=len(validate_on))
    validation_batches = [
        validation_stream.draw(settings.batch) for _ in range(_VALIDATION_BATCHES)
    ]
    begun, best, best_round, best_state = 0, float("inf"), 0, average.state_dict()
    if checkpoint is not None and checkpoint.is_file():
        saved = _read_checkpoint(checkpoint, settings)
        network.load_state_dict(saved["network"])
        average.load_state_dict(saved["average"])
        optimizer.load_state_dict(saved["optimizer"])
        begun, best, best_round = saved["round"], saved["best"], saved["best_round"]
        best_state = saved["best_state"]
    for number in range(begun, settings.rounds):
        if number - best_round > settings.patience:
            break
        seed = settings.seed * 10_000 + number + 1
        stream = SampleStream(train_on, seed=seed, in_memory=settings.in_memory)
        network.train()
        total = 0.0
        for step in range(number * settings.steps, (number + 1) * settings.steps):
            for group in optimizer.param_groups:
                group["lr"] = settings.learning_rate * _rate_factor(step, settings)
            loss = _loss(network, stream.draw(settings.batch), device)
            optimizer.zero_grad(set_to_none=True)
            loss.backward()  # type: ignore[no-untyped-call]
            nn.utils.clip_grad_norm_(network.parameters(), _MAX_GRADIENT_NORM)
            optimizer.step()
            _update_average(average, network, min(_AVERAGE_DECAY, step / (step + 10.0)))
            total += float(loss.detach())
        with torch.no_grad():
            validation = sum(float(_loss(average, each, device)) for each in validation_batches)
        validation /= len(validation_batches)
        if isfinite(validation) and validation < best:
            best, best_round = validation, number
            best_state = deepcopy(average.state_dict())
        if checkpoint is not None:
            _save(
                checkpoint,
                {
                    "recipe": repr(settings),
                    "network": network.state_dict(),
                    "average": average.state_dict(),
                    "optimizer": optimizer.state_dict(),
                    "round": number + 1,
                    "best": best,
                    "best_round": best_round,
                    "best_state": best_state,
                },
            )
        report(
            RoundReport(
                round=number + 1, loss=total / settings.steps, validation=validation, best=best
            )
        )
    average.load_state_dict(best_state)
    return TrainingResult(average.cpu().eval(), best)


def _rate_factor(step: int, settings: TrainingSettings) -> float:
    """Learning rate as a share of the highest."""
    warm_up = min(1.0, (step + 1) / _WARM_UP)
    progress = step / (settings.rounds * settings.steps)
    return warm_up * (_LAST_RATE + (1.0 - _LAST_RATE) * 0.5 * (1.0 + cos(pi * progress)))


def _update_average(average: nn.Module, network: nn.Module, decay: float) -> None:
    with torch.no_grad():
        for old, new in zip(
            average.state_dict().values(), network.state_dict().values(), strict=True
        ):
            if old.is_floating_point():
                old.lerp_(new, 1.0 - decay)
            else:
                old.copy_(new)


def _save(path: Path, state: dict[str, Any]) -> None:
    part = path.with_suffix(".part")
    torch.save(state, part)
    part.replace(path)


def _read_checkpoint(path: Path, settings: TrainingSettings) -> dict[str, Any]:
    saved: dict[str, Any] = torch.load(path, map_location="cpu", weights_only=True)
    if saved["recipe"] != repr(settings):
        raise ValueError(
            f"{path}: belongs to a training with another recipe; name another or delete it"
        )
    return saved


def _loss(network: GGCNN, batch: Batch, device: str) -> Tensor:
    image, quality, width, on_object = (torch.from_numpy(each).to(device) for each in batch)
    image = image.contiguous(memory_format=torch.channels_last)
    with torch.autocast(torch.device(device).type, dtype=torch.bfloat16):
        maps = network.in_subpixels(image)
    return maps_loss(maps.float(), quality, width, on_object)


def maps_loss(maps: Tensor, quality: Tensor, width: Tensor, on_object: Tensor) -> Tensor:
    """Weighted squared error from the best direction of each cell.

    Unlike in the published loss, angle and width are weighted by the quality of the grasp, and
    quality counts more on objects. Among equally good directions the one nearest to u is the
    target, because the network would learn their average. `maps` (B, 4, 3 n, 3 n) are the output of
    a `GGCNN`; labels are (B, ANGLE_BINS, n, n), `on_object` (B, n, n).
    """
    angles = torch.arange(ANGLE_BINS, device=maps.device) * (pi / ANGLE_BINS)
    preference = 1.0 + _U_PREFERENCE * torch.cos(2.0 * angles)
    best = (quality * preference[:, None, None]).argmax(dim=1, keepdim=True)
    angle = angles[best[:, 0]]
    target = torch.stack(
        [
            quality.gather(1, best)[:, 0],
            torch.cos(2.0 * angle),
            torch.sin(2.0 * angle),
            width.gather(1, best)[:, 0],
            on_object,
        ],
        dim=1,
    )
    target = target.repeat_interleave(OUTPUT_STRIDE, 2).repeat_interleave(OUTPUT_STRIDE, 3)
    best_quality, on_object = target[:, 0], target[:, 4]
    error = (maps - target[:, :4]) ** 2
    weight = _BACKGROUND + (1.0 - _BACKGROUND) * on_object + 6.0 * best_quality
    good = best_quality * (best_quality > 0.1)
    total = good.sum() + 1.0
    of_quality = (weight * error[:, 0]).sum() / weight.sum()
    of_angle = (good[:, None] * error[:, 1:3]).sum() / total
    of_width = (good * error[:, 3]).sum() / total
    return 8.0 * of_quality + of_angle + 40.0 * of_width
