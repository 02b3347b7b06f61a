"""A task by a robot that is wrong about where it is: levels, scenes and sensors.

The judge is the simulated world: what was placed, what was touched, and where the base truly was.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
from rich.table import Table

from app.core import Instruments, RegistrationForm, RunOptions, Setup, Summary, Tick, run_task
from config.planar import difference, on_floor
from lab.shared import fixed, machine, run_in_order, table
from trees.language import TreeNode

_EVERY = 10  # ticks between two looks at the pose


@dataclass(frozen=True, kw_only=True)
class UncertainRun:
    """One run."""

    level: str
    registration: str
    scene: str
    summary: Summary
    pose_errors: tuple[tuple[float, float, float], ...]
    """Distance [m] and angle [rad] from the true pose of the base, and the NEES: the squared
    Mahalanobis distance of the estimate, by its 3 degrees of freedom; NaN where it is exact."""


class _Judge(Instruments):
    """Compares where the robot believes to be with where it is."""

    def __init__(self) -> None:
        self.errors: list[tuple[float, float, float]] = []

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        """Take the simulated world."""
        self._truth = setup.truth

    def after(self, tick: Tick) -> None:
        """Note the error, every so many ticks."""
        true = None if self._truth is None else self._truth.base
        if true is None or tick.number % _EVERY:
            return
        here = tick.context.localisation
        x, y, turn = difference(on_floor(here.mTb), on_floor(true)).tolist()
        nees = np.nan
        if here.estimate is not None:
            off = difference(here.estimate[0], on_floor(true))
            nees = float(off @ np.linalg.solve(here.estimate[1], off)) / 3.0
        self.errors.append((float(np.hypot(x, y)), abs(turn), nees))


def run_uncertainty(
    options: RunOptions,
    levels: Sequence[str],
    registrations: Sequence[str],
    scenes: Sequence[str],
    seeds: Sequence[int],
    done: Callable[[Summary], None],
    *,
    workers: int | str | None,
) -> list[UncertainRun]:
    """Run the task for every level, registration, scene and seed; `exact` needs no registration.

    `options` are those of each run but for these four; `done` is called after each run.
    """
    wanted = [
        replace(
            options, localisation=level, registration=RegistrationForm(form), scene=scene, seed=seed
        )
        for level, form, scene, seed in product(levels, registrations, scenes, seeds)
        if level != "exact" or form == registrations[0]
    ]
    return run_in_order(_run, wanted, lambda run: done(run.summary), workers=workers, batch=1)


def _run(options: RunOptions) -> UncertainRun:
    judge = _Judge()
    result = run_task(options, instruments=judge)
    return UncertainRun(
        level=str(options.localisation),
        registration=options.registration.value,
        scene=options.scene or "",
        summary=result.summary,
        pose_errors=tuple(judge.errors),
    )


@dataclass(frozen=True, kw_only=True)
class UncertaintyFigures:
    """All runs of one level, registration and scene."""

    level: str
    registration: str
    scene: str
    runs: int
    succeeded: int
    objects: int
    placed: int
    attempts: int
    duration_mean_s: float
    contacts: int
    position_error_m: tuple[float, float]  # median and 90th percentile over the time of all runs
    heading_error_rad: tuple[float, float]
    nees: float | None  # mean; 1 is consistent, less is too cautious. None where the pose is exact


def uncertainty_figures(runs: Sequence[UncertainRun]) -> list[UncertaintyFigures]:
    """One for every level, registration and scene, in their order."""
    groups: dict[tuple[str, str, str], list[UncertainRun]] = {}
    for run in runs:
        groups.setdefault((run.level, run.registration, run.scene), []).append(run)
    return [_figures(*group, of_group) for group, of_group in groups.items()]


def _figures(
    level: str, registration: str, scene: str, runs: Sequence[UncertainRun]
) -> UncertaintyFigures:
    summaries = [run.summary for run in runs]
    errors = np.array([error for run in runs for error in run.pose_errors]).reshape(-1, 3)
    distance, turn = (np.percentile(errors[:, k], [50, 90]).tolist() for k in (0, 1))
    exact = bool(np.isnan(errors[:, 2]).all())
    return UncertaintyFigures(
        level=level,
        registration="-" if exact else registration,
        scene=scene,
        runs=len(runs),
        succeeded=sum(one.succeeded for one in summaries),
        objects=sum(one.objects or 0 for one in summaries),
        placed=sum(one.placed or 0 for one in summaries),
        attempts=sum(one.attempts for one in summaries),
        duration_mean_s=float(np.mean([one.duration_s for one in summaries])),
        contacts=sum(one.contacts for one in summaries),
        position_error_m=(distance[0], distance[1]),
        heading_error_rad=(turn[0], turn[1]),
        nees=None if exact else float(np.nanmean(errors[:, 2])),
    )


def uncertainty_table(figures: Sequence[UncertaintyFigures]) -> Table:
    """Each row beside the time that the same scene takes at `exact`, where that was run."""
    exact = {one.scene: one.duration_mean_s for one in figures if one.level == "exact"}
    return table(
        f"Wrong about where it is, on {machine()['machine']}",
        figures,
        {
            "level": lambda one: Path(one.level).name,
            "registration": lambda one: one.registration,
            "scene": lambda one: Path(one.scene).name,
        },
        {
            "success": lambda one: f"{one.succeeded}/{one.runs}",
            "placed": lambda one: f"{one.placed}/{one.objects}",
            "attempts": lambda one: f"{one.attempts / max(one.placed, 1):.2f}",
            "time (exact)": lambda one: (
                f"{one.duration_mean_s:.0f}"
                + (f" ({exact[one.scene]:.0f})" if one.scene in exact else "")
            ),
            "contacts": lambda one: one.contacts,
            "mm, 90 %": lambda one: ", ".join(f"{1000.0 * m:.1f}" for m in one.position_error_m),
            "deg, 90 %": lambda one: ", ".join(
                f"{np.rad2deg(value):.2f}" for value in one.heading_error_rad
            ),
            "NEES": lambda one: fixed(one.nees, 2),
        },
    )
