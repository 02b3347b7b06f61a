"""`frankie-task grasp eval --judge physics`: grasps of several detectors, paired scene by scene.

Importing this does not import MuJoCo.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from config import ConfigError
from lab.grasps.choice import NetworkChoice, all_results
from lab.grasps.physical_results import (
    BIN,
    Attempt,
    BinResult,
    PhysicalEvaluation,
    Row,
    read_evaluation,
)

BESIDE = (
    NetworkChoice(network="check", ranked="likelihood"),
    NetworkChoice(network="check"),
    NetworkChoice(network="none"),
    NetworkChoice(network="none", ranked="first"),
)
"""What stands beside every choice: the default without what proposes grasps, the check alone with
points all over and by chance, and the latter ranked as in the first version."""
_MESHES = ("*.glb", "*.obj", "*.off", "*.ply", "*.stl")


def evaluate_by_physics(
    choice: NetworkChoice,
    *,
    scenes: int,
    bins: int,
    meshes: Path | None,
    against: Path | None,
    by_chance: int = 0,
    workers: int,
) -> PhysicalEvaluation:
    """Judge a network, and what does without one, on the same scenes.

    Args:
        choice: the network.
        scenes: number of scenes of one object.
        bins: number of bins.
        meshes: a folder of meshes to take the objects from.
        against: figures that were written before; their rows are compared, too.
        by_chance: grasps to try in each scene of one object that no row held, to see whether there
            is any; 0 leaves it.
        workers: number of processes.

    Raises:
        WeightsError: the weights are missing or do not fit.
        ConfigError: a file or a folder cannot be used.
    """
    if find_spec("mujoco") is None:
        raise ConfigError('--judge physics needs an extra: pip install "frankie-task[physics]"')
    before = read_evaluation(against) if against else None
    files = _mesh_files(meshes) if meshes else ()
    choices = (choice, *(beside for beside in BESIDE if beside.name != choice.name))
    for each in choices:
        each.detector()
    singles = all_results(
        "scenes",
        partial(_single, choices, files),
        range(scenes),
        workers,
        lambda found: found[2][0].held,
    )
    emptied = all_results(
        "bins",
        partial(_bin, choices, files),
        range(bins),
        workers,
        lambda found: found[1][0].cleared == BIN,
    )
    told = tuple(f"{group}, {of_class}" for group, of_class, _ in singles)
    rows = [
        Row(
            name=each.name,
            singles=tuple(attempts[number] for _, _, attempts in singles),
            bins=tuple(results[number] for _, results in emptied),
        )
        for number, each in enumerate(choices)
    ]
    if before is not None:
        if before.scenes != told or any(len(row.bins) != bins for row in before.rows):
            raise ConfigError(f"{against}: other scenes; give the same --scenes, --bins, --meshes")
        rows += before.rows
    lost = [n for n in range(scenes) if not any(row.held[n] for row in rows)] if by_chance else []
    tried = all_results("lost", partial(_by_chance, by_chance, files), lost, workers, bool)
    return PhysicalEvaluation(
        scenes=told,
        rows=tuple(rows),
        hopeless=tuple(n for n, held in zip(lost, tried, strict=True) if not held),
        by_chance=by_chance,
    )


def _single(
    choices: Sequence[NetworkChoice], meshes: Sequence[Path], seed: int
) -> tuple[str, str, list[Attempt]]:
    from lab.grasps.physical_judge import judge_single

    return judge_single(seed, choices, meshes)


def _bin(
    choices: Sequence[NetworkChoice], meshes: Sequence[Path], seed: int
) -> tuple[str, list[BinResult]]:
    from lab.grasps.physical_judge import judge_bin

    return judge_bin(seed, choices, meshes)


def _by_chance(tries: int, meshes: Sequence[Path], seed: int) -> bool:
    from lab.grasps.by_chance import holds_by_chance

    return holds_by_chance(tries, meshes, seed)


def _mesh_files(folder: Path) -> tuple[Path, ...]:
    """The files of meshes in a folder.

    Raises:
        ConfigError: there are none.
    """
    found = sorted(path for pattern in _MESHES for path in folder.rglob(pattern))
    if not found:
        raise ConfigError(f"{folder}: no mesh ({', '.join(_MESHES)}) in this folder")
    return tuple(path.absolute() for path in found)
