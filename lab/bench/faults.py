"""Fault matrix: every fault in every phase of delivering an object.

Each cell is a run of its own in which one fault occurs once, in one phase. The judge is the
simulated world, and the robot beneath the injected faults.
"""

import os
from collections import Counter
from collections.abc import Sequence
from contextlib import redirect_stderr
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from traceback import format_exc

from rich.table import Table

from app.core import End, Instruments, RunOptions, Setup, Tick, current_phases, run_task
from extensions.faults import with_faults
from hw import Backend, Truth, stopwatch
from lab.bench.fault_matrix import FAULTS, INTO, TREE, USUALLY_INTO, Fault
from lab.bench.witness import AT_REST, Witness
from lab.shared import machine
from trees.language import TreeNode

LONGEST = 240.0  # a run that takes longer hangs [s of simulated time]
LONGEST_REAL = 600.0  # the same [s of real time]

_GOAL = "table"  # where the object rests after a success
_MOVES = 0.02  # a faster robot moves [m/s or rad/s]
_ACKNOWLEDGED_AFTER = 0.5
"""Delay after which the simulated person acknowledges a released emergency stop [s]."""
_AFTERMATH = 0.05  # time within which an injected fault itself affects objects [s]


@dataclass(frozen=True, kw_only=True)
class Cell:
    """A fault in a phase."""

    fault: str
    phase: str
    seed: int
    world: str = "kinematic"


@dataclass(frozen=True, kw_only=True)
class CellResult(Cell):
    """The result of one cell."""

    injected_s: float | None  # time of the fault [s]; None if the run never entered the phase
    outcome: str  # one of the values of `End`, `hang`, or `exception` if `run_task` raised
    reason: str
    exit_code: int | None
    duration_s: float
    rest_s: float | None  # from the fault to standstill, where the robot must stop [s]
    resume_s: float | None  # from the end of the fault to motion, where the robot must stop [s]
    violations: int  # of limits
    lost: int  # objects on the floor or unsupported, without those that the fault itself took away
    moving: bool  # whether the robot still moved when the run was over
    stopped: bool  # whether its last command was to stop, which takes time that is not simulated
    wrong_success: bool  # whether the tree reports success and the object is not at its target
    hang: bool
    crash: bool  # whether the run ended with an exception instead of an outcome


@dataclass(eq=False)
class _CellRun(Instruments):
    """Injects one fault and observes the true robot."""

    fault: Fault
    phase: str
    seed: int
    entered: float | None = None
    injected: float | None = None
    cleared: float | None = None
    rest: float | None = None
    resumed: float | None = None
    now: float = 0.0
    hang: bool = False
    witness: Witness | None = None
    truth: Truth | None = None
    excused: set[str] = field(default_factory=set)  # objects that the fault itself took away

    def opened(self, backend: Backend) -> Backend:
        """The robot with its judge, beneath the faults."""
        self.witness = Witness(backend.robot, seen=self._see)
        return with_faults(replace(backend, robot=self.witness), self.seed)

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        """Keep the setup and the nodes."""
        self._begun = stopwatch()
        self._setup, self.truth = setup, setup.truth
        self._nodes = [place.node for place in nodes]

    def after(self, tick: Tick) -> None:
        """Begin the fault in its phase."""
        if self.injected is not None:
            return
        now = self._setup.clock.session.now()
        if self.phase not in current_phases(self._nodes):
            self.entered = None
        elif self.entered is None:
            self.entered = now
        elif now - self.entered >= INTO.get(self.phase, USUALLY_INTO):
            self._undo = self.fault.begin(self._setup, self._nodes)
            self.injected = now

    def _see(self) -> None:
        """After each reading: note rest and motion, and end the fault when it is due."""
        if self.witness is not None and self.witness.state is not None:
            self.now = self.witness.state.stamp
        if self.injected is None:
            return
        now, duration = self.now, self.fault.duration
        since = now - self.injected
        if since <= _AFTERMATH:
            self.excused = set(self.lost())
        if self.cleared is None and duration is not None and since >= duration:
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
        self.hang |= self.now > LONGEST or stopwatch() - self._begun > LONGEST_REAL
        return self.hang

    def supports(self) -> dict[str, str]:
        """The true support of every object."""
        return dict(self.truth.supports()) if self.truth else {}

    def lost(self) -> list[str]:
        """Names of the objects on the floor or unsupported."""
        return [name for name, support in self.supports().items() if support in ("", "floor")]


def cells(
    faults: Sequence[str], phases: Sequence[str], seeds: Sequence[int], world: str = "kinematic"
) -> list[Cell]:
    """The cells of these rows and columns."""
    return [
        Cell(fault=fault.name, phase=phase, seed=seed, world=world)
        for fault in FAULTS
        if fault.name in faults
        for phase in phases
        for seed in seeds
    ]


def run_cell(cell: Cell) -> CellResult:
    """Run one cell."""
    fault = next(one for one in FAULTS if one.name == cell.fault)
    run = _CellRun(fault, cell.phase, cell.seed)
    after = _ACKNOWLEDGED_AFTER if fault.acknowledged else None
    with (
        TemporaryDirectory() as folder,
        open(os.devnull, "w", encoding="utf-8") as nothing,
        redirect_stderr(nothing),
    ):
        options = RunOptions(
            tree=TREE,
            world=cell.world,
            seed=cell.seed,
            real_clock=fault.real_clock,
            record=Path(folder),
            recording=False,
            acknowledge_after=after,
        )
        try:
            outcome = run_task(options, interrupted=run.is_over, instruments=run).outcome
            end, reason, code = outcome.end.value, outcome.reason, outcome.end.exit_code
        except Exception:
            end, reason, code = "exception", format_exc().strip().splitlines()[-1], None
    is_placed = set(run.supports().values()) == {_GOAL}
    return CellResult(
        **asdict(cell),
        injected_s=None if run.injected is None else round(run.injected, 2),
        outcome="hang" if run.hang else end,
        reason=reason,
        exit_code=code,
        duration_s=round(run.now, 2),
        rest_s=_difference(run.rest, run.injected) if fault.stops else None,
        resume_s=_difference(run.resumed, run.cleared) if fault.stops else None,
        violations=run.witness.violations if run.witness else 0,
        lost=len(set(run.lost()) - run.excused),
        moving=run.speed > _MOVES,
        stopped=run.witness is not None and run.witness.stopped,
        wrong_success=end == End.SUCCESS.value and not is_placed,
        hang=run.hang,
        crash=code is None,
    )


def _difference(later: float | None, earlier: float | None) -> float | None:
    if later is None or earlier is None:
        return None
    return round(max(0.0, later - earlier), 2)


def faults_table(results: Sequence[CellResult]) -> Table:
    """One row for each fault, summed over phases and seeds, and their sum."""
    table = Table(title=f"faults x phases, on {machine()['machine']}")
    columns = ("fault", "runs", "outcomes", "rest [s]", "resume [s]", "limits", "lost")
    for name in (*columns, "moving", "wrong success", "hang", "crash"):
        table.add_column(name, justify="left" if name in ("fault", "outcomes") else "right")
    for name in dict.fromkeys(one.fault for one in results):
        table.add_row(name, *_sums([one for one in results if one.fault == name]))
    table.add_section()
    table.add_row("sum", *_sums(results))
    return table


def faults_notes(results: Sequence[CellResult]) -> list[str]:
    """A line for each cell with a wrong result."""
    stopping = {fault.name for fault in FAULTS if fault.stops}
    lines = []
    for one in results:
        no_rest = one.fault in stopping and one.rest_s is None and not one.stopped
        wrong = {
            "wrong success": one.wrong_success,
            "hang": one.hang,
            "crash": one.crash,
            "limits": one.violations > 0,
            "still moving": one.moving and not one.stopped,
            "never entered": one.injected_s is None,
            "never at rest": one.injected_s is not None and no_rest,
        }
        if names := ", ".join(name for name, is_so in wrong.items() if is_so):
            lines.append(f"{one.fault} in {one.phase}, seed {one.seed}: {names} ({one.reason})")
    return lines


def _sums(results: Sequence[CellResult]) -> list[str]:
    hit = [one for one in results if one.injected_s is not None]
    outcomes = Counter(one.outcome for one in hit)
    times = ([one.rest_s for one in hit], [one.resume_s for one in hit])
    longest = [max((time for time in some if time is not None), default=None) for some in times]
    counts = (
        [one.violations for one in hit],
        [one.lost for one in hit],
        [one.moving and not one.stopped for one in hit],
        [one.wrong_success for one in hit],
        [one.hang for one in hit],
        [one.crash for one in hit],
    )
    return [
        str(len(hit)) if len(hit) == len(results) else f"{len(hit)} of {len(results)}",
        ", ".join(f"{count} {name}" for name, count in outcomes.most_common()),
        *("-" if time is None else f"{time:.2f}" for time in longest),
        *(str(sum(values)) for values in counts),
    ]
