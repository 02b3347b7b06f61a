"""Teaching a network: what each kind is asked for, and the loop.

A step learns from random windows of a `SampleStream`. After every round of steps the moving average
of the weights is judged on windows that are never learnt from; the best average is kept, and
training ends early when it has not become better for some rounds. Everything random follows from
the seed and the number of the round, so a training that was interrupted and taken up again ends
with the same weights, bit for bit on one thread of the same machine.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass
from math import cos, isfinite, pi
from pathlib import Path
from typing import Any, NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional

from perception.angle_bins import AngleBinNetwork
from perception.ggcnn import GGCNN, evaluate, rewritten
from perception.maps import BINS, STRIDE
from perception.samples import Batch, SampleStream
from perception.weights import Network

_VALIDATION_BATCHES = 16
_KEEP = 0.998  # of the moving average, each step
_U_PREFERENCE = 0.1  # by how much closing along u is preferred to closing along v
_BACKGROUND = 0.15  # weight of GG-CNN's quality beside objects


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """How long and how fast to learn."""

    seed: int = 0
    rounds: int = 16
    steps: int = 500
    """To a round."""
    batch: int = 16
    """Windows to a step."""
    learning_rate: float = 2e-3
    """Of AdamW at its highest; it rises within 100 steps and falls with a cosine."""
    patience: int = 4
    """Rounds without a better validation before it ends."""
    held: int = 8
    """Shards in memory."""


@dataclass(frozen=True, kw_only=True)
class Report:
    """How training is doing after a round."""

    round: int
    loss: float
    """Mean over the round."""
    validation: float
    """Of the moving average of the weights."""
    best: float
    """The best validation so far."""


class Trained(NamedTuple):
    """What training leaves."""

    network: Network
    """With the best moving average of the weights, on the processor."""
    validation: float
    """Its loss on windows that were never learnt from."""


def train(
    network: Network,
    learn_from: Sequence[Path],
    validate_on: Sequence[Path],
    recipe: Recipe,
    *,
    checkpoint: Path | None = None,
    device: str = "cpu",
    report: Callable[[Report], None] = lambda _: None,
) -> Trained:
    """Teach a network.

    Args:
        network: to begin with; it is changed.
        learn_from: shards.
        validate_on: other shards.
        recipe: how long and how fast.
        checkpoint: written after every round; if it exists training goes on from there.
        device: of PyTorch.
        report: told after every round.

    Raises:
        ValueError: the checkpoint is of another network or recipe.
    """
    network = network.to(device=device, memory_format=torch.channels_last)  # type: ignore[call-overload]
    average = deepcopy(network).eval()
    optimizer = torch.optim.AdamW(network.parameters(), lr=recipe.learning_rate, weight_decay=1e-4)
    held_out = SampleStream(validate_on, seed=recipe.seed, held=len(validate_on))
    judged_on = [held_out.draw(recipe.batch) for _ in range(_VALIDATION_BATCHES)]
    begun, best, best_round, best_state = 0, float("inf"), 0, average.state_dict()
    if checkpoint is not None and checkpoint.is_file():
        saved = _resumed(checkpoint, recipe, network)
        network.load_state_dict(saved["network"])
        average.load_state_dict(saved["average"])
        optimizer.load_state_dict(saved["optimizer"])
        begun, best, best_round = saved["round"], saved["best"], saved["best_round"]
        best_state = saved["best_state"]
    for number in range(begun, recipe.rounds):
        if number - best_round > recipe.patience:
            break
        stream = SampleStream(learn_from, seed=recipe.seed * 10_000 + number + 1, held=recipe.held)
        network.train()
        total = 0.0
        for step in range(number * recipe.steps, (number + 1) * recipe.steps):
            for group in optimizer.param_groups:
                group["lr"] = recipe.learning_rate * _pace(step, recipe)
            loss = _loss(network, stream.draw(recipe.batch), device)
            optimizer.zero_grad(set_to_none=True)
            loss.backward()  # type: ignore[no-untyped-call]
            nn.utils.clip_grad_norm_(network.parameters(), 5.0)
            optimizer.step()
            _follow(average, network, min(_KEEP, step / (step + 10.0)))
            total += float(loss.detach())
        with torch.no_grad():
            validation = sum(float(_loss(average, each, device)) for each in judged_on)
        validation /= len(judged_on)
        if isfinite(validation) and validation < best:
            best, best_round = validation, number
            best_state = deepcopy(average.state_dict())
        if checkpoint is not None:
            _save(
                checkpoint,
                {
                    "recipe": repr(recipe),
                    "kind": type(network).__name__,
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
            Report(round=number + 1, loss=total / recipe.steps, validation=validation, best=best)
        )
    average.load_state_dict(best_state)
    return Trained(average.cpu().eval(), best)


def _pace(step: int, recipe: Recipe) -> float:
    """Share of the highest learning rate."""
    over = step / (recipe.rounds * recipe.steps)
    return min(1.0, (step + 1) / 100) * (0.02 + 0.98 * 0.5 * (1.0 + cos(pi * over)))


def _follow(average: nn.Module, network: nn.Module, keep: float) -> None:
    with torch.no_grad():
        for mine, new in zip(
            average.state_dict().values(), network.state_dict().values(), strict=True
        ):
            if mine.is_floating_point():
                mine.lerp_(new, 1.0 - keep)
            else:
                mine.copy_(new)


def _save(path: Path, state: dict[str, Any]) -> None:
    part = path.with_suffix(".part")
    torch.save(state, part)
    part.replace(path)


def _resumed(path: Path, recipe: Recipe, network: Network) -> dict[str, Any]:
    saved: dict[str, Any] = torch.load(path, map_location="cpu", weights_only=True)
    if (saved["kind"], saved["recipe"]) != (type(network).__name__, repr(recipe)):
        raise ValueError(
            f"{path}: belongs to a training of {saved['kind']} with another recipe; "
            "name another checkpoint or delete it"
        )
    return saved


def _loss(network: Network, batch: Batch, device: str) -> Tensor:
    image, quality, width, on_object = (torch.from_numpy(each).to(device) for each in batch)
    image = image.contiguous(memory_format=torch.channels_last)
    with torch.autocast(torch.device(device).type, dtype=torch.bfloat16):
        if isinstance(network, GGCNN):
            answer = evaluate(rewritten(network), image)
        else:
            answer = network(image)
    if isinstance(network, AngleBinNetwork):
        return bin_loss(answer.float(), quality, width)
    return maps_loss(answer.float(), quality, width, on_object)


def bin_loss(answer: Tensor, quality: Tensor, width: Tensor) -> Tensor:
    """Cross entropy of the qualities, good grasps counting more, and error of the good widths.

    Args:
        answer: (B, 2 BINS, n, n) of an `AngleBinNetwork`.
        quality: (B, BINS, n, n).
        width: (B, BINS, n, n).
    """
    logits, widths = answer[:, :BINS], answer[:, BINS:]
    entropy = functional.binary_cross_entropy_with_logits(logits, quality, reduction="none")
    good = quality * (quality > 0.05)
    of_width = ((widths - width).abs() * good).sum() / (good.sum() + 1.0)
    return 20.0 * ((1.0 + 8.0 * quality) * entropy).mean() + 2.0 * of_width


def maps_loss(maps: Tensor, quality: Tensor, width: Tensor, on_object: Tensor) -> Tensor:
    """Weighted squared error against the best direction of each cell.

    The published loss is the squared error of all maps over all pixels, which is mostly error where
    there is nothing to grasp. Here angle and width count only where a grasp would work, each pixel
    by how well it would, and quality counts more on objects than beside them. Where directions are
    equally good, that along u is asked for: their average would be good for nothing.

    Args:
        maps: (B, 4, 3 n, 3 n) of a `GGCNN` or `GGCNN2`.
        quality: (B, BINS, n, n).
        width: (B, BINS, n, n).
        on_object: (B, n, n).
    """
    angles = torch.arange(BINS, device=maps.device) * (pi / BINS)
    preference = 1.0 + _U_PREFERENCE * torch.cos(2.0 * angles)
    best = (quality * preference[:, None, None]).argmax(dim=1, keepdim=True)
    angle = angles[best[:, 0]]
    wanted = torch.stack(
        [
            quality.gather(1, best)[:, 0],
            torch.cos(2.0 * angle),
            torch.sin(2.0 * angle),
            width.gather(1, best)[:, 0],
            on_object,
        ],
        dim=1,
    )
    wanted = wanted.repeat_interleave(STRIDE, 2).repeat_interleave(STRIDE, 3)
    goal, on_object = wanted[:, 0], wanted[:, 4]
    error = (maps - wanted[:, :4]) ** 2
    weight = _BACKGROUND + (1.0 - _BACKGROUND) * on_object + 6.0 * goal
    good = goal * (goal > 0.1)
    total = good.sum() + 1.0
    of_quality = (weight * error[:, 0]).sum() / weight.sum()
    of_angle = (good[:, None] * error[:, 1:3]).sum() / total
    of_width = (good * error[:, 3]).sum() / total
    return 8.0 * of_quality + of_angle + 40.0 * of_width
