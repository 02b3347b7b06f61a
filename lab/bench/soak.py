"""Soak test: hours of one task, with a random fault every minute.

Objects are carried to and fro between a container and a table. A run that ends, by a fault that a
program may not clear, is counted and started again, until the hours are over. A simulated person
acknowledges emergency stops and puts back objects that fell out of reach.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from traceback import format_exc

import numpy as np
from rich.table import Table

from app.core import End, Footprint, Instruments, RunOptions, Setup, Tick, footprint, run_task
from app.live import ControlOptions, View, ViewOptions
from hw import DisturbableWorld, Robot, stopwatch
from lab.bench.faults import hushed
from lab.bench.witness import Violations, Witness
from lab.shared import machine
from trees.language import TreeNode

_TASKS = Path(__file__).parent / "tasks"

LONGEST_S = {
    "reflex": 5.0,
    "emergency stop": 2.0,
    "gripper dead": 10.0,
    "gripper halfway": 10.0,
    "object moved": 1.0,
    "object taken": 30.0,
    "frames lost": 5.0,
    "frames late": 10.0,
    "frames frozen": 5.0,
    "picture frozen": 5.0,
    "frames black": 5.0,
    "frames empty": 5.0,
    "frames sparse": 10.0,
    "localisation jump": 10.0,
    "localisation drift": 30.0,
    "readings late": 5.0,
    "state nan": 0.1,
}
"""The faults of the soak, all of which a task can survive, and the longest duration of each [s]."""

_FAULT_EVERY = 60.0
"""One fault in each such interval, at a random time [s]."""
_LOOK_EVERY = 10.0
"""Interval at which the simulated person looks for fallen objects [s]."""
_ACKNOWLEDGED_AFTER = 0.5
"""Delay after which it acknowledges a released emergency stop [s]."""
_MOST_RUNS_AN_HOUR = 60
"""With more runs than this in an hour the soak has failed."""


@dataclass(kw_only=True)
class Soak:
    """The result of a soak."""

    hours: float = 0.0
    """Simulated."""
    real_s: float = 0.0
    runs: int = 0
    endings: dict[str, int] = field(default_factory=dict)
    """Outcome and reason of the runs that ended before the hours were over."""
    faults: dict[str, int] = field(default_factory=dict)
    """How often each was injected."""
    carried: int = 0
    """Objects that the task placed."""
    put_back: int = 0
    """How often a fallen object was put back."""
    unaccounted: int = 0
    """Objects at the end of a run neither on furniture, nor in the hand, nor taken away by a fault
    of that moment, nor on the floor for less than the interval between two looks."""
    violations: Violations = field(default_factory=Violations)
    samples: list[Footprint] = field(default_factory=list)
    """Resources of the process, once a simulated minute."""

    @property
    def settled(self) -> Footprint:
        """The resources after the first tenth of the soak."""
        return self.samples[len(self.samples) // 10]

    @property
    def memory_growth(self) -> float:
        """Of the memory after the first tenth of the soak, as a share of it."""
        return self.samples[-1].rss / self.settled.rss - 1.0


class _SoakRun(Instruments):
    """One run of the soak.

    Args:
        soak: where everything is counted.
        hours: when the soak is over.
        rng: of the faults.
        progress: called once a simulated minute.
    """

    def __init__(
        self, soak: Soak, hours: float, rng: np.random.Generator, progress: Callable[[], None]
    ) -> None:
        self._soak, self._hours, self._rng, self._progress = soak, hours, rng, progress
        self._before = soak.hours
        self._fault: tuple[str, float, float] | None = None
        self._injected = False
        self._minute = self._look = -1
        self._fallen: set[str] = set()

    def beneath(self, robot: Robot) -> Robot:
        """The robot with its judge."""
        self._witness = Witness(robot, self._soak.violations)
        return self._witness

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        """Note the initial poses of the objects."""
        assert isinstance(setup.truth, DisturbableWorld)
        self._setup, self._world = setup, setup.truth
        self._homes = {one.name: one.pose for one in setup.truth.objects}

    def after(self, tick: Tick) -> None:
        """Inject faults, and put fallen objects back."""
        now = self._setup.clock.session.now()
        self._soak.hours = self._before + now / 3600.0
        self._disturb(now)
        if now // _LOOK_EVERY > self._look:
            self._look = int(now // _LOOK_EVERY)
            self._tidy()

    def is_over(self) -> bool:
        """Whether the hours are over."""
        return self._soak.hours >= self._hours

    def end(self) -> None:
        """Count the objects."""
        self._soak.carried += self._setup.context.log.placed
        self._soak.unaccounted += len(self._astray() - self._fallen)

    def _disturb(self, now: float) -> None:
        if now // _FAULT_EVERY > self._minute:
            self._minute = int(now // _FAULT_EVERY)
            name = str(self._rng.choice(list(LONGEST_S)))
            duration = LONGEST_S[name] * self._rng.uniform(0.2, 1.0)
            start = now + self._rng.uniform(0.0, _FAULT_EVERY - duration)
            self._fault, self._injected = (name, start, start + duration), False
            self._soak.samples.append(footprint())
            self._progress()
        if self._fault is None:
            return
        name, start, stop = self._fault
        if now >= stop:
            self._fault = None
        elif now >= start and not self._injected:
            self._setup.robot.inject(name, stop - start)
            self._injected = True
            self._soak.faults[name] = self._soak.faults.get(name, 0) + 1

    def _tidy(self) -> None:
        """Put back objects that were astray at the last look, too; forget full places."""
        astray = self._astray()
        for name in astray & self._fallen:
            self._world.put(name, self._homes[name])
            self._soak.put_back += 1
        self._fallen = astray
        carriers = set(self._world.supports().values())
        log = self._setup.context.log
        for places in (log.places_used, log.places_blocked):
            for region in [one for one in places if one not in carriers]:
                del places[region]

    def _astray(self) -> set[str]:
        """Objects out of the task's reach, unless a fault takes one away at this moment."""
        if self._fault is not None and self._fault[0] == "object taken" and self._injected:
            return set()
        supports = self._world.supports()
        return {name for name, on in supports.items() if on not in ("container", "table", "hand")}


def run_soak(hours: float, seed: int, progress: Callable[[], None]) -> Soak:
    """Run the task for hours of simulated time.

    Args:
        hours: simulated.
        seed: of objects, camera noise and faults.
        progress: called once a simulated minute.

    Raises:
        KeyboardInterrupt: a signal ended a run.
    """
    soak, rng, begun, terminal = Soak(), np.random.default_rng((seed, 1)), stopwatch(), sys.stderr

    def report() -> None:
        with redirect_stderr(terminal):
            progress()

    while soak.hours < hours and soak.runs < max(10.0, _MOST_RUNS_AN_HOUR * hours):
        run = _SoakRun(soak, hours, rng, report)
        with TemporaryDirectory() as folder, hushed():
            options = RunOptions(
                tree=_TASKS / "back_and_forth.yaml",
                scene=str(_TASKS / "back_and_forth_scene.yaml"),
                seed=seed + soak.runs,
                record=Path(folder),
                recording=False,
                view=ViewOptions(view=View.NONE),
                control=ControlOptions(acknowledge_after=_ACKNOWLEDGED_AFTER),
            )
            try:
                outcome = run_task(options, interrupted=run.is_over, instruments=run).outcome
                ending = f"{outcome.end.value}: {outcome.reason}"
            except Exception:
                ending = f"exception: {format_exc().strip().splitlines()[-1]}"
        soak.runs += 1
        run.end()
        if not run.is_over():
            if ending.startswith(End.INTERRUPTED.value):
                raise KeyboardInterrupt
            soak.endings[ending] = soak.endings.get(ending, 0) + 1
        soak.real_s = stopwatch() - begun
    return soak


def soak_table(soak: Soak) -> Table:
    """The result as a table."""
    title = f"{soak.hours:.2f} simulated hours, on {machine()['machine']}"
    table = Table(title=title, title_justify="left", show_header=False)
    first, last, found = soak.settled, soak.samples[-1], soak.violations
    faults = ", ".join(f"{n} {name}" for name, n in Counter(soak.faults).most_common())
    endings = "\n".join(f"{n} {why}" for why, n in Counter(soak.endings).most_common())
    rows = {
        "time": f"{soak.real_s / 60.0:.1f} min, {3600.0 * soak.hours / soak.real_s:.1f} times real",
        "runs": f"{soak.runs}",
        "ended early": endings or "none",
        "faults": f"{sum(soak.faults.values())}: {faults}",
        "objects carried": f"{soak.carried}",
        "fell, put back": f"{soak.put_back}",
        "not accounted for": f"{soak.unaccounted}",
        "limit violations": f"{found.position} position, {found.velocity} velocity, "
        f"{found.acceleration} acceleration",
        "memory": f"{first.rss / 1e6:.0f} MB after a tenth, {last.rss / 1e6:.0f} MB in the end, "
        f"{100.0 * soak.memory_growth:+.1f} %",
        "threads": f"{first.threads} and {last.threads}",
        "open files": f"{first.handles} and {last.handles}",
    }
    for name, value in rows.items():
        table.add_row(name, value)
    return table
