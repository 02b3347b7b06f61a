"""The bench of faults: everything that can go wrong, in every phase of bringing an object.

Each cell of the matrix is a run of its own in which one thing goes wrong once, in one phase. What
became of it is judged on the truth: on the simulated world, and on the robot beneath the injected
faults.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr
from dataclasses import asdict, dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from traceback import format_exc

from app.core import (
    PHASES,
    End,
    Instruments,
    RunOptions,
    Setup,
    Tick,
    current_phases,
    run_task,
)
from app.live import ControlOptions, View, ViewOptions
from config import UserError, suggest
from hw import Robot, Truth, stopwatch
from lab.bench.fault_matrix import INTO, TROUBLES, USUALLY_INTO, Trouble
from lab.bench.witness import AT_REST, Violations, Witness
from lab.shared import run_all
from trees.language import TreeNode

TREE = Path(__file__).parent / "one_object.yaml"
GOAL = "table"
"""What the object has to rest on in the end."""

LONGEST = 240.0
"""A run that takes longer hangs [s of simulated time]."""
LONGEST_REAL = 600.0
"""The same [s of real time]."""

_MOVES = 0.02
"""Faster than this the robot goes on [m/s or rad/s]."""
_ACKNOWLEDGED_AFTER = 0.5
"""When the stand-in for a person acknowledges a released emergency stop [s]."""
_AFTERMATH = 0.05
"""What an injected fault itself does to objects is over after this [s]."""


@dataclass(frozen=True, kw_only=True)
class Cell:
    """What is to go wrong, and when."""

    trouble: str
    phase: str
    seed: int


@dataclass(frozen=True, kw_only=True)
class CellResult:
    """What became of it."""

    trouble: str
    phase: str
    seed: int
    injected_s: float | None
    """When it went wrong [s]; None if the run never came to that phase."""
    outcome: str
    """One of the values of `End`, or `exception` if `run_task` raised."""
    reason: str
    exit_code: int | None
    duration_s: float
    rest_s: float | None
    """From then until the robot stood still, where it has to [s]."""
    resume_s: float | None
    """From the end of the trouble until the robot went on, where it had to rest [s]."""
    violations: Violations
    lost: int
    """Objects on the floor or nowhere, without those that the fault itself took away."""
    moving: bool
    """Whether the robot still moved when the run was over."""
    stopped: bool
    """Whether it had been told to stop by itself then, which takes time that is not simulated."""
    wrong_success: bool
    """Whether the tree says success and the object is not where it was to be placed."""
    hang: bool
    crash: bool
    """Whether the run ended with an exception instead of an outcome."""


@dataclass(eq=False)
class _CellRun(Instruments):
    """Lets one thing go wrong and watches."""

    trouble: Trouble
    phase: str
    entered: float | None = None
    injected: float | None = None
    cleared: float | None = None
    rest: float | None = None
    resumed: float | None = None
    now: float = 0.0
    hang: bool = False
    witness: Witness | None = None
    truth: Truth | None = None
    excused: set[str] = field(default_factory=set)
    """Objects that the fault itself took away."""

    def beneath(self, robot: Robot) -> Robot:
        """The robot, watched."""
        witness = self.witness = Witness(robot, seen=self._see)
        return witness

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        """Note where the objects are."""
        self._begun = stopwatch()
        self._setup, self.truth = setup, setup.truth
        self._nodes = [place.node for place in nodes]

    def after(self, tick: Tick) -> None:
        """Begin the trouble in its phase."""
        if self.injected is not None:
            return
        now = self._setup.clock.session.now()
        if self.phase not in current_phases(self._nodes):
            self.entered = None
        elif self.entered is None:
            self.entered = now
        elif now - self.entered >= INTO.get(self.phase, USUALLY_INTO):
            self._undo = self.trouble.begin(self._setup, self._nodes)
            self.injected = now

    def _see(self) -> None:
        """Watch it, and end what does not end by itself."""
        if self.witness is not None and self.witness.state is not None:
            self.now = self.witness.state.stamp
        if self.injected is None:
            return
        now = self.now
        since = now - self.injected
        if since <= _AFTERMATH:
            self.excused = set(self.lost())
        if self.cleared is None and self.trouble.lasts is not None and since >= self.trouble.lasts:
            self._undo()
            self.cleared = now
        if self.rest is None and self.speed < AT_REST:
            self.rest = now
        elif self.resumed is None and self.rest is not None and self.speed > _MOVES:
            self.resumed = now

    @property
    def speed(self) -> float:
        """The true one [m/s or rad/s]."""
        return self.witness.speed if self.witness else 0.0

    def is_over(self) -> bool:
        """Whether the run takes too long."""
        took = stopwatch() - self._begun
        self.hang |= self.now > LONGEST or took > LONGEST_REAL
        return self.hang

    def lost(self) -> list[str]:
        """Names of the objects that nothing but the floor carries."""
        supports = self.truth.supports() if self.truth else {}
        return [name for name, support in supports.items() if support in ("", "floor")]

    def is_placed(self) -> bool:
        """Whether every object rests where it was to be placed."""
        supports = self.truth.supports() if self.truth else {}
        return set(supports.values()) == {GOAL}


def cells(faults: Sequence[str], phases: Sequence[str], seeds: Sequence[int]) -> list[Cell]:
    """The cells of a matrix.

    Args:
        faults: names of its rows; none takes all.
        phases: names of its columns; none takes all.
        seeds: of objects, camera noise and faults.

    Raises:
        UserError: no row or column has such a name.
    """
    known = [trouble.name for trouble in TROUBLES]
    _check("--faults", faults, known)
    _check("--phases", phases, PHASES)
    return [
        Cell(trouble=name, phase=phase, seed=seed)
        for name in faults or known
        for phase in phases or PHASES
        for seed in seeds
    ]


def run_cells(wanted: Sequence[Cell], workers: int, done: Callable[[CellResult], None]) -> None:
    """Run the cells.

    Args:
        wanted: the cells.
        workers: number of processes.
        done: called after each cell.
    """
    for _, result in run_all(run_cell, wanted, workers=workers):
        done(result)


def run_cell(cell: Cell) -> CellResult:
    """Run one cell."""
    trouble = next(one for one in TROUBLES if one.name == cell.trouble)
    run = _CellRun(trouble, cell.phase)
    with TemporaryDirectory() as folder, hushed():
        options = RunOptions(
            tree=TREE,
            seed=cell.seed,
            paced=trouble.paced,
            record=Path(folder),
            recording=False,
            view=ViewOptions(view=View.NONE),
            control=_control(trouble),
        )
        try:
            outcome = run_task(options, interrupted=run.is_over, instruments=run).outcome
            end, reason, code = outcome.end.value, outcome.reason, outcome.end.exit_code
        except Exception:
            end, reason, code = "exception", format_exc().strip().splitlines()[-1], None
    succeeded = end == End.SUCCESS.value
    return CellResult(
        **asdict(cell),
        injected_s=_rounded(run.injected),
        outcome="hang" if run.hang else end,
        reason=reason,
        exit_code=code,
        duration_s=round(run.now, 2),
        rest_s=_difference(run.rest, run.injected) if trouble.stops else None,
        resume_s=_difference(run.resumed, run.cleared) if trouble.stops else None,
        violations=run.witness.violations if run.witness else Violations(),
        lost=len(set(run.lost()) - run.excused),
        moving=run.speed > _MOVES,
        stopped=run.witness is not None and run.witness.stopped,
        wrong_success=succeeded and not run.is_placed(),
        hang=run.hang,
        crash=code is None,
    )


@contextmanager
def hushed() -> Iterator[None]:
    """Runs have nothing to say to the person at the terminal."""
    with open(os.devnull, "w", encoding="utf-8") as nothing, redirect_stderr(nothing):
        yield


def _difference(later: float | None, earlier: float | None) -> float | None:
    if later is None or earlier is None:
        return None
    return round(max(0.0, later - earlier), 2)


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 2)


def _control(trouble: Trouble) -> ControlOptions:
    after = _ACKNOWLEDGED_AFTER if trouble.acknowledged else None
    return ControlOptions(acknowledge_after=after)


def _check(option: str, names: Sequence[str], known: Sequence[str]) -> None:
    for name in names:
        if name not in known:
            raise UserError(f"{option} {name}: there is none of this name; {suggest(name, known)}")
