"""Pictures of Experiment 3: time by behaviour, behaviours over time, and the ways from above."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from lab.bench.pick_place import PickPlaceRun
from lab.bench.pick_place_figures import pick_place_figures

_MOVES, _STILL = "#2b6cb0", "#c05621"
_BASE, _TOOL = "#4a5568", "#2b6cb0"
_SHORT = 0.05
"""Behaviours that take less for each object are left out [s]."""
_SHOWN = 60.0
"""Of a run whose behaviours are drawn over time [s]."""


def plot_pick_place(runs: Sequence[PickPlaceRun], folder: Path) -> list[Path]:
    """Three pictures, the kinds of motion beside each other.

    Args:
        runs: of any kinds of motion and seeds; behaviours over time and the ways from above are
            those of the first of each kind.
        folder: where they are written; it exists.

    Returns:
        The files.
    """
    kinds = list(dict.fromkeys(run.motion for run in runs))
    firsts = [next(run for run in runs if run.motion == kind) for kind in kinds]
    return [
        _time_by_leaf(runs, folder / "pick-place-time.png"),
        _gantt(firsts, folder / "pick-place-gantt.png"),
        _from_above(firsts, folder / "pick-place-above.png"),
    ]


def _figure(rows: int, columns: int, size: tuple[float, float], title: str) -> tuple[Any, Any]:
    figure = import_module("matplotlib.figure").Figure(figsize=size, layout="constrained")
    figure.suptitle(title)
    return figure, figure.subplots(rows, columns, squeeze=False)


def _time_by_leaf(runs: Sequence[PickPlaceRun], file: Path) -> Path:
    found = pick_place_figures(runs)
    leaves = list(
        dict.fromkeys(
            leaf
            for one in found
            for leaf, row in one.seconds_by_leaf.items()
            if row["seconds"] > _SHORT
        )
    )
    figure, axes = _figure(1, 1, (8.0, 0.5 * len(leaves) * len(found) + 1.5), "time per object")
    panel, height = axes[0, 0], 0.8 / len(found)
    for number, one in enumerate(found):
        nothing = {"seconds": 0.0, "still": 0.0}
        rows = [one.seconds_by_leaf.get(leaf, nothing) for leaf in leaves]
        places = np.arange(len(leaves)) + number * height
        moving = np.array([row["seconds"] - row["still"] for row in rows])
        still = [row["still"] for row in rows]
        strength = 1.0 - 0.5 * number
        panel.barh(places, moving, height, color=_MOVES, alpha=strength, label=one.motion)
        label = f"{one.motion}, robot still"
        panel.barh(places, still, height, left=moving, color=_STILL, alpha=strength, label=label)
    panel.set_yticks(np.arange(len(leaves)) + 0.4 - height / 2.0, leaves)
    panel.invert_yaxis()
    panel.set_xlabel("time per object [s]")
    panel.legend(fontsize="small", loc="lower right")
    panel.grid(axis="x", alpha=0.2)
    figure.savefig(file, dpi=120)
    return file


def _gantt(runs: Sequence[PickPlaceRun], file: Path) -> Path:
    shown = min(_SHOWN, max(run.duration for run in runs))
    title = f"behaviours in the first {shown:.0f} s, seed {runs[0].summary.seed}"
    figure, axes = _figure(len(runs), 1, (11.0, 2.6 * len(runs)), title)
    for run, panel in zip(runs, axes[:, 0], strict=True):
        leaves = list(dict.fromkeys(bar.leaf for bar in run.bars if bar.begin < shown))
        for bar in run.bars:
            if bar.begin < shown:
                row = leaves.index(bar.leaf)
                panel.barh(row, bar.end - bar.begin, 0.7, left=bar.begin, color=f"C{row}")
        for one in run.objects:
            if one.placed is not None and one.placed < shown:
                panel.axvline(one.placed, color=_BASE, linewidth=0.8, linestyle=":")
        panel.set_yticks(range(len(leaves)), leaves)
        panel.invert_yaxis()
        panel.set_xlim(0.0, shown)
        panel.set_title(f"{run.motion}; dotted: an object is released", fontsize="medium")
        panel.grid(axis="x", alpha=0.2)
    axes[-1, 0].set_xlabel("time [s]")
    figure.savefig(file, dpi=120)
    return file


def _from_above(runs: Sequence[PickPlaceRun], file: Path) -> Path:
    title = f"from above, seed {runs[0].summary.seed}"
    figure, axes = _figure(1, len(runs), (5.5 * len(runs), 5.2), title)
    for run, panel in zip(runs, axes[0], strict=True):
        panel.plot(*run.base_path.T, color=_BASE, linewidth=0.8, label="base")
        panel.plot(*run.tool_path.T, color=_TOOL, linewidth=0.8, alpha=0.7, label="hand")
        panel.set_aspect("equal", adjustable="datalim")
        panel.set_title(run.motion)
        panel.set_xlabel("x [m]")
        panel.set_ylabel("y [m]")
        panel.legend(fontsize="small")
        panel.grid(alpha=0.2)
    figure.savefig(file, dpi=120)
    return file
