"""Pictures of worlds from above, and what one motion did from moment to moment."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from controller import Array, StepReport
from lab.bench.motion import Motion
from lab.bench.obstacle_judge import NEAR, Judge
from lab.bench.obstacle_worlds import World
from lab.bench.obstacles import Setup, make_world, run_world
from robots import Box, Cylinder, Geom

_LOW, _HIGH, _WALKER = "#718096", "#cbd5e0", "#b7791f"
_BASE, _TOOL, _STANCE, _CONTACT = "#2d3748", "#2b6cb0", "#2f855a", "#c53030"
_GHOST = 0.5
"""Time between two outlines of the base [s]."""
_ROW = 0.2
"""Time between two lines of a trace [s]."""
_LOW_TOP = 0.5
"""What begins below this is in the way of the base [m]."""


def trace_world(setup: Setup, controller: str, world: World) -> tuple[Motion, list[str]]:
    """One motion, and a line for every 0.2 s of it: where it is, what is near, what is reported."""
    reports: list[StepReport] = []
    motion = run_world(setup, controller, world, lambda time, report: reports.append(report))
    return motion, list(_lines(setup, world, motion, reports))


def _lines(
    setup: Setup, world: World, motion: Motion, reports: Sequence[StepReport]
) -> Iterator[str]:
    nearest = _nearest(setup, world, motion)
    yield "time s |  base x y m, heading ° | error mm, ° | clearance mm | reported mm"
    for sample in range(0, len(motion.base), max(1, round(_ROW / motion.period))):
        report = reports[min(sample, len(reports) - 1)]
        x, y, heading = motion.base[sample]
        clear, what = nearest[sample]
        yield (
            f"{sample * motion.period:6.2f} | {x:6.2f} {y:6.2f} {np.rad2deg(heading):7.1f} |"
            f" {1e3 * motion.position_error[sample]:6.0f}"
            f" {np.rad2deg(motion.orientation_error[sample]):6.1f} |"
            f" {1e3 * clear:6.1f} {what} | {1e3 * report.clearance:6.1f} {report.nearest}"
            f" {report.unreachable}".rstrip()
        )


def _nearest(setup: Setup, world: World, motion: Motion) -> list[tuple[float, str]]:
    judge = Judge(setup.configuration(setup.controllers[0]).model().description)
    return judge.nearest(motion.base, motion.q, motion.period, world.fixtures, world.walkers)


def plot_worlds(setup: Setup, names: Sequence[tuple[str, int]], folder: Path) -> Iterator[Path]:
    """Run some worlds again and draw each, a panel for every controller.

    Args:
        setup: who is drawn.
        names: families and numbers of the worlds.
        folder: where the pictures are written; it exists.

    Yields:
        The files.
    """
    for family, number in names:
        world = make_world(setup, family, number)
        motions = [run_world(setup, controller, world) for controller in setup.controllers]
        yield draw_world(setup, world, motions, folder)


def draw_world(setup: Setup, world: World, motions: Sequence[Motion], folder: Path) -> Path:
    """One picture with a panel for every motion, which are those of the setup's controllers."""
    size = (5.0 * len(motions), 5.4)
    figure = import_module("matplotlib.figure").Figure(figsize=size, layout="constrained")
    figure.suptitle(f"{setup.robot}, seed {setup.seed}, {world.name}")
    panels = figure.subplots(1, len(motions), squeeze=False)[0]
    for controller, motion, panel in zip(setup.controllers, motions, panels, strict=True):
        _draw(panel, setup, world, motion)
        end = "arrived" if motion.arrived else motion.unreachable or "not reached"
        panel.set_title(f"{controller}: {end}, {motion.duration:.2f} s")
    file = folder / f"{setup.robot}-{setup.seed}-{world.family}-{world.number}.png"
    figure.savefig(file, dpi=110)
    return file


def _draw(panel: Any, setup: Setup, world: World, motion: Motion) -> None:
    for fixture in sorted(world.fixtures, key=_bottom):
        x, y = _outline(fixture)
        in_the_way = _bottom(fixture) < _LOW_TOP
        panel.fill(x, y, color=_LOW if in_the_way else _HIGH, alpha=0.6 if in_the_way else 0.4)
    times = motion.times()
    for walker in world.walkers:
        path = walker.positions(times)
        panel.plot(*path[:, :2].T, color=_WALKER, linewidth=1.0)
        for sample in _ghosts(motion):
            panel.fill(*_circle(path[sample, :2], walker.shape.radius), color=_WALKER, alpha=0.12)
    length, width = setup.configuration(setup.controllers[0]).model().description.base.size[:2]
    for sample in _ghosts(motion):
        panel.plot(*_footprint(motion.base[sample], length, width), color=_BASE, linewidth=0.6)
    panel.plot(*_footprint(world.stance.base, length, width), color=_STANCE, linestyle="--")
    panel.plot(*motion.base[:, :2].T, color=_BASE, linewidth=0.8, linestyle=":")
    panel.plot(*motion.tool[:, :2].T, color=_TOOL, linewidth=1.2)
    nearest = _nearest(setup, world, motion)
    touching = np.array([clear < 0.0 for clear, _ in nearest])
    panel.plot(*motion.base[touching, :2].T, ".", color=_CONTACT, markersize=3)
    panel.plot(*motion.tool[touching, :2].T, ".", color=_CONTACT, markersize=3)
    panel.plot(*world.goal.translation[:2], "x", color=_STANCE, markersize=9, markeredgewidth=2)
    least, what = min(nearest, key=lambda pair: pair[0])
    if least < NEAR:
        panel.set_xlabel(f"{1e3 * least:.0f} mm, {what}")
    panel.set_aspect("equal")
    panel.grid(alpha=0.2)


def _ghosts(motion: Motion) -> range:
    return range(0, len(motion.base), max(1, round(_GHOST / motion.period)))


def _bottom(fixture: Geom) -> float:
    match fixture.shape:
        case Box((_, _, half)) | Cylinder(_, half):
            return float(fixture.pose.translation[2]) - half
        case _:
            return 0.0


def _outline(fixture: Geom) -> Array:
    place = fixture.pose.translation[:2]
    match fixture.shape:
        case Box((x, y, _)):
            corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * [x, y]
            return np.asarray((corners @ fixture.pose.rotation[:2, :2].T + place).T)
        case Cylinder(radius, _):
            return _circle(place, radius)
        case _:
            return np.zeros((2, 0))


def _circle(centre: Array, radius: float) -> Array:
    angles = np.linspace(0.0, 2.0 * np.pi, 40)
    return np.array([centre[0] + radius * np.cos(angles), centre[1] + radius * np.sin(angles)])


def _footprint(base: Array, length: float, width: float) -> Array:
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]]) * [length / 2, width / 2]
    c, s = np.cos(base[2]), np.sin(base[2])
    return np.asarray((corners @ np.array([[c, s], [-s, c]]) + base[:2]).T)
