"""The bench of signals: processes that run a task get one at a random moment.

Each run is a process of its own. What it left is judged by its files alone.
"""

from __future__ import annotations

import json
import os
import signal
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

import numpy as np
from rich.table import Table

from app.core import COMMANDS, EVENTS, STATES, SUMMARY, read_events
from controller import HolisticController, robot_model
from lab.bench.forked import ForkServer
from lab.shared import machine, run_all

KINDS = ("INT", "TERM", "HUP", "KILL", "STOP/CONT")
SPEEDS = ("real", "max")

_TASK = "pick_place"
_BEGUN_ROWS = 30
"""The robot moves when this many commands have been sent."""
_LATEST = 3.0
"""Moment of the signal after that, at most [s of real time]."""
_LONGEST_SUSPENSION = 2.0
_GOES_ON = 1.0
"""After a suspension the process goes on for this long before it is interrupted [s]."""
_PATIENCE = 60.0
"""A process that does not end within this hangs [s]."""
_STANDSTILL = 0.01
"""Slower than this the robot stands still [m/s or rad/s]."""


@dataclass(frozen=True, kw_only=True)
class SignalCase:
    """One process to be."""

    kind: str
    speed: str
    seed: int


@dataclass(frozen=True, kw_only=True)
class SignalResult:
    """What became of it."""

    kind: str
    speed: str
    seed: int
    moving: float
    """Fastest speed of the base just before the signal [m/s]."""
    exit_code: int
    exit_s: float
    """From the last signal to the end of the process [s]."""
    is_expected: bool
    """Whether the exit code is the documented one, and a summary says so where there can be one."""
    is_readable: bool
    """Whether commands, states and events can be read."""
    lost_s: float
    """Between the last row of the commands and the signal [s of real time]."""
    at_rest: bool
    """Whether the robot stood still at the end; a killed process cannot see to that."""
    violations: int
    """Commands that changed by more than the limits allow in the time since the one before."""
    has_traceback: bool


def signal_cases(kinds: Sequence[str], speeds: Sequence[str], count: int) -> list[SignalCase]:
    """`count` cases of each kind and speed."""
    return [
        SignalCase(kind=kind, speed=speed, seed=seed)
        for seed in range(count)
        for kind in kinds
        for speed in speeds
    ]


def run_signals(
    cases: Sequence[SignalCase], done: Callable[[SignalResult], None], workers: int = 1
) -> list[SignalResult]:
    """Run the cases.

    Args:
        cases: what to do.
        done: called after each.
        workers: how many at a time.
    """
    results: dict[int, SignalResult] = {}
    for number, result in run_all(run_signal, cases, workers=workers):
        results[number] = result
        done(result)
    return [results[number] for number in range(len(cases))]


def run_signal(case: SignalCase) -> SignalResult:
    """Start a task, send the signal at a random moment, and judge what is left."""
    random = Random(f"{case.kind} {case.speed} {case.seed}")
    with TemporaryDirectory() as runs:
        errors = Path(runs) / "stderr"
        arguments = ["run", _TASK, "--view", "none", "--speed", case.speed]
        arguments += ["--seed", str(case.seed), "--record", runs]
        server = _server()
        pid = server.start(arguments, errors)
        folder = _begun(Path(runs))
        time.sleep(random.uniform(0.0, _LATEST))
        sent = _signal(pid, case.kind, random)
        exit_code = server.wait(_PATIENCE)
        ended = time.time()
        if exit_code is None:  # it hangs: not as documented, whatever it leaves
            os.kill(pid, signal.SIGKILL)
            exit_code = server.wait(_PATIENCE) or 0
        return _judge(case, folder, exit_code, sent, ended - sent, errors.read_text())


@cache
def _server() -> ForkServer:
    """One for each worker."""
    return ForkServer()


def _begun(runs: Path) -> Path:
    """The folder of a run whose robot moves."""
    deadline = time.monotonic() + _PATIENCE
    while time.monotonic() < deadline:
        for path in runs.glob(f"*/{COMMANDS}"):
            if path.stat().st_size and len(np.load(path)) >= _BEGUN_ROWS:
                return path.parent
        time.sleep(0.05)
    raise TimeoutError("the run does not begin")


def _signal(pid: int, kind: str, random: Random) -> float:
    """Send it; returns when the (last) one was sent, by the clock of the file system [s]."""
    if kind == "STOP/CONT":
        os.kill(pid, signal.SIGSTOP)
        time.sleep(random.uniform(0.05, _LONGEST_SUSPENSION))
        os.kill(pid, signal.SIGCONT)
        time.sleep(_GOES_ON)
        kind = "INT"
    sent = time.time()
    os.kill(pid, getattr(signal, f"SIG{kind}"))
    return sent


def _judge(
    case: SignalCase, folder: Path, exit_code: int, sent: float, exit_s: float, err: str
) -> SignalResult:
    killed = case.kind == "KILL"
    commands, states = _rows(folder / COMMANDS), _rows(folder / STATES)
    readable = commands is not None and states is not None and bool(read_events(folder / EVENTS))
    if commands is None or states is None:
        commands, states = np.zeros((1, 11)), np.zeros((1, 22))
    speeds = np.abs(np.hstack([states[-1, 4:7], states[-1, 14:21]]))
    written = (folder / COMMANDS).stat().st_mtime
    return SignalResult(
        **asdict(case),
        moving=round(float(np.abs(commands[-200:, 1]).max()), 3),
        exit_code=exit_code,
        exit_s=round(exit_s, 3),
        is_expected=exit_code == -signal.SIGKILL if killed else _is_interrupted(folder, exit_code),
        is_readable=readable,
        lost_s=round(max(0.0, sent - written), 3) if killed else 0.0,
        at_rest=bool(speeds.max() < _STANDSTILL),
        violations=_violations(commands),
        has_traceback="Traceback" in err,
    )


def _rows(path: Path) -> np.ndarray | None:
    try:
        rows: np.ndarray = np.load(path)
    except (OSError, ValueError, EOFError):
        return None
    return rows


def _is_interrupted(folder: Path, exit_code: int) -> bool:
    try:
        summary = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return exit_code == 130 and summary["outcome"] == "interrupted"


def _violations(commands: np.ndarray) -> int:
    """Commands that changed faster than braking may, in the time since the one before.

    Two periods of grace, as the gate gives them; after a gap the robot has braked by itself.
    """
    model = robot_model("frankie")
    limits, period = model.limits, HolisticController(model).settings.period
    allowed = np.concatenate([limits.base_emergency, limits.qdd])
    elapsed = np.diff(commands[:, 0])
    change = np.diff(np.abs(commands[:, 1:]), axis=0)
    grows = change > allowed * (elapsed[:, None] + 2.0 * period) + 1e-9
    brakes = -change > allowed * (elapsed[:, None] + 2.0 * period) + 1e-9
    at_once = elapsed[:, None] <= 3.0 * period
    return int((grows | (brakes & at_once)).any(axis=1).sum())


def signals_table(results: Sequence[SignalResult]) -> Table:
    """A row for every kind and speed."""
    table = Table(title=f"signals at random moments, `{_TASK}`, on {machine()['machine']}")
    for column in (
        "signal",
        "speed",
        "runs",
        "as documented",
        "readable",
        "at rest",
        "violations",
        "tracebacks",
        "exit median / worst [s]",
        "lost worst [s]",
    ):
        table.add_column(column, justify="right")
    for kind in KINDS:
        for speed in SPEEDS:
            rows = [r for r in results if (r.kind, r.speed) == (kind, speed)]
            if not rows:
                continue
            exits = [r.exit_s for r in rows]
            at_rest = "-" if kind == "KILL" else str(sum(r.at_rest for r in rows))
            table.add_row(
                kind,
                speed,
                str(len(rows)),
                str(sum(r.is_expected for r in rows)),
                str(sum(r.is_readable for r in rows)),
                at_rest,
                str(sum(r.violations for r in rows)),
                str(sum(r.has_traceback for r in rows)),
                f"{np.median(exits):.2f} / {max(exits):.2f}",
                f"{max(r.lost_s for r in rows):.2f}" if kind == "KILL" else "-",
            )
    return table


def signals_json(results: Sequence[SignalResult]) -> str:
    """The results and the machine they were measured on, as one JSON object."""
    return json.dumps({"about": machine(), "runs": [asdict(r) for r in results]}, indent=2)
