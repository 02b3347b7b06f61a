"""What becomes of random feasible grasps, by physics: to learn from, and to judge what was learnt.

They are drawn evenly over all that the check lets pass, not from the best: what is learnt from them
has to tell good from bad anywhere. Every 50 scenes are a file, so that an interrupted collection
goes on where it was.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt

from config import ConfigError
from lab.shared import run_all
from perception import (
    Candidates,
    GraspDetector,
    GraspPatches,
    Proposals,
    joined_patches,
)

SETS: Mapping[str, tuple[int, tuple[str, ...]]] = {
    "trained": (200_000, ("trained", "trained, drawn out")),
    "bodies": (300_000, ("bodies", "bodies, drawn out")),
    "light": (400_000, ("trained, as they are", "bodies, as they are")),
    "heldout": (0, ("shapes", "heavy", "modelled", "large")),
}
"""By name: the seed of the first scene, and the groups of objects that take turns. Nothing is ever
learnt from the last."""
SCENES = 50
"""In each file."""
_DRAWS = 4  # the stream of random numbers that grasps are drawn from
_POINTS = 40  # tried in a frame at most
_GRASPS = 6  # executed of a frame at most
_DIRECTIONS = 4  # at each point
_DRAWN = 16  # feasible ones at a point, of which one is drawn, at most


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcomes:
    """Grasps as they were seen, and what became of them."""

    patches: GraspPatches
    """Of N grasps."""
    good: npt.NDArray[np.bool_]
    """(N,) whether it held without a hard contact."""
    scene: npt.NDArray[np.int64]
    """(N,) seeds of the scenes."""
    objects: npt.NDArray[np.int64]
    """(N,) how many there were in the scene."""
    mass: npt.NDArray[np.float64]
    """(N,) of the object at each grasp [kg], which no image shows."""


_COLUMNS = tuple(f.name for f in fields(Outcomes) if f.name != "patches")


class _OnePoint:
    """A point by chance where a grasp may be, another one each time."""

    name = "one"

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def propose(self, image: npt.NDArray[np.float32], allowed: npt.NDArray[np.bool_]) -> Proposals:
        v, u = np.nonzero(allowed)
        at = self._rng.integers(len(u))
        found = Candidates(
            pixel=np.array([[u[at], v[at]]], dtype=float),
            angle=self._rng.uniform(0.0, np.pi, 1),
            width=np.zeros(1),
            quality=np.ones(1),
        )
        return Proposals(found, allowed.astype(np.float32), _DIRECTIONS, turn_cost=0.0, most=_DRAWN)


def group_of(seed: int, groups: tuple[str, ...]) -> str:
    """Whose turn it is among groups of objects; a scene of one object and a bin are a turn."""
    return groups[seed // 2 % len(groups)]


def scene_outcomes(seed: int, groups: tuple[str, ...]) -> Outcomes | None:
    """Random feasible grasps, each executed in the same scene at rest; None if there were none.

    Half the scenes are of one object and seen once, half are bins and seen from two views.

    Args:
        seed: of the scene.
        groups: of objects, by turns.
    """
    # Not at the top: MuJoCo is an extra.
    from lab.grasps.physical_judge import execute
    from lab.grasps.physical_results import BIN
    from lab.grasps.physical_scenes import dropped, look
    from lab.grasps.scenes import EVALUATION_SEED, ROBOT, nearest_object

    count = (1, BIN)[seed % 2]
    scene = dropped(seed, count, group=group_of(seed, groups))
    rng = np.random.default_rng((EVALUATION_SEED, _DRAWS, seed))
    seen = _Recorder()
    detector = GraspDetector(gripper=ROBOT.gripper, proposer=_OnePoint(rng), hold=seen)
    patches: list[GraspPatches] = []
    good: list[bool] = []
    mass: list[float] = []
    for _ in range(1 if count == 1 else 2):
        frame = look(scene.world, rng)
        left = _GRASPS
        for _ in range(_POINTS):
            found = detector.detect(frame, scene.region).grasps
            if not found:
                continue
            chosen = int(rng.integers(len(found)))
            attempt = execute(*scene.hand(), found[chosen])
            patches.append(seen.patches.only(np.array([chosen])))
            good.append(attempt.held and not attempt.hard)
            mass.append(nearest_object(scene.world, found[chosen].wTg.translation).mass)
            left -= 1
            if not left:
                break
    if not good:
        return None
    return Outcomes(
        patches=joined_patches(patches),
        good=np.array(good),
        scene=np.full(len(good), seed),
        objects=np.full(len(good), count),
        mass=np.array(mass),
    )


class _Recorder:
    """Leaves the order of grasps as it is, and remembers what was seen of them."""

    patches: GraspPatches

    def __call__(self, patches: GraspPatches) -> npt.NDArray[np.float64]:
        self.patches = patches
        return np.ones(len(patches.numbers))


def collect_outcomes(folder: Path, kinds: str, *, scenes: int, workers: int) -> Iterator[Outcomes]:
    """Add the files of scenes that a folder lacks to it, and yield their outcomes.

    Args:
        folder: of the files; it is made if there is none.
        kinds: one of `SETS`.
        scenes: how many there shall be, rounded up to whole files.
        workers: number of processes.

    Raises:
        ConfigError: MuJoCo is missing.
    """
    if find_spec("mujoco") is None:
        raise ConfigError('grasp outcomes needs an extra: pip install "frankie-task[physics]"')
    folder.mkdir(parents=True, exist_ok=True)
    first, _ = SETS[kinds]
    starts = range(first, first + scenes, SCENES)
    missing = [start for start in starts if not _file(folder, kinds, start).exists()]
    for number, found in run_all(partial(_some_scenes, kinds), missing, workers=workers, batch=1):
        _write(_file(folder, kinds, missing[number]), found)
        yield found


def read_outcomes(folder: Path, *kinds: str) -> Outcomes:
    """All outcomes of some of the sets that a folder holds.

    Raises:
        ConfigError: there are none, or a file cannot be read.
    """
    files = sorted(file for kind in kinds for file in folder.glob(f"{kind}-*.npz"))
    if not files:
        names = " or ".join(f"`{kind}`" for kind in kinds)
        raise ConfigError(f"{folder}: no outcomes of {names}; `frankie-task grasp outcomes` first")
    return _joined([_read(file) for file in files])


def _some_scenes(kinds: str, start: int) -> Outcomes:
    _, groups = SETS[kinds]
    return _joined(
        [
            found
            for seed in range(start, start + SCENES)
            if (found := scene_outcomes(seed, groups)) is not None
        ]
    )


def _joined(parts: Sequence[Outcomes]) -> Outcomes:
    return Outcomes(
        patches=joined_patches([part.patches for part in parts]),
        **{name: np.concatenate([getattr(part, name) for part in parts]) for name in _COLUMNS},
    )


def _file(folder: Path, kinds: str, start: int) -> Path:
    return folder / f"{kinds}-{start}.npz"


def _write(file: Path, found: Outcomes) -> None:
    patches = {f.name: getattr(found.patches, f.name) for f in fields(GraspPatches)}
    columns = {name: getattr(found, name) for name in _COLUMNS}
    partly = file.with_suffix(".partly")
    with partly.open("wb") as out:
        np.savez_compressed(out, **columns, **patches)
    partly.rename(file)


def _read(file: Path) -> Outcomes:
    try:
        with np.load(file, allow_pickle=False) as data:
            patches = GraspPatches(**{f.name: data[f.name] for f in fields(GraspPatches)})
            return Outcomes(patches=patches, **{name: data[name] for name in _COLUMNS})
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        raise ConfigError(
            f"{file}: not a file of `grasp outcomes`; remove it to collect it anew"
        ) from error
