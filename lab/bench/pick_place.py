"""The main task over a range of seeds, as in Experiment 3 of the paper: times, attempts, motion."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from operator import attrgetter

import numpy as np
import numpy.typing as npt
from rich.table import Table

from app.core import Instruments, MotionForm, RunOptions, Summary, Tick, run_task
from app.review import CarriedObject, NodeTime, TimeUse, carried_objects, time_use
from lab.bench.evaluation import cumulative_jerk
from lab.bench.failures import causes
from lab.bench.whole_tasks import run_tasks
from lab.shared import machine

Array = npt.NDArray[np.float64]

_EVERY = 0.1
"""Of the way that is kept for a picture [s]."""


@dataclass(frozen=True, kw_only=True)
class Bar:
    """A leaf while it ran."""

    leaf: str
    begin: float
    end: float


@dataclass(frozen=True, kw_only=True, eq=False)
class PickPlaceRun:
    """One run of the task, and what its recorded motion tells."""

    motion: str
    """How the robot got to its goals."""
    summary: Summary
    base_speed: float
    """Limit of the base [m/s]."""
    reverse_speed: float
    """The same backwards [m/s]."""
    objects: Sequence[CarriedObject]
    reach_times: Sequence[float]
    """From the release of the object before to fingers closed on this one, drive included [s]."""
    pick_place_times: Sequence[float]
    """From the first attempt at an object, or the release of the one before, to its release [s]."""
    causes: dict[str, int]
    """Why leaves that move the robot have failed, and how often."""
    distance: float
    """That the base has driven [m]."""
    stationary: float
    """With neither base nor arm moving [s]."""
    duration: float
    """[s]."""
    jerk: float
    """Cumulative jerk of the tool [m/s^2]."""
    plans: Sequence[float]
    """Real time that each motion plan took [s]."""
    leaves: Sequence[NodeTime]
    """Where the time went, by kind of leaf."""
    bars: Sequence[Bar]
    base_path: Array
    """(N, 2) [m]."""
    tool_path: Array
    """(N, 2) [m]."""


class _PlanTimes(Instruments):
    """How long the ticks take in which a motion is planned.

    What is planned in a tick is known by the robot that stands in the next one.
    """

    def __init__(self) -> None:
        self.seconds: list[float] = []
        self._planned = False

    def after(self, tick: Tick) -> None:
        if tick.report.planning and not self._planned:
            self.seconds.append(tick.seconds)
        self._planned = tick.report.planning


def run_pick_place(
    options: RunOptions,
    seeds: Iterable[int],
    done: Callable[[Summary], None],
    *,
    motions: Sequence[MotionForm] = (MotionForm.HOLISTIC,),
    workers: int = 1,
    cluster: str | None = None,
) -> list[PickPlaceRun]:
    """Run the task once for every seed and kind of motion.

    Args:
        options: of each run, except for seed and motion.
        seeds: of objects and camera noise.
        done: called after each run.
        motions: how the robot gets to its goals.
        workers: number of processes; 1 is this one.
        cluster: address of a dask.distributed scheduler to use instead.

    Returns:
        The runs, kind by kind in the order of the seeds.

    Raises:
        KeyboardInterrupt: a person has ended a run, and with it the others.
    """
    chosen = list(seeds)
    runs = [replace(options, seed=seed, motion=motion) for motion in motions for seed in chosen]
    return run_tasks(_run, runs, attrgetter("summary"), done, workers=workers, cluster=cluster)


def _run(options: RunOptions) -> PickPlaceRun:
    plans = _PlanTimes()
    result = run_task(options, instruments=plans)
    use, objects = time_use(result.folder), carried_objects(result.folder)
    motion = use.motion
    some = slice(None, None, max(1, round(_EVERY / float(np.median(motion.steps)))))
    return PickPlaceRun(
        motion=options.motion.value,
        summary=result.summary,
        base_speed=float(motion.robot.limits.base_twist[0]),
        reverse_speed=float(motion.robot.limits.base_reverse),
        objects=objects,
        reach_times=_reach_times(use, objects),
        pick_place_times=_pick_place_times(objects),
        causes=causes(result.folder),
        distance=motion.distance,
        stationary=float(motion.steps[motion.stationary].sum()),
        duration=float(motion.times[-1] - motion.times[0]),
        jerk=cumulative_jerk(motion.tool, float(np.median(motion.steps))),
        plans=plans.seconds,
        leaves=use.by_kind(),
        bars=[
            Bar(leaf=one.node.kind, begin=one.begin, end=one.end)
            for one in use.stretches
            if one.end > one.begin
        ],
        base_path=motion.base[some, :2],
        tool_path=motion.tool[some, :2],
    )


def _pick_place_times(objects: Sequence[CarriedObject]) -> list[float]:
    done = [one for one in objects if one.placed is not None]
    ends = [one.placed or 0.0 for one in done]
    return [end - begin for begin, end in pairwise([done[0].begun, *ends])] if done else []


def _reach_times(use: TimeUse, objects: Sequence[CarriedObject]) -> list[float]:
    """The last grasp that closed before a release, from the release before or the beginning."""
    closed = sorted(one.end for one in use.stretches if one.node.kind == "grasp")
    ends = [one.placed for one in objects if one.placed is not None]
    times = []
    for begin, end in pairwise([float(use.motion.times[0]), *ends]):
        inside = [time for time in closed if begin < time < end]
        if inside:
            times.append(inside[-1] - begin)
    return times


def pick_place_table(runs: Sequence[PickPlaceRun]) -> Table:
    """One row for every run, as in the README."""
    first = runs[0].summary
    table = Table(title=f"{first.task}, {first.robot}, {first.world}, on {machine()['machine']}")
    columns = ("motion", "seed", "placed", "attempts", "time [s]", "grasp [s]")
    more = ("pick and place [s]", "limit violations", "contacts", "tick median / p99 [ms]")
    for column in (*columns, *more, "times real time"):
        table.add_column(column, justify="right")
    for run in runs:
        s = run.summary
        table.add_row(
            run.motion,
            str(s.seed),
            f"{s.placed} of {s.objects}",
            str(s.attempts),
            f"{s.duration_s:.0f}",
            _seconds(s.grasp_time_mean_s),
            _seconds(s.pick_place_time_mean_s),
            str(s.limit_violations),
            str(s.contacts),
            f"{s.tick_median_ms:.2f} / {s.tick_p99_ms:.2f}",
            f"{s.real_time_factor:.1f}",
        )
    return table


def pick_place_json(runs: Sequence[PickPlaceRun], results: Sequence[object]) -> str:
    """The figures of each kind of motion, every run, and the machine, as one JSON object."""
    summaries = [asdict(run.summary) | {"motion": run.motion} for run in runs]
    return json.dumps({"about": machine(), "results": results, "runs": summaries}, indent=2)


def _seconds(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"
