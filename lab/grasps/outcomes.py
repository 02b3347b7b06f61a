"""Outcomes of random feasible grasps in physics: to learn from, and to evaluate what was learnt.

The grasps are drawn evenly over all that the feasibility check accepts, not from the best. Every 50
scenes are a file, so that an interrupted collection resumes.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt

from config import ConfigError
from lab.grasps.choice import require_physics
from lab.shared import run_all
from perception import Candidates, GraspDetector, GraspPatches, Proposals, joined_patches

SETS: Mapping[str, tuple[int, tuple[str, ...]]] = {
    "trained": (200_000, ("trained", "trained, drawn out")),
    "bodies": (300_000, ("bodies", "bodies, drawn out")),
    "light": (400_000, ("trained, as they are", "bodies, as they are")),
    "heldout": (0, ("shapes", "heavy", "modelled", "large")),
}
"""By name: seed of the first scene, and the groups of objects that take turns. Nothing is ever
trained on the last."""
SCENES = 50  # scenes in each file
_GRASP_STREAM = 4  # of random numbers
_POINTS = 40  # tried in a frame at most
_GRASPS = 6  # executed of a frame at most
_DIRECTIONS = 4  # at each point
_FEASIBLE = 16  # grasps at a point at most, of which one is drawn


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcomes:
    """Measurements around grasps, and their outcomes."""

    patches: GraspPatches  # N grasps
    good: npt.NDArray[np.bool_]  # (N,) whether it held without a hard contact
    scene: npt.NDArray[np.int64]  # (N,) seeds of the scenes
    objects: npt.NDArray[np.int64]  # (N,) number of objects in the scene
    mass: npt.NDArray[np.float64]  # (N,) of the object at each grasp [kg]; no image shows it


_COLUMNS = tuple(f.name for f in fields(Outcomes) if f.name != "patches")


class _OnePoint:
    """Proposes one random point where a grasp may be."""

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
        return Proposals(
            found, allowed.astype(np.float32), _DIRECTIONS, turn_cost=0.0, most=_FEASIBLE
        )


def group_of(seed: int, groups: tuple[str, ...]) -> str:
    """The group of objects of a scene; a scene of one object and a bin are a turn."""
    return groups[seed // 2 % len(groups)]


def scene_outcomes(seed: int, groups: tuple[str, ...]) -> Outcomes | None:
    """Random feasible grasps, each executed in the same scene at rest; None without any.

    Half the scenes are one object in one view, half are bins in two views.
    """
    # Not at the top: MuJoCo is an extra.
    from lab.grasps.dropped_scenes import drop_scene
    from lab.grasps.judge import execute
    from lab.grasps.results import BIN
    from lab.grasps.scenes import EVALUATION_SEED, ROBOT, nearest_object, noisy_frame, random_view

    count = (1, BIN)[seed % 2]
    scene = drop_scene(seed, count, group=group_of(seed, groups))
    rng = np.random.default_rng((EVALUATION_SEED, _GRASP_STREAM, seed))
    recorder = _Recorder()
    detector = GraspDetector(gripper=ROBOT.gripper, proposer=_OnePoint(rng), hold=recorder)
    patches: list[GraspPatches] = []
    good: list[bool] = []
    mass: list[float] = []
    for _ in range(1 if count == 1 else 2):
        view = random_view(scene.world, rng)
        frame = noisy_frame(scene.world.shapes(), view.wTc, view.noise, rng)
        remaining = _GRASPS
        for _ in range(_POINTS):
            found = detector.detect(frame, scene.region).grasps
            if not found:
                continue
            chosen = int(rng.integers(len(found)))
            attempt = execute(*scene.hand(), found[chosen])
            patches.append(recorder.patches.only(np.array([chosen])))
            good.append(attempt.held and not attempt.hard)
            mass.append(nearest_object(scene.world, found[chosen].wTg.translation).mass)
            remaining -= 1
            if not remaining:
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
    """A hold probability of 1 that keeps the patches it was asked for."""

    patches: GraspPatches

    def __call__(self, patches: GraspPatches) -> npt.NDArray[np.float64]:
        self.patches = patches
        return np.ones(len(patches.numbers))


def collect_outcomes(
    folder: Path, kinds: str, *, scenes: int, workers: int | None
) -> Iterator[Outcomes]:
    """Write the files that a folder lacks, and yield their outcomes.

    `kinds` is one of `SETS`; the number of scenes is rounded up to whole files. Raises ConfigError:
    MuJoCo is missing.
    """
    require_physics("grasp outcomes")
    folder.mkdir(parents=True, exist_ok=True)
    first, _ = SETS[kinds]
    starts = range(first, first + scenes, SCENES)
    missing = [start for start in starts if not _file(folder, kinds, start).exists()]
    for number, found in run_all(partial(_some_scenes, kinds), missing, workers=workers, batch=1):
        _write(_file(folder, kinds, missing[number]), found)
        yield found


def read_outcomes(folder: Path, *kinds: str) -> Outcomes:
    """All outcomes of some sets in a folder.

    Raises ConfigError: there are none, or a file cannot be read.
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
