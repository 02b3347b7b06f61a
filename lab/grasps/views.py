"""`frankie-task grasp views`: does the detector see as well from the side and from afar?

The same objects, at rest, are seen from every tilt and every distance. Importing this does not
import MuJoCo.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np
from pinocchio import SE3, exp3
from rich.table import Table

from config import ConfigError
from lab.grasps.choice import NetworkChoice, all_results
from lab.grasps.chosen import chosen_grasp
from lab.grasps.scenes import EVALUATION_SEED, Array, camera_noise
from lab.shared import percent, share

TILTS_DEG = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0)
"""Of the optical axis from straight down."""
DISTANCES = (0.2, 0.3, 0.45, 0.7, 1.0, 1.5)
"""From the camera to the top of the object, along the optical axis [m]."""
ENDS = ("no grasp", "not held", "held")

_DRAWS_OF_VIEWS = 5  # the stream of random numbers that views are drawn from


class Seen(NamedTuple):
    """What became of the best grasp in one frame."""

    tilt_deg: float
    distance: float
    end: str
    """One of `ENDS`."""


def measure_views(
    choice: NetworkChoice, *, scenes: int, looks: int = 0, workers: int
) -> list[Seen]:
    """Every scene of one object from every view, the best grasp of each executed in physics.

    Args:
        choice: the network.
        scenes: their number.
        looks: how often the camera looks again from above where it sees no grasp.
        workers: number of processes.

    Raises:
        ConfigError: MuJoCo is missing.
    """
    if find_spec("mujoco") is None:
        raise ConfigError('grasp views needs an extra: pip install "frankie-task[physics]"')
    found = all_results(
        "scenes",
        partial(_scene, choice, looks),
        range(scenes),
        workers,
        lambda seen: all(one.end != ENDS[0] for one in seen),
    )
    return [one for seen in found for one in seen]


def _scene(choice: NetworkChoice, looks: int, seed: int) -> list[Seen]:
    from lab.grasps.physical_judge import execute
    from lab.grasps.physical_scenes import dropped

    scene = dropped(seed, 1)
    rng = np.random.default_rng((EVALUATION_SEED, _DRAWS_OF_VIEWS, seed))
    (obj,) = scene.world.objects
    top = obj.reach(np.array([0.0, 0.0, 1.0]))
    target = np.array([*obj.pose.translation[:2], top])
    seen = []
    for tilt_deg in TILTS_DEG:
        for distance in DISTANCES:
            wTc = looking_at(target, np.radians(tilt_deg), distance, rng)
            noise = camera_noise(rng.random())
            grasp = chosen_grasp(
                choice.detector(), scene.world, scene.region, wTc, noise, rng, looks=looks
            )
            held = grasp is not None and execute(*scene.hand(), grasp).held
            seen.append(Seen(tilt_deg, distance, ENDS[(grasp is not None) + held]))
    return seen


def looking_at(target: Array, tilt: float, distance: float, rng: np.random.Generator) -> SE3:
    """A camera that looks at a (3,) point, from any side and turned anyhow."""
    about, yaw = rng.uniform(-np.pi, np.pi, 2)
    lean = exp3(tilt * np.array([np.cos(about), np.sin(about), 0.0]))
    axis = lean @ np.array([0.0, 0.0, -1.0])
    down = exp3(np.array([0.0, 0.0, yaw])) @ exp3(np.array([np.pi, 0.0, 0.0]))
    return SE3(lean @ down, target - distance * axis)


def views_table(seen: Sequence[Seen]) -> Table:
    """The share of scenes with a grasp, and of those in which it held, by tilt and distance."""
    table = Table("tilt", *(f"{distance:g} m" for distance in DISTANCES), "all")
    for tilt_deg in (*TILTS_DEG, None):
        row = [one for one in seen if tilt_deg in (None, one.tilt_deg)]
        columns = [[one for one in row if one.distance == distance] for distance in DISTANCES]
        cells = [_cell(column) for column in (*columns, row)]
        table.add_row("all" if tilt_deg is None else f"{tilt_deg:g}°", *cells)
    return table


def views_notes(seen: Sequence[Seen]) -> list[str]:
    """The best view and the worst."""
    views: dict[str, list[bool]] = {}
    for one in seen:
        view = f"{one.tilt_deg:g}° from {one.distance:g} m"
        views.setdefault(view, []).append(one.end != ENDS[0])
    ranked = sorted(views, key=lambda view: share(views[view]) or 0.0)
    named = zip(("worst", "best"), (ranked[0], ranked[-1]), strict=True)
    return [
        "in a cell: scenes with a grasp / scenes in which the best one held [%]",
        *(f"{what} view, {view}: a grasp in {percent(views[view])} %" for what, view in named),
    ]


def _cell(seen: Sequence[Seen]) -> str:
    found = share([one.end != ENDS[0] for one in seen]) or 0.0
    held = share([one.end == ENDS[2] for one in seen]) or 0.0
    return f"{100.0 * found:.0f} / {100.0 * held:.0f}"
