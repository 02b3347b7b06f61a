"""Registration of a scan and a depth image to the map: the pose, and which furniture was moved."""

from collections.abc import Collection, Generator, Iterable, Sequence
from dataclasses import dataclass
from math import radians
from typing import NamedTuple

import numpy as np

from config.arrays import Array, Indices, Mask
from config.planar import difference, wrap
from perception.registration.matching import LOSS_SCALE, PRICE, SUPPORT, Problem, Solution
from perception.registration.sensors import Cloud
from perception.registration.surfaces import Surfaces

CHI2_3 = 16.27
"""What a squared Mahalanobis distance in three dimensions exceeds once in 1000."""
_REPEATS = 3.0
"""Points measured again from the same place are worth at most so many independent ones: their
errors are of the place (edges, materials, the map) as much as of chance."""
_LEAST = 1e-3
"""What points say of a direction, as a share of what was known, that is no rounding error."""
_AROUND = np.arange(-1.5, 1.6, 0.5)
"""Where else the base is looked for, from where it was found: x, y [m], ..."""
_ASTRAY = np.diag([0.2, 0.2, radians(2.0)]) ** 2
"""... each within this covariance."""
_APART = 0.3
"""Poses that are nearer to each other are the same [m]."""
_AS_WELL = 0.8
"""A pose agrees as well if it has this share of the best one's support."""
_JUDGED = 5
"""Every fifth registration is judged by what it shows of the furniture."""


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
    """Furniture that was moved, by this registration or one before it that was judged meanwhile;
    the pose does not rest on it."""
    uncertain: tuple[Displacement, ...]
    """Furniture that may have been moved, or other furniture was; the pose does not rest on it."""
    missed: Indices
    """(2, P) how many rays go through each piece of the map, and how many end before it."""

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

    @property
    def support(self) -> int:
        """How many points lie on the map, less the rays that go through what it has."""
        return len(self.points) - int(self.missed[0].sum())


class _Verdict(NamedTuple):
    """Furniture that was moved, and such that may have been."""

    displaced: tuple[Displacement, ...] = ()
    uncertain: tuple[Displacement, ...] = ()


class Judge:
    """Finds out which furniture was moved, by at most one trial at each registration."""

    def __init__(self) -> None:
        self._turn = self._waited = 0
        self._trials: Generator[None, None, _Verdict] | None = None

    def go_on(self) -> _Verdict:
        """Make the next trial; until the last of a registration the verdict is empty."""
        if self._trials is not None:
            try:
                next(self._trials)
            except StopIteration as end:
                self._trials, verdict = None, end.value
                assert isinstance(verdict, _Verdict)
                return verdict
        return _Verdict()

    def consider(self, problem: Problem, solution: Solution) -> None:
        """Judge from now on what this registration shows, if it is time to."""
        if self._trials is None and self._waited <= 0:
            self._trials = _trials(problem, solution, self._turn)
            self._turn, self._waited = self._turn + 1, _JUDGED
        self._waited -= 1


def register(
    surfaces: Surfaces,
    clouds: Sequence[Cloud],
    prior: Array,
    covariance: Array,
    *,
    moved: Collection[str] = (),
    judge: Judge | None = None,
) -> Registration:
    """Match what was measured at one time to the map.

    A piece counts as moved only if another piece in sight outvotes it: of one piece alone, a pose
    error and a displacement look the same, and it is taken to be the pose. What was known before
    tells them apart (`LocalisationFilter.registered`).

    Args:
        surfaces: the map.
        clouds: what each sensor measured.
        prior: (3,) mTb expected at capture.
        covariance: (3, 3) of it, positive definite.
        moved: pieces that are known to have been moved, as of the last registration.
        judge: finds out over registrations what else was moved; None judges nothing. What does not
            fit until then is an outlier.
    """
    verdict = _Verdict() if judge is None else judge.go_on()
    problem = Problem(surfaces, clouds, prior, covariance)
    judged = {one.piece for some in verdict for one in some}
    loose = [k for k in range(len(problem.pieces)) if problem.name(k) in judged.union(moved)]
    solution = problem.solve(frozenset(loose))
    if judge is not None:
        judge.consider(problem, solution)
    here = _verdict(problem, solution, [k for k in loose if problem.name(k) not in judged])
    shift = solution.x[:3]
    used = solution.losses < 0.5 * LOSS_SCALE**2
    pose = prior + shift
    nothing = np.zeros((2, len(surfaces.names)), dtype=np.int64)
    alone, confirmed = _witnesses(problem, surfaces, solution, used)
    return Registration(
        pose=np.array([pose[0], pose[1], wrap(float(pose[2]))]),
        covariance=np.asarray(np.linalg.inv(solution.information)[:3, :3]),
        prior=prior,
        mahalanobis=float(shift @ np.linalg.solve(covariance, shift)),
        information=problem.marginal(solution),
        limit=problem.marginal(solution, _REPEATS),
        points=solution.match.points[used],
        residuals=solution.match.residuals[used],
        alone=alone,
        confirmed=confirmed,
        explained=float(used.mean()) if len(used) else 0.0,
        displaced=verdict.displaced + here.displaced,
        uncertain=verdict.uncertain + here.uncertain,
        missed=sum((surfaces.missed(pose, one) for one in clouds), nothing),
    )


def rivals(
    surfaces: Surfaces,
    clouds: Sequence[Cloud],
    found: Registration,
    known: Sequence[Array] | None = None,
) -> list[Array]:
    """Other poses mTb (3,) at which the map agrees about as well with what was measured.

    Args:
        surfaces: the map.
        clouds: what each sensor measured.
        found: where the base was found.
        known: poses of which it may still be any; None looks around, as far as 1.8 m away.
    """
    if known is None:
        known = [found.pose + np.array([x, y, 0.0]) for x in _AROUND for y in _AROUND]
    ends = [register(surfaces, clouds, start, _ASTRAY) for start in known]
    least = _AS_WELL * max(one.support for one in (found, *ends))
    others: list[Array] = []
    for one in ends:
        is_new = all(np.hypot(*(one.pose - it)[:2]) > _APART for it in (found.pose, *others))
        if is_new and one.consistent and one.support > least:
            others.append(one.pose)
    return others


def _witnesses(
    problem: Problem, surfaces: Surfaces, solution: Solution, used: Mask
) -> tuple[frozenset[str], bool]:
    """`Registration.alone` and `Registration.confirmed`."""
    counts = np.bincount(solution.match.column[used], minlength=len(problem.pieces))
    counts[list(solution.loose)] = 0
    pieces = problem.pieces[counts > 0]
    many = problem.pieces[counts >= SUPPORT]
    if surfaces.fixed[many].any() or len(set(surfaces.stacks[many].tolist())) > 1:
        return frozenset(), True
    if surfaces.fixed[pieces].any() or len(set(surfaces.stacks[pieces].tolist())) != 1:
        return frozenset(), False
    return frozenset(surfaces.names[piece] for piece in pieces), False


def _verdict(problem: Problem, solution: Solution, columns: Iterable[int]) -> _Verdict:
    """Where the pieces of these columns stand, which may have been moved."""
    surfaces = problem.surfaces
    spread = np.asarray(np.linalg.inv(solution.information), dtype=np.float64)
    displaced: list[Displacement] = []
    uncertain: list[Displacement] = []
    for column in columns:
        at = problem.displacement(column)
        by, its = solution.x[at], spread[at, at]
        centre = surfaces.centres[problem.pieces[column]]
        one = Displacement(piece=problem.name(column), centre=centre, by=by, covariance=its)
        (displaced if by @ np.linalg.solve(its, by) > CHI2_3 else uncertain).append(one)
    return _Verdict(tuple(displaced), tuple(uncertain))


def _trials(problem: Problem, first: Solution, turn: int) -> Generator[None, None, _Verdict]:
    """Find the solution in which as little more furniture as possible was moved.

    Errors of the sensors can hide a displacement: where nothing is suspected, one piece in turn is
    tried all the same.
    """
    solved: dict[frozenset[int], Solution] = {}

    def solve(loose: frozenset[int]) -> Generator[None, None, Solution]:
        if loose not in solved:
            solved[loose] = problem.solve(loose)
            yield
        return solved[loose]

    best = first
    counts = np.bincount(best.match.column, minlength=len(problem.pieces))
    many = counts >= SUPPORT
    movable = np.flatnonzero(many & ~problem.surfaces.fixed[problem.pieces])
    left = [column for column in movable.tolist() if column not in best.loose]
    if many.sum() < 2 or not left:
        return _Verdict()
    if not problem.suspects(best):
        trial = yield from solve(best.loose | {left[turn % len(left)]})
        if trial.cost >= best.cost:
            return _Verdict()
    while left:
        trials: list[Solution] = []
        for column in left:
            trials.append((yield from solve(best.loose | {column})))
        least = min(trials, key=lambda trial: trial.cost)
        if least.cost >= best.cost:
            break
        # Of pieces that contradict each other alike, none can be believed.
        worth = min(least.cost + PRICE, best.cost)
        rivals = [trial.loose for trial in trials if trial.cost < worth]
        best = yield from solve(frozenset().union(*rivals))
        if not problem.suspects(best):
            break
        left = [column for column in left if column not in best.loose]
    return _verdict(problem, best, sorted(best.loose - first.loose))


def parallel(A: Array, B: Array) -> Array:
    """(A⁻¹ + B⁻¹)⁻¹ of two positive semidefinite matrices of which the sum is regular."""
    return A - A @ np.linalg.solve(A + B, A)
