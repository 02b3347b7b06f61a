"""How well a probability tells whether a grasp holds, by outcomes that nothing was fitted to.

AUC is the share of pairs of a good and a bad grasp that a score orders rightly (Hanley and McNeil,
1982). The calibration error is the mean distance between what is told and what comes true, over
bins of equally many grasps (Naeini et al., 2015).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from rich.table import Table

from config import ConfigError
from lab.grasps.outcomes import SETS, Outcomes, group_of
from perception import NUMBERS, HoldProbability

Array: TypeAlias = npt.NDArray[np.float64]
Score: TypeAlias = Callable[[Array, Array], float]

BINS = 10
"""Of the calibration error."""
_DRAWS = 1000  # of a bootstrap
_FOLDS = 10  # of scenes: what is fitted to nine is told of the tenth
_SURE = 1e-6  # nothing is told to be less or more likely than this, and 1 less this
_NEWTON = 25  # steps of a logistic regression


def auc(told: Array, good: Array) -> float:
    """Area under the ROC curve; ties count half, NaN without both outcomes."""
    positive, negative = told[good > 0.5], np.sort(told[good < 0.5])
    if not len(positive) or not len(negative):
        return float("nan")
    below = np.searchsorted(negative, positive, "left")
    not_above = np.searchsorted(negative, positive, "right")
    return float((below + not_above).mean() / (2 * len(negative)))


def calibration_error(told: Array, good: Array) -> float:
    """Mean of |told - true| over `BINS` bins of equally many grasps."""
    order = np.argsort(told, kind="stable")
    parts = [part for part in np.array_split(order, BINS) if len(part)]
    return float(sum(abs(told[p].sum() - good[p].sum()) for p in parts) / len(told))


def told_the_mass(told: Array, judged: Outcomes) -> Array:
    """(N,) what could be told who knew the masses, too, which no image shows.

    A logistic regression on the odds that are told, the mass, its logarithm, and the torque that
    it has about the grasp; fitted to other scenes than those that it tells of.
    """
    numbers = dict(zip(NUMBERS, judged.patches.numbers.T.astype(float), strict=True))
    lever = np.hypot(numbers["middle_along"], numbers["middle_across"])
    sure = np.clip(told, _SURE, 1.0 - _SURE)
    odds = np.log(sure / (1.0 - sure))
    seen = np.stack([odds, judged.mass, np.log(judged.mass), judged.mass * lever], axis=1)
    seen = np.insert((seen - seen.mean(0)) / seen.std(0).clip(1e-9), 0, 1.0, axis=1)
    scenes = np.random.default_rng(0).permutation(np.unique(judged.scene))
    result = np.zeros(len(told))
    for some in np.array_split(scenes, _FOLDS):
        there = np.isin(judged.scene, some)
        others, good = seen[~there], judged.good[~there].astype(float)
        weights = np.zeros(seen.shape[1])
        for _ in range(_NEWTON):
            p = _sigmoid(others @ weights)
            curvature = (others * (p * (1.0 - p))[:, None]).T @ others + np.eye(len(weights))
            weights -= np.linalg.solve(curvature, others.T @ (p - good) + weights)
        result[there] = _sigmoid(seen[there] @ weights)
    return result


def _sigmoid(odds: Array) -> Array:
    result: Array = 1.0 / (1.0 + np.exp(-odds))
    return result


def probability_table(judged: Outcomes, hold: HoldProbability) -> Table:
    """How well a network tells; beside it the same who knew the masses, and the score of the check.

    Each with its 95 % interval, of all, of single objects and bins, and of each group of objects.

    Raises:
        ConfigError: the outcomes are all the same.
    """
    good = judged.good.astype(float)
    if len(set(good)) < 2:
        raise ConfigError("the outcomes to judge by are all the same; collect more scenes")
    by_network = hold(judged.patches)
    told = {
        "the network": by_network,
        "who knew the mass, too": told_the_mass(by_network, judged),
        "the score of the check": judged.patches.numbers[:, NUMBERS.index("score")].astype(float),
    }
    title = f"{len(good)} grasps in {len(np.unique(judged.scene))} scenes, {int(good.sum())} good"
    table = Table("told by", "grasps", "AUC", "calibration error", title=title)
    _, groups = SETS["heldout"]
    of_groups = np.array([group_of(int(seed), groups) for seed in judged.scene])
    parts = {
        "all": np.ones(len(good), dtype=np.bool_),
        "single": judged.objects == 1,
        "in a bin": judged.objects > 1,
        **{group: of_groups == group for group in groups},
    }
    for name, values in told.items():
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
    score: Score, told: Array, good: Array, owner: npt.NDArray[np.int64]
) -> tuple[float, float, float]:
    """A score and its interval by a bootstrap over the scenes (Efron, 1979)."""
    rng = np.random.default_rng(0)
    members = [np.flatnonzero(owner == scene) for scene in np.unique(owner)]
    drawn = []
    for _ in range(_DRAWS):
        some = np.concatenate([members[i] for i in rng.integers(0, len(members), len(members))])
        drawn.append(score(told[some], good[some]))
    low, high = np.nanpercentile(drawn, (2.5, 97.5))
    return score(told, good), float(low), float(high)
