"""The cost of the tree language: reading a large task file, and one tick of a tree."""

from __future__ import annotations

import gc
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter_ns, thread_time_ns
from typing import cast

import numpy as np
from py_trees.common import Status
from rich.table import Table

from behaviours import Condition, Context, Leaf
from hw import SimClock
from lab.bench.step import Timing
from trees.language import build, load, nodes_in_order

NODES_READ = 200
NODES_TICKED = 31


class Holds(Condition):
    """A condition that holds."""

    key = "holds"

    def update(self) -> Status:
        """One tick."""
        return self.success("yes")


class Works(Leaf):
    """An action that keeps running.

    Args:
        effort: not used.
        patience_s: not used.
    """

    key = "works"
    moves = False

    def __init__(
        self, name: str, context: Context, *, effort: float = 1.0, patience_s: float = 2.0
    ) -> None:
        super().__init__(name, context)

    def update(self) -> Status:
        """One tick."""
        return self.running("working")


LEAVES: dict[str, type[Leaf]] = {leaf.key: leaf for leaf in (Holds, Works)}


class _ContextPart:
    """The part of a context that these leaves use."""

    clock = SimClock()


def large_task() -> str:
    """A file of `NODES_READ` nodes, one composite for every four leaves."""
    part = (
        "    - name: part {}\n      retry: 3\n      timeout_s: 10\n      sequence:\n"
        "        - works: {{effort: 0.5, patience_s: 1.5}}\n        - holds\n"
        "        - works: {{effort: $effort}}\n        - {{invert: true, holds: }}\n"
    )
    parts = "".join(part.format(number) for number in range(NODES_READ // 5))
    return f"task: large\nparams: {{effort: {{default: 2.0}}}}\ntree:\n  sequence:\n{parts}"


def busy_task() -> str:
    """A file whose tree has `NODES_TICKED` nodes, all of which are ticked in every tick."""
    guarded = "    - reactive_sequence: [holds, holds, holds, holds, works]\n"
    return f"task: busy\ntree:\n  parallel:\n{guarded * (NODES_TICKED // 6)}"


def time_tree(rounds: int) -> list[Timing]:
    """Time both.

    Args:
        rounds: how often the file is read; the tree is ticked a hundred times as often.
    """
    with TemporaryDirectory() as folder:
        large, busy = Path(folder) / "large.yaml", Path(folder) / "busy.yaml"
        large.write_text(large_task(), encoding="utf-8")
        busy.write_text(busy_task(), encoding="utf-8")
        root = build(load(busy, leaves=LEAVES), cast(Context, _ContextPart()))
        assert len(nodes_in_order(root)) == NODES_TICKED
        return [
            _timed(
                f"read a file of {NODES_READ} nodes", lambda: load(large, leaves=LEAVES), rounds
            ),
            _timed(f"tick a tree of {NODES_TICKED} nodes", root.tick_once, 100 * rounds),
        ]


def _timed(name: str, work: Callable[[], object], rounds: int) -> Timing:
    work()
    wall, cpu = np.empty(rounds), np.empty(rounds)
    gc.collect()
    for number in range(rounds):
        begun, begun_cpu = perf_counter_ns(), thread_time_ns()
        work()
        cpu[number] = thread_time_ns() - begun_cpu
        wall[number] = perf_counter_ns() - begun
    return Timing.of(name, wall, cpu)


def tree_table(timings: list[Timing]) -> Table:
    """As a table."""
    table = Table(title="The tree language, in ms", title_justify="left")
    table.add_column("what")
    for name in ("median", "p95", "p99", "CPU median", "CPU p95", "CPU p99"):
        table.add_column(name, justify="right")
    for one in timings:
        numbers = (one.median, one.p95, one.p99, one.cpu_median, one.cpu_p95, one.cpu_p99)
        table.add_row(one.name, *(f"{number / 1e3:.3f}" for number in numbers))
    return table
