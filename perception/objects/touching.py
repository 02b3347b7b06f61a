"""ObjectRegion of one colour that touch, cut apart where a seam between two of them is likely.

How likely a seam is says a small network on its measures, fitted to simulated scenes
(`python -m lab.bench.seams`). The likeliest is cut, and both sides are looked at again.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from perception.frame import Array, Indices, Mask
from perception.objects.boundaries import (
    BOUNDARY_FEATURES,
    Blob,
    boundary_features,
    candidate_boundaries,
)
from perception.objects.grid import Grid

WEIGHTS = Path(__file__).parents[1] / "weights" / "seams.json"
_LITTLE = 1e-4  # is added before log_features are taken
_FARTHEST = 4.0  # what is farther from the mean counts as so far [standard deviations]


@dataclass(frozen=True, kw_only=True, eq=False)
class BoundaryModel:
    """How likely two things meet at a seam."""

    middle: Array
    """(F,) mean of the logarithm of each measure."""
    spread: Array
    """(F,) their standard deviations."""
    layers: tuple[tuple[Array, Array], ...]
    """(outputs, inputs) weights and (outputs,) constants of each; all but the last rectify."""
    needed: float
    """A seam that is less likely than this is not cut."""

    def inputs(self, measures: Array) -> Array:
        """(N, F) of the first layer for (N, F) measures."""
        far = (log_features(measures) - self.middle) / self.spread
        inputs: Array = np.clip(far, -_FARTHEST, _FARTHEST)
        return inputs

    def likely(self, measures: Array) -> Array:
        """(N,) probabilities for (N, F) measures."""
        values = self.inputs(measures)
        for weights, constants in self.layers[:-1]:
            values = np.maximum(values @ weights.T + constants, 0.0)
        weights, constants = self.layers[-1]
        odds = (values @ weights.T + constants)[:, 0]
        told: Array = 1.0 / (1.0 + np.exp(-np.clip(odds, -500.0, 500.0)))
        return told


def log_features(measures: Array) -> Array:
    """Of measures of any shape; small ones are told apart as well as large ones."""
    told: Array = np.log(np.maximum(measures, 0.0) + _LITTLE)
    return told


@cache
def boundary_model() -> BoundaryModel:
    """The shipped one."""
    told = json.loads(WEIGHTS.read_text(encoding="utf-8"))
    assert tuple(told["measures"]) == BOUNDARY_FEATURES
    return BoundaryModel(
        middle=np.array(told["middle"]),
        spread=np.array(told["spread"]),
        layers=tuple((np.array(w), np.array(b)) for w, b in told["layers"]),
        needed=float(told["needed"]),
    )


def split_touching(of_point: Indices, points: Array, floor: float, cell: float) -> Indices:
    """Numbers (P,) of points, from 1; pieces with a likely seam in them are cut.

    Args:
        of_point: numbers from 1; 0 belongs to nothing.
        points: (P, 3) in the world [m].
        floor: what things stand on [m].
        cell: side of the cells that pieces are looked at in [m].
    """
    cut = of_point.copy()
    open_numbers = [int(n) for n in np.unique(of_point) if n > 0]
    newest = max(open_numbers, default=0)
    while open_numbers:
        number = open_numbers.pop()
        mine = np.flatnonzero(cut == number)
        piece, at = blob_of(points[mine], floor, cell)
        part = _part(piece)
        if part is None:
            continue
        is_part = part[at]
        if not is_part.any() or is_part.all():
            continue
        newest += 1
        cut[mine[is_part]] = newest
        open_numbers += [number, newest]
    return cut


def blob_of(points: Array, floor: float, cell: float) -> tuple[Blob, tuple[Indices, Indices]]:
    """A piece from its (P, 3) points, and the row and column (P,) of each."""
    own = points - np.array([0.0, 0.0, floor])
    grid = Grid.over(own, cell)
    piece = Blob(above=grid.heights(own), cells=grid.covered(own), cell=cell)
    return piece, grid.cells_of(own)


def _part(piece: Blob) -> Mask | None:
    """What lies on one side of the likeliest seam; None if none is likely."""
    found = list(candidate_boundaries(piece))
    if not found:
        return None
    model = boundary_model()
    likely = model.likely(np.array([boundary_features(piece, parts) for parts in found]))
    best = int(likely.argmax())
    return found[best][1] if likely[best] > model.needed else None
