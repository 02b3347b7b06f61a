"""Registration of a scan and a depth image to the map: the pose, and which furniture was moved."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from perception.frame import Array, Mask
from perception.registration.matching import MatchSettings, Problem, Solution
from perception.registration.planar import difference, wrap
from perception.registration.sensors import Cloud
from perception.registration.surfaces import Surfaces

CHI2_3 = 16.27
"""What a squared Mahalanobis distance in three dimensions exceeds once in 1000."""
_REPEATS = 3.0
"""Points measured again from the same place are worth at most so many independent ones: their
errors are of the place (edges, materials, the map) as much as of chance."""
_LEAST = 1e-3
"""What points say of a direction, as a share of what was known, that is no rounding error."""
_DEFAULT = MatchSettings()


@dataclass(frozen=True, kw_only=True, eq=False)
class Displacement:
    """A piece of furniture that may not stand where the map has it."""

    piece: str
    centre: Array
    """(2,) where it would be in the map [m]."""
    by: Array
    """(3,) x, y [m] of its centre and heading [rad] about it, in the map."""
    covariance: Array
    """(3, 3)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Registration:
    """What matching the measured points to the map says of the base."""

    pose: Array
    """(3,) mTb at capture, the maximum a posteriori: x, y [m], heading [rad]."""
    covariance: Array
    """(3, 3) of `pose`; axes of the map."""
    prior: Array
    """(3,) mTb before."""
    mahalanobis: float
    """Squared, of the correction in the prior's covariance."""
    information: Array
    """(3, 3) on the pose, of the points alone; zero along what they do not show."""
    limit: Array
    """(3, 3) the most that this view says, however often it is measured: points of a sensor or on a
    piece of furniture have errors in common."""
    points: Array
    """(N, 3) points that lie on a surface, in the map [m]."""
    residuals: Array
    """(N,) their signed distances from it [m]."""
    alone: frozenset[str]
    """The pieces of furniture on which the pose rests, if they touch each other: that they stand in
    their places is not confirmed. Empty if more is in sight, or nothing."""
    confirmed: bool
    """Whether the pose rests on things apart from each other, or on a wall."""
    explained: float
    """Share of the points near a surface that lie on it; 0 if there are none."""
    displaced: tuple[Displacement, ...]
    """Furniture that was moved; the pose does not rest on it."""
    uncertain: tuple[Displacement, ...]
    """Furniture that may have been moved, or other furniture was; the pose does not rest on it."""

    @property
    def consistent(self) -> bool:
        """Whether the prior explains the correction."""
        return self.mahalanobis < CHI2_3

    def innovation(self, mTb: Array, information: Array) -> tuple[Array, float]:
        """(3,) what the points alone say, less a pose, and its normalised square.

        Args:
            mTb: (3,) the pose.
            information: (3, 3) on it.
        """
        # Undone from the prior that they were matched with.
        shift = np.linalg.solve(self.covariance, difference(self.pose, self.prior))
        # What is known next to nothing of stays where the prior has it.
        data = self.information
        alone = self.prior + np.linalg.solve(data + _LEAST * information, shift)
        off = difference(alone, mTb)
        return off, float(off @ parallel(data, information) @ off)


def register(
    surfaces: Surfaces,
    clouds: Sequence[Cloud],
    prior: Array,
    covariance: Array,
    *,
    moved: Collection[str] = (),
    judgement: int | None = 0,
    settings: MatchSettings = _DEFAULT,
) -> Registration:
    """Match what was measured at one time to the map.

    A piece counts as moved only if another piece in sight outvotes it: of one piece alone, a pose
    error and a displacement look the same, and it is taken to be the pose. What was known before
    tells them apart (`Localisation.registered`).

    Args:
        surfaces: the map.
        clouds: what each sensor measured.
        prior: (3,) mTb expected at capture.
        covariance: (3, 3) of it, positive definite.
        moved: pieces that are known to have been moved, as of the last registration.
        judgement: how often the furniture was judged before, to find out what else was moved; None
            judges nothing, and what does not fit is an outlier.
        settings: what is assumed of noise and furniture.
    """
    problem = Problem(surfaces, clouds, prior, covariance, settings)
    known = [k for k, piece in enumerate(problem.pieces) if surfaces.names[piece] in moved]
    solution = problem.solve(frozenset(known))
    if judgement is not None:
        solution = _with_furniture(problem, surfaces, solution, settings, judgement)
    shift = solution.x[:3]
    spread = np.asarray(np.linalg.inv(solution.information), dtype=np.float64)
    displaced: list[Displacement] = []
    uncertain: list[Displacement] = []
    for column in sorted(solution.loose):
        name = surfaces.names[problem.pieces[column]]
        at = problem.displacement(column)
        by, its = solution.x[at], spread[at, at]
        centre = surfaces.centres[problem.pieces[column]]
        one = Displacement(piece=name, centre=centre, by=by, covariance=its)
        (displaced if by @ np.linalg.solve(its, by) > CHI2_3 else uncertain).append(one)
    used = solution.losses < 0.5 * settings.loss_scale**2
    pose = prior + shift
    alone, confirmed = _witnesses(problem, surfaces, solution, used, settings)
    return Registration(
        pose=np.array([pose[0], pose[1], wrap(float(pose[2]))]),
        covariance=spread[:3, :3],
        prior=prior,
        mahalanobis=float(shift @ np.linalg.solve(covariance, shift)),
        information=problem.marginal(solution),
        limit=problem.marginal(solution, _REPEATS),
        points=solution.match.points[used],
        residuals=solution.match.residuals[used],
        alone=alone,
        confirmed=confirmed,
        explained=float(used.mean()) if len(used) else 0.0,
        displaced=tuple(displaced),
        uncertain=tuple(uncertain),
    )


def _witnesses(
    problem: Problem, surfaces: Surfaces, solution: Solution, used: Mask, settings: MatchSettings
) -> tuple[frozenset[str], bool]:
    """`Registration.alone` and `Registration.confirmed`."""
    counts = np.bincount(solution.match.column[used], minlength=len(problem.pieces))
    counts[list(solution.loose)] = 0
    pieces = problem.pieces[counts > 0]
    many = problem.pieces[counts >= settings.support]
    if surfaces.fixed[many].any() or len(set(surfaces.stacks[many].tolist())) > 1:
        return frozenset(), True
    if surfaces.fixed[pieces].any() or len(set(surfaces.stacks[pieces].tolist())) != 1:
        return frozenset(), False
    return frozenset(surfaces.names[piece] for piece in pieces), False


def _with_furniture(
    problem: Problem,
    surfaces: Surfaces,
    best: Solution,
    settings: MatchSettings,
    judgement: int,
) -> Solution:
    """The solution in which as little furniture as possible was moved.

    Errors of the sensors can hide a displacement: where nothing is suspected, one piece in turn is
    tried all the same.
    """
    counts = np.bincount(best.match.column, minlength=len(problem.pieces))
    if (counts >= settings.support).sum() < 2:
        return best
    movable = np.flatnonzero((counts >= settings.support) & ~surfaces.fixed[problem.pieces])
    left = [column for column in movable.tolist() if column not in best.loose]
    solve = cache(problem.solve)
    if left and not problem.suspects(best):
        trial = solve(best.loose | {left[judgement % len(left)]})
        if trial.cost >= best.cost:
            return best
    while left:
        trials = [solve(best.loose | {column}) for column in left]
        first = min(trials, key=lambda trial: trial.cost)
        if first.cost >= best.cost:
            break
        # Of pieces that contradict each other alike, none can be believed.
        worth = min(first.cost + settings.price, best.cost)
        rivals = [trial.loose for trial in trials if trial.cost < worth]
        best = first if len(rivals) < 2 else solve(frozenset().union(*rivals))
        if not problem.suspects(best):
            break
        left = [column for column in left if column not in best.loose]
    return best


def parallel(A: Array, B: Array) -> Array:
    """(A⁻¹ + B⁻¹)⁻¹ of two positive semidefinite matrices of which the sum is regular."""
    return A - A @ np.linalg.solve(A + B, A)
