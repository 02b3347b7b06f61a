"""Outcomes of random feasible grasps in physics: to learn from, and to evaluate what was learnt.

The grasps are drawn evenly over all that the feasibility check accepts, not from the best. Every 50
scenes are a file, so that an interrupted collection resumes.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import NamedTuple
from zipfile import BadZipFile

import numpy as np

from config.arrays import Image, Indices, Mask
from config.reader import ConfigError
from hw.sim import World
from lab.grasps.choice import require
from lab.grasps.results import BIN
from lab.grasps.scenes import (
    EVALUATION_SEED,
    ROBOT,
    Array,
    View,
    camera_noise,
    nearest_object,
    noisy_frame,
    random_view,
)
from lab.grasps.tilts import approach, bare_scene, looking_along
from lab.shared import run_all
from perception import Candidates, GraspDetector, GraspPatches, Proposals


class SceneSet(NamedTuple):
    """A set of scenes."""

    first: int  # seed of the first one
    groups: tuple[str, ...]  # of objects, which take turns
    tilted: bool = False  # whether the approach is, from 15 degrees to level


_HEAVIER = ("trained", "trained, drawn out")
_BODIES = ("bodies", "bodies, drawn out")
_LIGHT = ("trained, as they are", "bodies, as they are")
_HELDOUT = ("shapes", "heavy", "modelled", "large")
SETS: Mapping[str, SceneSet] = {
    "trained": SceneSet(200_000, _HEAVIER),
    "bodies": SceneSet(300_000, _BODIES),
    "light": SceneSet(400_000, _LIGHT),
    "tilted": SceneSet(500_000, (*_HEAVIER, *_BODIES, *_LIGHT), tilted=True),
    "heldout": SceneSet(0, _HELDOUT),
    "heldout_tilted": SceneSet(600_000, _HELDOUT, tilted=True),
}
"""By name; nothing is ever trained on the held-out ones."""
SCENES = 50  # scenes in each file
_GRASP_STREAM = 4  # of random numbers
_POINTS = 40  # tried in a frame
_GRASPS = 6  # executed of a frame at most
_DIRECTIONS = 4  # at each point
_APPROACHES = 3  # to a scene, if they are tilted
_TILTS = (np.radians(15.0), np.radians(90.0))  # of them [rad]


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcomes:
    """Measurements around grasps, and their outcomes."""

    patches: GraspPatches  # N grasps
    good: Mask  # (N,) whether it held without a hard contact
    scene: Indices  # (N,) seeds of the scenes
    objects: Indices  # (N,) number of objects in the scene
    mass: Array  # (N,) of the object at each grasp [kg]; no image shows it


_COLUMNS = tuple(f.name for f in fields(Outcomes) if f.name != "patches")


class _RandomPoints:
    """Proposes random points where a grasp may be."""

    name = "points"

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def propose(self, image: Image, allowed: Mask) -> Proposals:
        v, u = np.nonzero(allowed)
        at = self._rng.integers(len(u), size=_POINTS)
        found = Candidates(
            pixel=np.stack([u[at], v[at]], axis=1).astype(float),
            angle=self._rng.uniform(0.0, np.pi, _POINTS),
            width=np.zeros(_POINTS),
            quality=np.ones(_POINTS),
        )
        every = _POINTS * _DIRECTIONS
        return Proposals(found, allowed.astype(np.float32), _DIRECTIONS, turn_cost=0.0, most=every)


def group_of(seed: int, groups: tuple[str, ...]) -> str:
    """The group of objects of a scene; a scene of one object and a bin are a turn."""
    return groups[seed // 2 % len(groups)]


def scene_outcomes(seed: int, scenes: SceneSet) -> Outcomes | None:
    """Random feasible grasps, each executed in the same scene at rest; None without any.

    Straight down, half the scenes are one object in one view, half are bins in two views. Along
    tilted approaches, a third of them are three objects, and each is seen along three approaches.
    """
    # Not at the top: MuJoCo is an extra.
    from lab.grasps.dropped_scenes import drop_scene
    from lab.grasps.grasp_judge import execute

    rng = np.random.default_rng((EVALUATION_SEED, _GRASP_STREAM, seed))
    group, tilted = group_of(seed, scenes.groups), scenes.tilted
    if tilted:
        scene = bare_scene(seed, int(rng.choice((1, 1, 3))), group)
    else:
        scene = drop_scene(seed, (1, BIN)[seed % 2], group=group)
    recorder = _Recorder()
    detector = GraspDetector(ROBOT.gripper, [_RandomPoints(rng)], recorder, recorder)
    patches: list[GraspPatches] = []
    good: list[bool] = []
    mass: list[float] = []
    for wRa, view in (_tilted_views if tilted else _views)(scene.world, rng):
        frame = noisy_frame(scene.world.shapes(), view.wTc, view.noise, rng)
        found = detector.detect(frame, scene.region, oRa=wRa).grasps
        for chosen in rng.permutation(len(found))[:_GRASPS]:
            attempt = execute(*scene.hand(wRa), found[chosen])
            patches.append(recorder.patches.only(np.array([chosen])))
            good.append(attempt.held and not attempt.hard)
            mass.append(nearest_object(scene.world, found[chosen].oTg.translation).mass)
    if not good:
        return None
    return Outcomes(
        patches=_joined_patches(patches),
        good=np.array(good),
        scene=np.full(len(good), seed),
        objects=np.full(len(good), len(scene.world.objects)),
        mass=np.array(mass),
    )


def _views(world: World, rng: np.random.Generator) -> Iterator[tuple[Array, View]]:
    """From above, each with the frame a of its approach; see `approach`."""
    for _ in range(min(len(world.objects), 2)):
        yield np.eye(3), random_view(world, rng)


def _tilted_views(world: World, rng: np.random.Generator) -> Iterator[tuple[Array, View]]:
    """Along three approaches to random objects."""
    for _ in range(_APPROACHES):
        wRa = approach(rng.uniform(*_TILTS), rng.uniform(-np.pi, np.pi))
        target = world.objects[rng.integers(len(world.objects))].pose.translation
        wTc = looking_along(wRa, target, rng)
        yield wRa, View(wTc=wTc, noise=camera_noise(rng.random()))


class _Recorder:
    """A hold probability of 1 that keeps the patches it was asked for."""

    patches: GraspPatches

    def __call__(self, patches: GraspPatches) -> Array:
        self.patches = patches
        return np.ones(len(patches.numbers))


def collect_outcomes(
    folder: Path, kinds: str, *, scenes: int, workers: int | None
) -> Iterator[Outcomes]:
    """Write the files that a folder lacks, and yield their outcomes.

    `kinds` is one of `SETS`; the number of scenes is rounded up to whole files. Raises ConfigError:
    MuJoCo is missing.
    """
    require("mujoco", "grasp outcomes")
    folder.mkdir(parents=True, exist_ok=True)
    first = SETS[kinds].first
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
    return _joined(
        [
            found
            for seed in range(start, start + SCENES)
            if (found := scene_outcomes(seed, SETS[kinds])) is not None
        ]
    )


def _joined(parts: Sequence[Outcomes]) -> Outcomes:
    return Outcomes(
        patches=_joined_patches([part.patches for part in parts]),
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


def _joined_patches(parts: Sequence[GraspPatches]) -> GraspPatches:
    """All of several, concatenated."""
    return GraspPatches(
        **{
            f.name: np.concatenate([getattr(part, f.name) for part in parts])
            for f in fields(GraspPatches)
        }
    )
