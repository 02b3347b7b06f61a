"""The probability that a grasp holds: a logistic regression, and how well it tells.

AUC is the share of pairs of a good and a bad grasp that a score orders rightly (Hanley and McNeil,
1982). The calibration error is the mean distance between what is told and what comes true, over
bins of equally many grasps (Naeini et al., 2015).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from rich.table import Table

from app.lab.grasps.outcomes import FEATURES, SceneOutcomes
from app.lab.logistic import Logistic, fit_logistic
from config import ConfigError

Array: TypeAlias = npt.NDArray[np.float64]
Score: TypeAlias = Callable[[Array, Array], float]

BINS = 10
"""Of the calibration error."""
_DRAWS = 1000  # of a bootstrap


@dataclass(frozen=True, kw_only=True)
class Telling:
    """How well a probability tells; each with its 95 % interval."""

    name: str
    auc: tuple[float, float, float]
    calibration: tuple[float, float, float]


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


def judge_probabilities(
    fitted: Sequence[SceneOutcomes], judged: Sequence[SceneOutcomes]
) -> tuple[Logistic, list[Telling]]:
    """Fit to some scenes and judge by others.

    Beside all features stand the quality as it is, and logistics on it and on the lever arm alone.

    Raises:
        ConfigError: there is nothing to fit to or to judge by, or the scenes are the same.
    """
    for scenes, what in ((fitted, "fit to"), (judged, "judge by")):
        if len({each.good for scene in scenes for each in scene.outcomes}) < 2:
            raise ConfigError(f"the outcomes to {what} are all the same; collect more scenes")
    if {each.group for each in fitted} & {each.group for each in judged}:
        raise ConfigError("the outcomes to fit to and to judge by are of the same objects")
    features, good = _arrays(fitted)
    seen, held = _arrays(judged)
    whole = fit_logistic(features, good)
    quality, lever = (FEATURES.index(name) for name in ("quality", "lever"))
    told = {
        "all features": whole(seen),
        "lever arm": fit_logistic(features[:, [lever]], good)(seen[:, [lever]]),
        "quality, fitted": fit_logistic(features[:, [quality]], good)(seen[:, [quality]]),
        "quality": seen[:, quality],
    }
    counts = [len(scene.outcomes) for scene in judged]
    owner = np.repeat(np.arange(len(judged)), counts).astype(np.int64)
    tellings = [
        Telling(
            name=name,
            auc=_with_interval(auc, values, held, owner),
            calibration=_with_interval(calibration_error, values, held, owner),
        )
        for name, values in told.items()
    ]
    return whole, tellings


def probability_report(
    fitted: Sequence[SceneOutcomes], judged: Sequence[SceneOutcomes]
) -> tuple[Table, list[str]]:
    """A table of how well each tells, and the coefficients.

    Raises:
        ConfigError: see `judge_probabilities`.
    """
    model, tellings = judge_probabilities(fitted, judged)
    good = _arrays(judged)[1]
    title = f"{len(good)} grasps in {len(judged)} scenes, {int(good.sum())} held"
    table = Table("told by", "AUC", "calibration error", title=title)
    for each in tellings:
        cells = (f"{v:.3f} ({low:.3f} to {high:.3f})" for v, low, high in _both(each))
        table.add_row(each.name, *cells)
    names = (*FEATURES, "constant")
    of_each = ", ".join(f"{n} {w:+.2f}" for n, w in zip(names, model.weights, strict=True))
    return table, [f"fitted to {len(_arrays(fitted)[1])} grasps: {of_each}"]


def _both(each: Telling) -> tuple[tuple[float, float, float], ...]:
    return each.auc, each.calibration


def _arrays(scenes: Sequence[SceneOutcomes]) -> tuple[Array, Array]:
    outcomes = [each for scene in scenes for each in scene.outcomes]
    return np.array([each.features for each in outcomes]), np.array(
        [float(each.good) for each in outcomes]
    )


def _with_interval(
    score: Score, told: Array, good: Array, owner: npt.NDArray[np.int64]
) -> tuple[float, float, float]:
    """A score and its interval by a bootstrap over the scenes (Efron, 1979)."""
    rng = np.random.default_rng(0)
    members = [np.flatnonzero(owner == scene) for scene in range(int(owner.max()) + 1)]
    drawn = []
    for _ in range(_DRAWS):
        some = np.concatenate([members[i] for i in rng.integers(0, len(members), len(members))])
        drawn.append(score(told[some], good[some]))
    low, high = np.nanpercentile(drawn, (2.5, 97.5))
    return score(told, good), float(low), float(high)
