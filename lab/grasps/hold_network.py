"""Fit of the network that estimates how likely a grasp holds, and how good its estimate is.

AUC is the share of pairs of a good and a bad grasp that a score orders rightly (Hanley and McNeil,
1982). The calibration error is the mean distance between estimated and true shares, over bins of
equally many grasps (Naeini et al., 2015).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from rich.table import Table

from config.arrays import Array, Indices
from config.reader import ConfigError
from lab.grasps.choice import require
from lab.grasps.grasp_outcomes import SETS, Outcomes, group_of, read_outcomes
from lab.grasps.scenes import ROBOT
from perception import NUMBERS, HoldProbability, hand_sizes

if TYPE_CHECKING:
    from lab.grasps.hold_training import FitReport

Score: TypeAlias = Callable[[Array, Array], float]

TRAINING_SETS = ("trained", "bodies", "light")  # the sets of outcomes that are learnt from ...
TILTED_SETS = ("tilted",)  # ... and those of tilted approaches, on top of them
_BINS = 10  # of the calibration error
_DRAWS = 1000  # of a bootstrap


def fit_hold_network(
    folder: Path, out: Path, *, rounds: int, say: Callable[[str], None], start: Path | None = None
) -> None:
    """Fit to all outcomes of `TRAINING_SETS` in a folder, and write the weights.

    With `start`, a file of such weights, to those of `TILTED_SETS`, beginning with these weights
    and half as fast. Raises ConfigError: there are no outcomes, a file cannot be read, or PyTorch
    is missing.
    """
    require("torch", "grasp fit")  # not imported at the top: it is an extra
    import torch

    from lab.grasps.hold_training import FitSettings, fit_hold
    from lab.grasps.torch_networks import load_hold_network, save_network

    sets = TRAINING_SETS if start is None else TILTED_SETS
    outcomes, settings = read_outcomes(folder, *sets), FitSettings(rounds=rounds)
    network = None
    if start is not None:
        network = load_hold_network(start)
        settings = replace(settings, learning_rate=0.5 * settings.learning_rate)
    torch.set_num_threads(1)  # the order of sums is then always the same

    def report(done: FitReport) -> None:
        say(f"round {done.round} of {settings.rounds}: loss {done.loss:.4f}")

    say(f"{len(outcomes.good)} grasps, {100 * outcomes.good.mean():.1f} % of them good")
    learnt = outcomes.patches, outcomes.good, ROBOT.gripper
    network = fit_hold(*learnt, settings, report, network)
    metadata = {
        "settings": asdict(settings),
        "grasps": len(outcomes.good),
        "last_scenes": {name: _last_scene(folder, name) for name in sets},
        "hand": hand_sizes(ROBOT.gripper),
        "licence": "Apache-2.0",
    }
    save_network(network, out, metadata)


def _last_scene(folder: Path, name: str) -> int | None:
    """The largest seed among the scenes of a set; None if there are none."""
    if not list(folder.glob(f"{name}-*.npz")):
        return None
    return int(read_outcomes(folder, name).scene.max())


def auc(estimated: Array, good: Array) -> float:
    """Area under the ROC curve; ties count half, NaN without both outcomes."""
    positive, negative = estimated[good > 0.5], np.sort(estimated[good < 0.5])
    if not len(positive) or not len(negative):
        return float("nan")
    below = np.searchsorted(negative, positive, "left")
    not_above = np.searchsorted(negative, positive, "right")
    return float((below + not_above).mean() / (2 * len(negative)))


def calibration_error(estimated: Array, good: Array) -> float:
    """Mean of |estimated - true| over `_BINS` bins of equally many grasps."""
    order = np.argsort(estimated, kind="stable")
    parts = [part for part in np.array_split(order, _BINS) if len(part)]
    return float(sum(abs(estimated[p].sum() - good[p].sum()) for p in parts) / len(estimated))


def probability_table(judged: Outcomes, hold: HoldProbability) -> Table:
    """AUC and calibration error of a network, and of the score of the check.

    Each with its 95 % interval, of all, of single objects and bins, and of each group of objects.
    Raises ConfigError: the outcomes are all the same.
    """
    good = judged.good.astype(float)
    if len(set(good)) < 2:
        raise ConfigError("the outcomes to judge by are all the same; collect more scenes")
    estimates = {
        "the network": hold(judged.patches),
        "the score of the check": judged.patches.numbers[:, NUMBERS.index("score")].astype(float),
    }
    title = f"{len(good)} grasps in {len(np.unique(judged.scene))} scenes, {int(good.sum())} good"
    table = Table("estimated by", "grasps", "AUC", "calibration error", title=title)
    groups = SETS["heldout"].groups
    of_groups = np.array([group_of(int(seed), groups) for seed in judged.scene])
    parts = {
        "all": np.ones(len(good), dtype=np.bool_),
        "single": judged.objects == 1,
        "in a bin": judged.objects > 1,
        **{group: of_groups == group for group in groups},
    }
    for name, values in estimates.items():
        for part, chosen in parts.items():
            if len(set(good[chosen])) < 2:
                continue
            cells = (
                "{:.3f} ({:.3f} to {:.3f})".format(
                    *_with_interval(score, values[chosen], good[chosen], judged.scene[chosen])
                )
                for score in (auc, calibration_error)
            )
            table.add_row(name, part, *cells)
    return table


def _with_interval(
    score: Score, estimated: Array, good: Array, scene_of: Indices
) -> tuple[float, float, float]:
    """A score and its interval by a bootstrap over the scenes (Efron, 1979)."""
    rng = np.random.default_rng(0)
    members = [np.flatnonzero(scene_of == scene) for scene in np.unique(scene_of)]
    drawn = []
    for _ in range(_DRAWS):
        some = np.concatenate([members[i] for i in rng.integers(0, len(members), len(members))])
        drawn.append(score(estimated[some], good[some]))
    low, high = np.nanpercentile(drawn, (2.5, 97.5))
    return score(estimated, good), float(low), float(high)
