"""Experiment 2 of the paper: reaching many goals from rest."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np
from pinocchio import SE3
from rich.table import Table

from controller import Array, PoseGoal
from lab.bench.configuration import Configuration
from lab.bench.goals import draw_start
from lab.bench.motion_evaluation import Evaluator, Trial
from lab.bench.simulated_motion import run_motion
from lab.shared import fixed, run_in_order, table

PATIENCE = 15.0  # a goal has failed after this time without progress [s]

SWEEPS: dict[str, tuple[tuple[tuple[str, Any], ...], ...]] = {
    "heading": tuple((("heading_gain", gain),) for gain in (0.0, 0.1, 0.5, 1.0)),
    "manipulability": tuple(
        (("manipulability_of", choice),) for choice in ("none", "whole body", "arm")
    ),
}
"""Changes of the settings, each one row of Table II or III of the paper."""


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Conditions of the trials."""

    limit: float = 20.0  # longest time for each goal [s]
    position_tolerance: float = 0.01  # [m]
    orientation_tolerance: float = float(np.deg2rad(1.0))  # [rad]
    starts: str = "ready"  # start postures of the arm, one of `STARTS`
    seed: int = 0  # of starts and jitter, together with the number of the goal
    jitter: tuple[float, float] | None = None
    """Shortest and longest true duration of a control period [s]; None is the nominal one."""


@lru_cache(maxsize=8)
def evaluator_of(configuration: Configuration) -> Evaluator:
    """The evaluator of a configuration, with its model; made once a process."""
    return Evaluator(configuration.model())


def _trial(configuration: Configuration, conditions: Conditions, item: tuple[int, Array]) -> Trial:
    """The motion to the goal of a number, a pose (4, 4)."""
    (number, pose), evaluator = item, evaluator_of(configuration)
    model, jitter = evaluator.model, conditions.jitter
    rng = np.random.default_rng((conditions.seed, number))
    clock = np.random.default_rng((conditions.seed, number, 1))
    goal = PoseGoal(
        target=SE3(pose),
        speed=float(model.limits.base_twist[0]),
        position_tolerance=conditions.position_tolerance,
        orientation_tolerance=conditions.orientation_tolerance,
    )
    motion = run_motion(
        configuration.step(model),
        model,
        lambda time: goal,
        period=configuration.period,
        limit=conditions.limit,
        patience=PATIENCE,
        start=draw_start(model, conditions.starts, rng),
        elapsed=None if jitter is None else partial(clock.uniform, *jitter),
    )
    return evaluator(motion)


def run_trials(
    configuration: Configuration,
    conditions: Conditions,
    goals: Sequence[SE3],
    done: Callable[[Trial], None],
    workers: int | str | None,
) -> list[Trial]:
    """One motion to every goal, in their order; `done` is called with each trial."""
    items = list(enumerate(goal.homogeneous for goal in goals))
    work = partial(_trial, configuration, conditions)
    return run_in_order(work, items, done, workers=workers)


@dataclass(frozen=True, kw_only=True)
class Reach:
    """The result of all trials of one configuration; times are of the goals that were reached."""

    robot: str
    preset: str
    base_speed: float  # limit of the base [m/s]
    reverse_speed: float  # the same backwards [m/s]
    changes: dict[str, Any]  # settings that differ from the preset
    period_s: float
    conditions: dict[str, Any]
    goals: int
    failures: int
    failures_by_reason: dict[str, int]
    failed_goals: list[int]
    limit_violations: int  # samples over any limit
    contact_samples: int  # samples in which the arm is in contact
    time_median_s: float | None
    time_mean_s: float | None
    time_p95_s: float | None
    time_max_s: float | None
    theta_eps_mean_deg: float  # mean |θ_ε| at the end, over all trials
    manipulability_mean: float  # mean of the arm's at the end, over all trials


def aggregate_trials(
    configuration: Configuration, conditions: Conditions, done: Sequence[Trial]
) -> Reach:
    """Count and average the trials of one configuration, in the order of their goals."""
    times = np.array([trial.time for trial in done if trial.failure is None])
    reasons = Counter(str(trial.failure) for trial in done if trial.failure is not None)
    limits = evaluator_of(configuration).model.limits

    def statistic(function: Any, *arguments: float) -> float | None:
        return round(float(function(times, *arguments)), 4) if len(times) else None

    return Reach(
        robot=configuration.robot,
        preset=configuration.preset,
        base_speed=float(limits.base_twist[0]),
        reverse_speed=limits.base_reverse,
        changes=dict(configuration.changes),
        period_s=configuration.period,
        conditions=asdict(conditions),
        goals=len(done),
        failures=reasons.total(),
        failures_by_reason=dict(reasons),
        failed_goals=[i for i, trial in enumerate(done) if trial.failure is not None],
        limit_violations=sum(trial.limit_violations for trial in done),
        contact_samples=sum(trial.contact_samples for trial in done),
        time_median_s=statistic(np.median),
        time_mean_s=statistic(np.mean),
        time_p95_s=statistic(np.percentile, 95.0),
        time_max_s=statistic(np.max),
        theta_eps_mean_deg=float(np.rad2deg(np.mean([abs(t.heading_error) for t in done]))),
        manipulability_mean=float(np.mean([trial.manipulability for trial in done])),
    )


def reach_table(rows: Sequence[Reach]) -> Table:
    """One row for every configuration."""
    return table(
        "Experiment 2: reaching goals",
        rows,
        {
            "robot": lambda row: row.robot,
            "preset": _setting,
            "base m/s": lambda row: fixed(row.base_speed, 1),
            "back": lambda row: fixed(row.reverse_speed, 2),
        },
        {
            "goals": lambda row: row.goals,
            "failed": lambda row: row.failures,
            "over limit": lambda row: row.limit_violations,
            "contact": lambda row: row.contact_samples,
            "median s": lambda row: fixed(row.time_median_s, 2),
            "p95 s": lambda row: fixed(row.time_p95_s, 2),
            "max s": lambda row: fixed(row.time_max_s, 2),
            "θε °": lambda row: fixed(row.theta_eps_mean_deg, 1),
            "m": lambda row: fixed(row.manipulability_mean, 3),
        },
        title_justify="left",
    )


def reach_notes(rows: Sequence[Reach]) -> list[str]:
    """A line for every row with failures: why, and how many."""
    return [
        f"{row.robot} {_setting(row)} {row.base_speed:.1f} m/s: "
        + ", ".join(f"{number} {reason}" for reason, number in row.failures_by_reason.items())
        for row in rows
        if row.failures
    ]


def _setting(row: Reach) -> str:
    return " ".join([row.preset, *(f"{name}={value}" for name, value in row.changes.items())])
