"""Splits touching objects of one colour where a boundary between them is likely.

A small network on the features of a boundary, fitted to simulated scenes (`python -m
lab.grasps.seams`), estimates how likely it is. The likeliest is cut, and both sides are split
again.
"""

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from config.arrays import Array, Indices, Mask
from perception.objects.boundaries import (
    BOUNDARY_FEATURES,
    Blob,
    boundary_features,
    candidate_boundaries,
)
from perception.objects.footprint import Grid

WEIGHTS = Path(__file__).parents[1] / "weights" / "seams.json"
_LITTLE = 1e-4  # is added before logarithms are taken
_FARTHEST = 4.0  # features are clipped to this [standard deviations]


@dataclass(frozen=True, kw_only=True, eq=False)
class BoundaryModel:
    """How likely a boundary separates two objects."""

    middle: Array  # (F,) mean of the logarithm of each feature
    spread: Array  # (F,) their standard deviations
    layers: tuple[tuple[Array, Array], ...]
    """(outputs, inputs) weights and (outputs,) constants; all but the last rectify."""
    needed: float  # least likelihood of a boundary that is cut

    def inputs(self, measures: Array) -> Array:
        """(N, F) of the first layer for (N, F) features."""
        far = (log_features(measures) - self.middle) / self.spread
        inputs: Array = np.clip(far, -_FARTHEST, _FARTHEST)
        return inputs

    def likely(self, measures: Array) -> Array:
        """(N,) probabilities for (N, F) features."""
        values = self.inputs(measures)
        for weights, constants in self.layers[:-1]:
            values = np.maximum(values @ weights.T + constants, 0.0)
        weights, constants = self.layers[-1]
        odds = (values @ weights.T + constants)[:, 0]
        likely: Array = 1.0 / (1.0 + np.exp(-np.clip(odds, -500.0, 500.0)))
        return likely


def log_features(measures: Array) -> Array:
    """Logarithms of features of any shape."""
    logs: Array = np.log(np.maximum(measures, 0.0) + _LITTLE)
    return logs


@cache
def boundary_model() -> BoundaryModel:
    """The shipped one."""
    shipped = json.loads(WEIGHTS.read_text(encoding="utf-8"))
    assert tuple(shipped["measures"]) == BOUNDARY_FEATURES
    return BoundaryModel(
        middle=np.array(shipped["middle"]),
        spread=np.array(shipped["spread"]),
        layers=tuple((np.array(w), np.array(b)) for w, b in shipped["layers"]),
        needed=float(shipped["needed"]),
    )


def split_touching(of_point: Indices, points: Array, floor: float, cell: float) -> Indices:
    """Numbers (P,) of points (P, 3) in odometry [m] after splitting; 0 belongs to nothing.

    `floor` is the height that objects stand on, `cell` the side of the cells of blobs [m].
    """
    cut = of_point.copy()
    open_numbers = [int(n) for n in np.unique(of_point) if n > 0]
    newest = max(open_numbers, default=0)
    while open_numbers:
        number = open_numbers.pop()
        mine = np.flatnonzero(cut == number)
        blob, at = blob_of(points[mine], floor, cell)
        part = _part(blob)
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
    """A blob from its (P, 3) points, and the row and column (P,) of each."""
    own = points - np.array([0.0, 0.0, floor])
    grid = Grid.over(own, cell)
    blob = Blob(above=grid.heights(own), cells=grid.covered(own), cell=cell)
    return blob, grid.cells_of(own)


def _part(blob: Blob) -> Mask | None:
    """One side of the likeliest boundary; None if none is likely."""
    found = list(candidate_boundaries(blob))
    if not found:
        return None
    model = boundary_model()
    likely = model.likely(np.array([boundary_features(blob, parts) for parts in found]))
    best = int(likely.argmax())
    return found[best][1] if likely[best] > model.needed else None
