"""Logistic regression."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]

_RIDGE = 1.0  # weight of the squared coefficients
_ROUNDS, _SMALL = 100, 1e-10  # of Newton's method at most, and the step at which it ends


@dataclass(frozen=True, kw_only=True)
class Logistic:
    """Coefficients on standardised features."""

    middle: Array
    """(F,) means of the features."""
    spread: Array
    """(F,) their standard deviations."""
    weights: Array
    """(F + 1,) the last is the constant."""

    def __call__(self, features: Array) -> Array:
        """(N,) probabilities for (N, F) features."""
        return _sigmoid(_with_constant((features - self.middle) / self.spread) @ self.weights)


def fit_logistic(features: Array, good: Array, ridge: float = _RIDGE) -> Logistic:
    """Newton's method.

    Args:
        features: (N, F).
        good: (N,) 0 or 1.
        ridge: weight of the squared coefficients.
    """
    middle = features.mean(axis=0)
    spread = np.maximum(features.std(axis=0), 1e-12)
    design = _with_constant((features - middle) / spread)
    penalty = np.diag([*np.full(features.shape[1], ridge), 1e-9])
    weights = np.zeros(design.shape[1])
    for _ in range(_ROUNDS):
        told = _sigmoid(design @ weights)
        slope = design.T @ (good - told) - penalty @ weights
        curvature = design.T @ (design * (told * (1.0 - told))[:, None]) + penalty
        step = np.linalg.solve(curvature, slope)
        weights = weights + step
        if np.abs(step).max() < _SMALL:
            break
    return Logistic(middle=middle, spread=spread, weights=weights)


def _sigmoid(x: Array) -> Array:
    value: Array = 1.0 / (1.0 + np.exp(-np.clip(x, -500.0, 500.0)))
    return value


def _with_constant(features: Array) -> Array:
    return np.concatenate([features, np.ones((len(features), 1))], axis=1)
