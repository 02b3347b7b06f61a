"""`frankie-task grasp eval --by-view`: success by the tilt and the distance of the camera.

The same objects, at rest, are seen from every tilt and every distance. Importing this does not
import MuJoCo.
"""

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from pinocchio import SE3, exp3
from rich.table import Table

from lab.grasps.choice import NetworkChoice, all_results, require_physics
from lab.grasps.scenes import EVALUATION_SEED, Array, camera_noise
from lab.shared import share

TILTS_DEG = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0)  # of the optical axis from straight down
DISTANCES = (0.2, 0.3, 0.45, 0.7, 1.0, 1.5)
"""From the camera to the top of the object, along the optical axis [m]."""

_VIEW_STREAM = 5  # of random numbers


class ViewResult(NamedTuple):
    """Result of the best grasp in one frame."""

    tilt_deg: float
    distance: float
    found: bool
    held: bool


def evaluate_views(choice: NetworkChoice, *, scenes: int, workers: int | None) -> list[ViewResult]:
    """Every scene of one object from every view, the best grasp of each executed in physics.

    Raises ConfigError: MuJoCo is missing.
    """
    require_physics("grasp eval --by-view")
    results = all_results(
        "scenes",
        partial(_scene, choice),
        range(scenes),
        workers,
        lambda views: all(one.found for one in views),
    )
    return [one for views in results for one in views]


def _scene(choice: NetworkChoice, seed: int) -> list[ViewResult]:
    from behaviours import LOOKS
    from lab.grasps.dropped_scenes import drop_scene
    from lab.grasps.judge import best_grasp, execute

    scene = drop_scene(seed, 1)
    rng = np.random.default_rng((EVALUATION_SEED, _VIEW_STREAM, seed))
    (obj,) = scene.world.objects
    top = obj.reach(np.array([0.0, 0.0, 1.0]))
    target = np.array([*obj.pose.translation[:2], top])
    results = []
    for tilt_deg in TILTS_DEG:
        for distance in DISTANCES:
            wTc = looking_at(target, np.radians(tilt_deg), distance, rng)
            noise = camera_noise(rng.random())
            grasp = best_grasp(
                choice.detector(), scene.world, scene.region, wTc, noise, rng, looks=LOOKS
            )
            held = grasp is not None and execute(*scene.hand(), grasp).held
            results.append(ViewResult(tilt_deg, distance, grasp is not None, held))
    return results


def looking_at(target: Array, tilt: float, distance: float, rng: np.random.Generator) -> SE3:
    """WTc of a camera that looks at a (3,) point, from a random side and randomly rolled."""
    about, yaw = rng.uniform(-np.pi, np.pi, 2)
    lean = exp3(tilt * np.array([np.cos(about), np.sin(about), 0.0]))
    axis = lean @ np.array([0.0, 0.0, -1.0])
    down = exp3(np.array([0.0, 0.0, yaw])) @ exp3(np.array([np.pi, 0.0, 0.0]))
    return SE3(lean @ down, target - distance * axis)


def views_table(results: Sequence[ViewResult]) -> Table:
    """Share of scenes with a grasp, and of those in which it held, by tilt and distance."""
    title = "scenes with a grasp / scenes in which the best one held [%]"
    table = Table("tilt", *(f"{distance:g} m" for distance in DISTANCES), "all", title=title)
    for tilt_deg in (*TILTS_DEG, None):
        row = [one for one in results if tilt_deg in (None, one.tilt_deg)]
        columns = [[one for one in row if one.distance == distance] for distance in DISTANCES]
        cells = [_cell(column) for column in (*columns, row)]
        table.add_row("all" if tilt_deg is None else f"{tilt_deg:g}°", *cells)
    return table


def _cell(results: Sequence[ViewResult]) -> str:
    found = share([one.found for one in results]) or 0.0
    held = share([one.held for one in results]) or 0.0
    return f"{100.0 * found:.0f} / {100.0 * held:.0f}"
