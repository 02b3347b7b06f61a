"""What watching costs the control loop: the main task in real time, without and with a viewer.

The cost is that of making a snapshot and handing it to the recorder and the terminal, on the thread
of the loop, with everything recorded. The viewer is the real one without a window. It uses the
processor like any other program, and is suspended for half of the last run.
"""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from enum import Enum
from math import inf
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table

from app.core import (
    RECORDING,
    Measurements,
    Session,
    Setup,
    Snapshots,
    Tick,
    VisionForm,
    open_setup,
    scene_view,
)
from app.live import (
    About,
    Address,
    Control,
    Moment,
    Recorder,
    RunDisplay,
    headless_viewer,
    tree_view,
)
from app.terminal import Terminal
from controller import robot_model
from hw import WorldOptions, stopwatch
from lab.shared import machine
from perception import GraspDetector
from robots import load_robot
from trees.language import TreeNode, build, load, nodes_in_order

if TYPE_CHECKING:
    import subprocess

_ROBOT = "frankie"
_SUSPENDED_FROM, _SUSPENDED_TO = 0.25, 0.75
"""When the viewer is suspended, as shares of the run."""


class Watcher(Enum):
    """What watches a measured run."""

    NOBODY = "nobody"
    VIEWER = "viewer"
    HUNG = "viewer that hangs half of the time"


@dataclass(frozen=True, kw_only=True)
class WatchCost:
    """The cost of watching in one run."""

    watcher: str
    ticks: int
    median_us: float
    p99_us: float
    worst_us: float
    """Of one tick [µs]; a tick has a period of 10 000."""
    late_ticks: int
    """Ticks that came more than a period later than the tick before asks for, for any reason."""
    dropped: int
    memory_mb: float
    """Largest growth of the process during the run [MB]."""
    recording_mb: float


@dataclass(kw_only=True, eq=False)
class _Meter:
    """Measures from inside the loop."""

    period: float
    costs: list[float] = field(default_factory=list)
    late: int = 0
    before: float = inf
    """When the tick before was over [s]."""
    memory: float = 0.0

    def tick(self, number: int, begun: float) -> None:
        """Add a tick whose watching began at `begun` [s]."""
        now = stopwatch()
        self.costs.append(now - begun)
        self.late += now - self.before > 2.0 * self.period
        self.before = now
        if number % 100 == 0:
            self.memory = max(self.memory, _resident_mb())


def measure_watching(tree: Path, seconds: float, done: Callable[[], None]) -> list[WatchCost]:
    """Run a task once for every watcher.

    Args:
        tree: the task.
        seconds: how long each run is watched at most.
        done: called after each run.

    Raises:
        ViewError: the viewer does not start.
    """
    detector = GraspDetector(gripper=load_robot(_ROBOT).gripper)
    results = []
    for watcher in Watcher:
        results.append(_run(tree, seconds, watcher, detector))
        done()
    return results


def _run(tree: Path, seconds: float, watcher: Watcher, detector: GraspDetector) -> WatchCost:
    world = WorldOptions(scene="household", paced=True)
    with open_setup(_ROBOT, "kinematic", world, detector, VisionForm.BESIDE) as setup:
        return _watch(setup, tree, seconds, watcher)


def _watch(setup: Setup, tree: Path, seconds: float, watcher: Watcher) -> WatchCost:
    root = build(load(tree), setup.context)
    nodes = nodes_in_order(root)
    period = setup.controller.settings.period
    snapshots = Snapshots(nodes, setup.truth)
    control, meter = Control(), _Meter(period=period)
    server = None
    if watcher is not Watcher.NOBODY:
        server = Address()
    with TemporaryDirectory() as folder:
        recording = Path(folder) / RECORDING
        recorder = Recorder(
            recording,
            tree=tree_view(nodes),
            model=robot_model(_ROBOT),
            scene=scene_view(setup.truth),
            lossless=False,
            server=server,
        )
        before, began = _resident_mb(), setup.clock.session.now()
        with _watched(server) as process, _display(nodes) as display:

            def watch(tick: Tick) -> None:
                begun = stopwatch()
                seen = snapshots.of(tick)
                recorder.record(seen)
                display.update(Moment(seen=seen, placed=0, attempts=0), changed=True)
                meter.tick(tick.number, begun)
                share = (tick.state.stamp - began) / seconds
                if process is not None and watcher is Watcher.HUNG:
                    hangs = _SUSPENDED_FROM <= share < _SUSPENDED_TO
                    process.send_signal(signal.SIGSTOP if hangs else signal.SIGCONT)
                if share >= 1.0:
                    control.stop()

            Session(
                root=root,
                context=setup.context,
                controller=setup.controller,
                gate=setup.gate,
                measurements=Measurements(limits=setup.model.limits),
                clock=setup.clock,
                control=control,
                watch=watch,
            ).run()
        recorder.close()
        costs = 1e6 * np.array(meter.costs)
        return WatchCost(
            watcher=watcher.value,
            ticks=len(costs),
            median_us=float(np.median(costs)),
            p99_us=float(np.percentile(costs, 99)),
            worst_us=float(costs.max()),
            late_ticks=meter.late,
            dropped=recorder.dropped,
            memory_mb=meter.memory - before,
            recording_mb=recording.stat().st_size / 1e6,
        )


@contextmanager
def _watched(server: Address | None) -> Iterator[subprocess.Popen[bytes] | None]:
    """The process of a viewer of this server; None without one."""
    if server is None:
        yield None
        return
    with headless_viewer(watch=server.url) as viewer:
        try:
            yield viewer.process
        finally:
            viewer.process.send_signal(signal.SIGCONT)


@contextmanager
def _display(nodes: Sequence[TreeNode]) -> Iterator[RunDisplay]:
    """The tree in a terminal that nobody sees."""
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        terminal = Terminal(file=nowhere, force_terminal=True, width=120, height=40)
        about = About(task="watch", where="", objects=10)
        with RunDisplay(about, tree_view(nodes), console=terminal) as display:
            yield display


def _resident_mb() -> float:
    """Memory of this process [MB]."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def watch_table(results: list[WatchCost]) -> Table:
    """One row for every watcher."""
    table = Table(title=f"what watching costs a tick, on {machine()['machine']}")
    for column in (
        "watched by",
        "ticks",
        "median / p99 / worst [µs]",
        "late ticks",
        "dropped",
        "memory [MB]",
        "recording [MB]",
    ):
        table.add_column(column, justify="right")
    for r in results:
        table.add_row(
            r.watcher,
            str(r.ticks),
            f"{r.median_us:.0f} / {r.p99_us:.0f} / {r.worst_us:.0f}",
            str(r.late_ticks),
            str(r.dropped),
            f"{r.memory_mb:.0f}",
            f"{r.recording_mb:.1f}",
        )
    return table


def watch_json(results: list[WatchCost]) -> str:
    """The figures and the machine they were measured on, as one JSON object."""
    return json.dumps({"about": machine(), "runs": [asdict(r) for r in results]}, indent=2)
