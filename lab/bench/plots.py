"""Plots of Experiment 1: the robot from above, fading in from start to goal, and curves."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config import UserError
from controller import Array
from lab.bench.evaluation import limit_usage
from lab.bench.poses import PoseRun

_GHOSTS = 9
_FAINTEST = 0.12
_BASE, _ARM, _PATH, _GOAL = "#4a5568", "#c05621", "#2b6cb0", "#2f855a"
_MEASURED, _LIMIT = "#2b6cb0", "#c53030"


class PlotError(UserError):
    """Plots cannot be drawn or written."""


def prepare_plots(folder: Path) -> None:
    """Create the folder, and check that plots can be drawn.

    Raises:
        PlotError: matplotlib is not installed, or the folder cannot be created.
    """
    try:
        import_module("matplotlib")
    except ImportError:
        raise PlotError('--plot needs an extra: pip install "frankie-task[plots]"') from None
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PlotError(
            f"--plot {folder}: the folder cannot be created ({error.strerror})"
        ) from None


def make_plots(runs: Sequence[PoseRun], folder: Path) -> list[Path]:
    """Two plots for every configuration.

    Args:
        runs: of any configurations and poses.
        folder: where they are written; it exists.

    Returns:
        The files.
    """
    configurations = list(dict.fromkeys(run.configuration for run in runs))
    files = []
    for configuration in configurations:
        own = [run for run in runs if run.configuration == configuration]
        robot, preset, speed = configuration.robot, configuration.preset, configuration.speed_text
        name = f"{robot}-{preset}-{speed}"
        title = f"{robot}, {preset}, base up to {speed} m/s"
        files.append(_from_above(own, title, folder / f"{name}-above.png"))
        files.append(_curves(own, title, folder / f"{name}-curves.png"))
    return files


def _figure(rows: int, columns: int, size: tuple[float, float], title: str) -> tuple[Any, Any]:
    figure = import_module("matplotlib.figure").Figure(figsize=size, layout="constrained")
    figure.suptitle(title)
    return figure, figure.subplots(rows, columns, squeeze=False)


def _from_above(runs: Sequence[PoseRun], title: str, file: Path) -> Path:
    figure, axes = _figure(1, len(runs), (4.2 * len(runs), 4.6), title)
    for run, panel in zip(runs, axes[0], strict=True):
        motion = run.motion
        chosen = np.unique(np.linspace(0, len(motion.base) - 1, _GHOSTS).round().astype(int))
        for order, sample in enumerate(chosen):
            strength = _FAINTEST + (1.0 - _FAINTEST) * order / max(len(chosen) - 1, 1)
            _robot(panel, run, int(sample), strength)
        panel.plot(*motion.base[:, :2].T, color=_BASE, linewidth=0.8, linestyle=":")
        panel.plot(*motion.tool[:, :2].T, color=_PATH, linewidth=1.5)
        goals = np.array([run.goal_at(t).wTe.translation for t in motion.times()])
        panel.plot(*goals[:, :2].T, color=_GOAL, linewidth=1.0)
        panel.plot(*goals[-1, :2], color=_GOAL, marker="x", markersize=10, markeredgewidth=2)
        panel.set_title(f"{run.pose}: {motion.duration:.2f} s")
        _square(panel)
        panel.set_xlabel("x [m]")
        panel.set_ylabel("y [m]")
        panel.grid(alpha=0.2)
    figure.savefig(file, dpi=120)
    return file


def _square(panel: Any) -> None:
    """Equal axes, as wide as high, around everything that was drawn."""
    panel.set_aspect("equal")
    corners = np.array([panel.get_xlim(), panel.get_ylim()])
    middle, half = corners.mean(axis=1), np.ptp(corners, axis=1).max() / 2.0
    panel.set_xlim(middle[0] - half, middle[0] + half)
    panel.set_ylim(middle[1] - half, middle[1] + half)


def _robot(panel: Any, run: PoseRun, sample: int, strength: float) -> None:
    model = run.configuration.model()
    x, y, heading = run.motion.base[sample]
    wTb = SE3(pin.utils.rotate("z", heading), np.array([x, y, 0.0]))
    length, width = model.description.base.size[:2]
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]]) * [length / 2, width / 2]
    outline = corners @ wTb.rotation[:2, :2].T + wTb.translation[:2]
    panel.plot(*outline.T, color=_BASE, alpha=strength, linewidth=1.2)
    q = run.motion.q[sample]
    arm = [pose.translation for pose in model.link_poses(wTb, q)]
    points: Array = np.array([*arm, model.wTe(wTb, q).translation])
    panel.plot(*points[:, :2].T, color=_ARM, alpha=strength, linewidth=1.8)


def _curves(runs: Sequence[PoseRun], title: str, file: Path) -> Path:
    figure, axes = _figure(4, len(runs), (4.2 * len(runs), 9.6), title)
    for column, run in enumerate(runs):
        motion, times = run.motion, run.motion.times()
        velocity, acceleration = limit_usage(run.configuration.model(), motion)
        error, angle, manipulability, usage = axes[:, column]
        error.semilogy(times, 1e3 * motion.position_error, color=_MEASURED)
        error.axhline(1e3 * run.goal_at(0.0).position_tolerance, color=_LIMIT, linewidth=0.8)
        angle.semilogy(times, np.rad2deg(motion.orientation_error), color=_MEASURED)
        angle.axhline(
            np.rad2deg(run.goal_at(0.0).orientation_tolerance), color=_LIMIT, linewidth=0.8
        )
        manipulability.plot(times, run.manipulability, color=_MEASURED)
        manipulability.set_ylim(0.0, None)
        usage.plot(times[1:], velocity.max(axis=1), color=_MEASURED, label="speed")
        usage.plot(
            times[1:], acceleration.max(axis=1), color=_ARM, linewidth=0.6, label="acceleration"
        )
        usage.axhline(1.0, color=_LIMIT, linewidth=0.8)
        usage.set_ylim(0.0, None)
        usage.legend(loc="upper right", fontsize="small")
        error.set_title(run.pose)
        usage.set_xlabel("time [s]")
    labels = ("position error [mm]", "orientation error [°]", "manipulability", "share of limits")
    for row, label in enumerate(labels):
        axes[row, 0].set_ylabel(label)
        for panel in axes[row]:
            panel.grid(alpha=0.2)
    figure.savefig(file, dpi=120)
    return file
