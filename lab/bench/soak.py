"""The soak: hours of one task, with a random fault every minute, judged on the truth.

Objects are carried to and fro between a container and a table. A run that ends, by a fault that a
program may not clear, is counted and begun anew, until the hours are over. A stand-in for a person
acknowledges emergency stops and puts back what fell where the robot cannot get it.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stderr
from dataclasses import asdict, dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from traceback import format_exc
from types import MappingProxyType

import numpy as np
from rich.table import Table

from app.core import Footprint, Instruments, RunOptions, Setup, Tick, footprint, run_task
from app.live import ControlOptions, View, ViewOptions
from hw import DisturbableWorld, Robot, stopwatch
from lab.bench.faults import hushed
from lab.bench.witness import Violations, Witness
from lab.shared import machine
from trees.language import TreeNode

_HERE = Path(__file__).parent
TREE = _HERE / "back_and_forth.yaml"
SCENE = _HERE / "back_and_forth_scene.yaml"

LONGEST_S: Mapping[str, float] = MappingProxyType(
    {
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
)
"""The faults of the soak, all of which a task can outlive, and how long each lasts at most [s]."""

FAULT_EVERY = 60.0
"""One fault in each such time, at a random moment [s]."""
_LOOK_EVERY = 10.0
"""How often the stand-in for a person looks for objects that fell [s]."""
_ACKNOWLEDGED_AFTER = 0.5
"""When it acknowledges a released emergency stop [s]."""
_MOST_RUNS_AN_HOUR = 60
"""More runs than this in an hour are no soak but a failure."""


@dataclass(frozen=True, kw_only=True)
class Sample:
    """What the process held at one moment."""

    hours: float
    """Simulated time since the soak began."""
    footprint: Footprint


@dataclass(kw_only=True)
class Soak:
    """What came of it."""

    hours: float = 0.0
    """Simulated."""
    real_s: float = 0.0
    runs: int = 0
    endings: dict[str, int] = field(default_factory=dict)
    """How the runs ended before the hours were over: outcome and reason."""
    faults: dict[str, int] = field(default_factory=dict)
    """How often each was injected."""
    carried: int = 0
    """Objects that the task placed."""
    put_back: int = 0
    """How often an object fell, and was put back by the stand-in for a person."""
    unaccounted: int = 0
    """Objects that were at the end of a run neither on furniture, nor in the hand, nor taken away
    by a fault of that moment, nor on the floor for less than the time between two looks."""
    violations: Violations = field(default_factory=Violations)
    samples: list[Sample] = field(default_factory=list)

    @property
    def memory_growth(self) -> float:
        """Of the memory after the first tenth of the soak, as a share of it."""
        first = self.samples[len(self.samples) // 10].footprint.rss
        return self.samples[-1].footprint.rss / first - 1.0


class _SoakRun(Instruments):
    """One run of the soak.

    Args:
        soak: where everything is counted.
        hours: when the soak is over.
        rng: of the faults.
        progress: told the hours so far, now and then.
    """

    def __init__(
        self,
        soak: Soak,
        hours: float,
        rng: np.random.Generator,
        progress: Callable[[Soak], None],
    ) -> None:
        self._soak, self._hours, self._rng, self._progress = soak, hours, rng, progress
        self._before = soak.hours
        self._fault: tuple[str, float, float] | None = None
        self._injected = False
        self._minute = self._look = -1
        self._fallen: set[str] = set()

    def beneath(self, robot: Robot) -> Robot:
        """The robot, watched."""
        self._witness = Witness(robot, self._soak.violations)
        return self._witness

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        """Note where the objects are."""
        assert isinstance(setup.truth, DisturbableWorld)
        self._setup, self._world = setup, setup.truth
        self._homes = {one.name: one.pose for one in setup.truth.objects}

    def after(self, tick: Tick) -> None:
        """Faults, the look for what fell, and the counts."""
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
        """Count what is left."""
        self._soak.carried += self._setup.context.log.placed
        self._soak.unaccounted += len(self._astray() - self._fallen)

    def _disturb(self, now: float) -> None:
        """One fault a minute."""
        if now // FAULT_EVERY > self._minute:
            self._minute = int(now // FAULT_EVERY)
            name = str(self._rng.choice(list(LONGEST_S)))
            lasts = LONGEST_S[name] * self._rng.uniform(0.2, 1.0)
            start = now + self._rng.uniform(0.0, FAULT_EVERY - lasts)
            self._fault, self._injected = (name, start, start + lasts), False
            self._soak.samples.append(Sample(hours=self._soak.hours, footprint=footprint()))
            self._progress(self._soak)
        if self._fault is None:
            return
        name, start, stop = self._fault
        if now >= stop:
            self._fault = None
        elif now >= start and not self._injected:
            self._setup.robot.inject(name, stop - start)
            self._injected = True
            _count(self._soak.faults, name)

    def _tidy(self) -> None:
        """Put back what has lain out of reach since the last look, and forget full places."""
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
        """Objects that are not where the task can find them, but for one that is taken away."""
        if self._fault is not None and self._fault[0] == "object taken" and self._injected:
            return set()
        supports = self._world.supports()
        return {name for name, on in supports.items() if on not in ("container", "table", "hand")}


def run_soak(hours: float, seed: int, progress: Callable[[Soak], None]) -> Soak:
    """Run the task for hours of simulated time.

    Args:
        hours: how many.
        seed: of objects, camera noise and faults.
        progress: called once a simulated minute.
    """
    soak, rng, begun, terminal = Soak(), np.random.default_rng((seed, 1)), stopwatch(), sys.stderr

    def tell(soak: Soak) -> None:
        with redirect_stderr(terminal):
            progress(soak)

    while soak.hours < hours and soak.runs < max(10.0, _MOST_RUNS_AN_HOUR * hours):
        run = _SoakRun(soak, hours, rng, tell)
        with TemporaryDirectory() as folder, hushed():
            options = RunOptions(
                tree=TREE,
                scene=str(SCENE),
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
            _count(soak.endings, ending)
        soak.real_s = stopwatch() - begun
    return soak


def soak_table(soak: Soak) -> Table:
    """What came of it, for people."""
    title = f"{soak.hours:.2f} simulated hours, on {machine()['machine']}"
    table = Table(title=title, title_justify="left", show_header=False)
    last = soak.samples[-1].footprint
    first = soak.samples[len(soak.samples) // 10].footprint
    rows = {
        "time": f"{soak.real_s / 60.0:.1f} min, {3600.0 * soak.hours / soak.real_s:.1f} times real",
        "runs": f"{soak.runs}",
        "ended early": "\n".join(f"{n} {why}" for why, n in Counter(soak.endings).most_common())
        or "none",
        "faults": f"{sum(soak.faults.values())}: "
        + ", ".join(f"{n} {name}" for name, n in Counter(soak.faults).most_common()),
        "objects carried": f"{soak.carried}",
        "fell, put back": f"{soak.put_back}",
        "not accounted for": f"{soak.unaccounted}",
        "limit violations": f"{soak.violations.position} position, {soak.violations.velocity} "
        f"velocity, {soak.violations.acceleration} acceleration",
        "memory": f"{first.rss / 1e6:.0f} MB after a tenth, {last.rss / 1e6:.0f} MB in the end, "
        f"{100.0 * soak.memory_growth:+.1f} %",
        "threads": f"{first.threads} and {last.threads}",
        "open files": f"{first.handles} and {last.handles}",
    }
    for name, value in rows.items():
        table.add_row(name, value)
    return table


def soak_json(soak: Soak) -> str:
    """What came of it, and the machine."""
    about = machine() | {"memory_growth": round(soak.memory_growth, 4)}
    return json.dumps({"about": about, "soak": asdict(soak)}, indent=1)


def _count(counts: dict[str, int], name: str) -> None:
    counts[name] = counts.get(name, 0) + 1
