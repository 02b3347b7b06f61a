"""Report of `bench obstacles`: counts of every controller, table, JSON."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Any

import numpy as np
from rich.table import Table

from lab.bench.obstacles.obstacle_worlds import FAMILIES
from lab.bench.obstacles.trials import Setup, WorldTrial
from lab.shared import bootstrap, fixed, table

_LISTED = 8  # failed worlds of each controller
_MM = 1e3


@dataclass(frozen=True, kw_only=True)
class Tally:
    """Counts of one controller in some worlds."""

    worlds: int
    failures: int  # not reached, or reached with avoidable contact or over a limit
    failures_by_reason: dict[str, int]
    not_reached: int
    worlds_with_contact: int  # with an avoidable one
    least_clearance_mm: float  # over all samples of all worlds; negative with contact
    time_median_s: float | None  # of the goals that were reached
    time_ratio: float | None  # median over the worlds of the time with obstacles by that without
    time_ratio_interval: tuple[float, float] | None  # 95 %


@dataclass(frozen=True, kw_only=True)
class ObstacleRow:
    """The result of one robot with one controller."""

    robot: str
    controller: str
    base_speed: float  # limit of the base [m/s]
    time_limit_s: float
    seed: int
    all: Tally
    families: dict[str, Tally]
    worlds: list[dict[str, Any]]  # one for every world


def tally(trials: Sequence[WorldTrial]) -> Tally:
    """The counts of some trials."""
    reasons = Counter(trial.reason for trial in trials if trial.reason is not None)
    reached = [trial for trial in trials if trial.trial.failure is None]
    times = [t.trial.time for t in reached]
    ratios = [t.trial.time / t.free_time for t in reached if t.free_time]
    low, high = bootstrap(ratios, np.median, 1000) if ratios else (0.0, 0.0)
    return Tally(
        worlds=len(trials),
        failures=reasons.total(),
        failures_by_reason=dict(sorted(reasons.items())),
        not_reached=len(trials) - len(reached),
        worlds_with_contact=sum(t.verdict.avoidable_samples > 0 for t in trials),
        least_clearance_mm=round(_MM * min(t.verdict.clearance for t in trials), 2),
        time_median_s=round(float(np.median(times)), 3) if times else None,
        time_ratio=round(float(np.median(ratios)), 3) if ratios else None,
        time_ratio_interval=(round(low, 3), round(high, 3)) if ratios else None,
    )


def obstacle_rows(setup: Setup, done: Sequence[Sequence[WorldTrial]]) -> list[ObstacleRow]:
    """A row for every controller, from the trials of every world."""
    rows = []
    for number, controller in enumerate(setup.controllers):
        trials = [world[number] for world in done]
        by_family = {name: [one for one in trials if one.family == name] for name in FAMILIES}
        rows.append(
            ObstacleRow(
                robot=setup.robot,
                controller=controller,
                base_speed=setup.configuration(controller).base_speed or 0.0,
                time_limit_s=setup.limit,
                seed=setup.seed,
                all=tally(trials),
                families={name: tally(own) for name, own in by_family.items() if own},
                worlds=[_as_json(trial) for trial in trials],
            )
        )
    return rows


def _as_json(trial: WorldTrial) -> dict[str, Any]:
    return {
        "world": trial.name,
        "reason": trial.reason,
        "unreachable": trial.unreachable,
        "time_s": round(trial.trial.time, 3),
        "free_time_s": None if trial.free_time is None else round(trial.free_time, 3),
        "clearance_mm": round(_MM * trial.verdict.clearance, 2),
        "nearest": trial.verdict.nearest,
        "touches": [
            {
                "what": f"{touch.part} and {touch.obstacle}",
                "samples": touch.samples,
                "depth_mm": round(_MM * touch.depth, 2),
                "time_s": round(touch.time, 3),
                "avoidable": touch.avoidable,
            }
            for touch in trial.verdict.touches
        ],
    }


def obstacle_table(rows: Sequence[ObstacleRow]) -> Table:
    """All worlds, and each family, of every robot and controller."""
    parts = [
        (f"{row.robot}, {row.controller}" if family == "all" else "", family, counts)
        for row in rows
        for family, counts in (("all", row.all), *row.families.items())
    ]
    return table(
        "Obstacles: reaching goals among furniture",
        parts,
        {"robot, controller": itemgetter(0), "family": itemgetter(1)},
        {
            "worlds": lambda part: part[2].worlds,
            "failed": lambda part: part[2].failures,
            "not reached": lambda part: part[2].not_reached,
            "contact": lambda part: part[2].worlds_with_contact,
            "clear mm": lambda part: fixed(part[2].least_clearance_mm, 1),
            "median s": lambda part: fixed(part[2].time_median_s, 2),
            "times free time": lambda part: _ratio(part[2]),
        },
        title_justify="left",
    )


def _ratio(counts: Tally) -> str:
    if counts.time_ratio is None or counts.time_ratio_interval is None:
        return "-"
    return "{:.2f} ({:.2f}-{:.2f})".format(counts.time_ratio, *counts.time_ratio_interval)


def obstacle_notes(rows: Sequence[ObstacleRow]) -> Iterator[str]:
    """For each robot and controller with failures: in which worlds, and why."""
    for row in rows:
        failed = [one for one in row.worlds if one["reason"] is not None]
        if failed:
            shown = (f"{w['world']} ({w['unreachable'] or w['reason']})" for w in failed[:_LISTED])
            more = ", ..." * (len(failed) > _LISTED)
            yield f"{row.robot}, {row.controller}: failed in {', '.join(shown)}{more}"
