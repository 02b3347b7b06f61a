"""`frankie-task grasp eval`: several detectors on the same scenes, judged by physics.

Importing this does not import MuJoCo.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path

from config.reader import ConfigError
from lab.grasps.choice import NetworkChoice, all_results, require
from lab.grasps.results import BIN, GraspEvaluation, Row

BASELINES = (
    NetworkChoice(network="check", ranked="likelihood"),
    NetworkChoice(network="check"),
    NetworkChoice(network="none"),
)
"""Compared with every choice: the default ranking without a network, and the check alone with
points everywhere and at random."""
_MESHES = ("*.glb", "*.obj", "*.off", "*.ply", "*.stl")


def evaluate_grasps(
    choice: NetworkChoice,
    *,
    scenes: int,
    bins: int,
    meshes: Path | None,
    by_chance: int = 0,
    workers: int | None,
) -> GraspEvaluation:
    """Judge a network and the baselines on the same scenes.

    Raises WeightsError: the weights are missing or do not fit; ConfigError: a file or a folder
    cannot be used.
    """
    require("mujoco", "grasp eval")
    from lab.grasps.grasp_judge import judge_bin, judge_single, random_grasp_holds

    files = _mesh_files(meshes) if meshes else ()
    choices = (choice, *(each for each in BASELINES if each.name != choice.name))
    for each in choices:
        each.detector()
    singles = all_results(
        "scenes",
        partial(judge_single, choices, files),
        range(scenes),
        workers,
        lambda found: found[2][0].held,
    )
    emptied = all_results(
        "bins",
        partial(judge_bin, choices, files),
        range(bins),
        workers,
        lambda found: found[0].cleared == BIN,
    )
    names = tuple(f"{group}, {of_class}" for group, of_class, _ in singles)
    rows = [
        Row(
            name=each.name,
            singles=tuple(attempts[number] for _, _, attempts in singles),
            bins=tuple(results[number] for results in emptied),
        )
        for number, each in enumerate(choices)
    ]
    lost = [n for n in range(scenes) if not any(row.held[n] for row in rows)] if by_chance else []
    held = all_results("lost", partial(random_grasp_holds, by_chance, files), lost, workers, bool)
    hopeless = tuple(n for n, any_held in zip(lost, held, strict=True) if not any_held)
    rows = [replace(row, hopeless=hopeless) for row in rows]
    return GraspEvaluation(scenes=names, rows=tuple(rows), by_chance=by_chance)


def _mesh_files(folder: Path) -> tuple[Path, ...]:
    found = sorted(path for pattern in _MESHES for path in folder.rglob(pattern))
    if not found:
        raise ConfigError(f"{folder}: no mesh ({', '.join(_MESHES)}) in this folder")
    return tuple(path.absolute() for path in found)
