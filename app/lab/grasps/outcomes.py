"""What becomes of random feasible grasps, by physics: for probabilities, not for rankings.

Every scene is a line of a file, so that an interrupted collection goes on where it was.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import numpy.typing as npt

from config import ConfigError
from perception import (
    Candidates,
    GraspDetector,
    GraspEstimate,
    Proposals,
)

FEATURES = ("quality", "lever", "width", "room", "depth", "height", "volume", "moment")
"""Names of the entries of `Outcome.features`."""
_DRAWS = 4  # the stream of random numbers that grasps are drawn from
_POINTS = 40  # tried in a scene at most
_FIRST_TO_FIT = 100_000  # seed of the scenes to fit to
_DIRECTIONS = 4  # at each point


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """One grasp, as it was seen, and what became of it."""

    features: tuple[float, ...]
    """See `FEATURES`; in m, m^3, and m^4 for the lever arm times the volume."""
    good: bool
    """Whether it held without a hard contact."""


@dataclass(frozen=True, kw_only=True)
class SceneOutcomes:
    """The grasps of one scene."""

    seed: int
    group: str
    count: int
    """Of the objects."""
    outcomes: tuple[Outcome, ...]


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
        return Proposals(found, allowed.astype(np.float32), _DIRECTIONS, turn_cost=0.0)


def scene_outcomes(seed: int, groups: tuple[str, str], grasps: int) -> SceneOutcomes:
    """Random feasible grasps in one frame, each executed in the same scene at rest.

    Half the scenes are of one object, half of a bin.

    Args:
        seed: of the scene.
        groups: of objects, by turns.
        grasps: their number at most.
    """
    # Not at the top: MuJoCo is an extra.
    from app.lab.grasps.physical_judge import execute
    from app.lab.grasps.physical_results import BIN
    from app.lab.grasps.physical_scenes import dropped, look
    from app.lab.grasps.scenes import EVALUATION_SEED, FLOOR, ROBOT

    count, group = (1, BIN)[seed % 2], groups[seed // 2 % 2]
    scene = dropped(seed, count, group=group)
    rng = np.random.default_rng((EVALUATION_SEED, _DRAWS, seed))
    frame = look(scene.world, rng)
    detector = GraspDetector(gripper=ROBOT.gripper, proposer=_OnePoint(rng))
    outcomes: list[Outcome] = []
    for _ in range(_POINTS):
        found = detector.detect(frame, scene.region).grasps
        if not found:
            continue
        grasp = found[int(rng.integers(len(found)))]
        attempt = execute(*scene.hand(), grasp)
        good = attempt.held and not attempt.hard
        outcomes.append(Outcome(features=_features(grasp, FLOOR), good=good))
        if len(outcomes) == grasps:
            break
    return SceneOutcomes(seed=seed, group=group, count=count, outcomes=tuple(outcomes))


def collect_outcomes(
    file: Path, *, heldout: bool, scenes: int, grasps: int
) -> Iterator[SceneOutcomes]:
    """Add the scenes that a file lacks to it, and yield each.

    Raises:
        ConfigError: the file exists and is something else, or MuJoCo is missing.
    """
    if find_spec("mujoco") is None:
        raise ConfigError('grasp outcomes needs an extra: pip install "frankie-task[physics]"')
    from app.lab.grasps.physical_scenes import TO_FIT, TO_JUDGE

    groups, first_seed = (TO_JUDGE, 0) if heldout else (TO_FIT, _FIRST_TO_FIT)
    there = {each.seed for each in read_outcomes(file)} if file.exists() else set()
    for seed in range(first_seed, first_seed + scenes):
        if seed in there:
            continue
        found = scene_outcomes(seed, groups, grasps)
        with file.open("a", encoding="utf-8") as out:
            out.write(json.dumps(asdict(found)) + "\n")
        yield found


def read_outcomes(file: Path) -> list[SceneOutcomes]:
    """The scenes that `collect_outcomes` wrote.

    Raises:
        ConfigError: the file cannot be read.
    """
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError) as error:
        raise ConfigError(f"{file}: cannot be read ({error})") from error
    return [_scene(file, number, line) for number, line in enumerate(lines, 1)]


def _scene(file: Path, number: int, line: str) -> SceneOutcomes:
    try:
        told = json.loads(line)
        outcomes = tuple(
            Outcome(features=tuple(map(float, each["features"])), good=bool(each["good"]))
            for each in told.pop("outcomes")
        )
        if any(len(each.features) != len(FEATURES) for each in outcomes):
            raise ValueError
        return SceneOutcomes(**told, outcomes=outcomes)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ConfigError(
            f"{file}:{number}: not a scene of `grasp outcomes`; remove the line to collect it anew"
        ) from error


def _features(grasp: GraspEstimate, floor: float) -> tuple[float, ...]:
    height = float(grasp.wTg.translation[2]) - floor
    return (
        grasp.quality,
        grasp.lever,
        grasp.width,
        grasp.opening - grasp.width,
        grasp.depth,
        height,
        grasp.volume,
        grasp.lever * grasp.volume,
    )
