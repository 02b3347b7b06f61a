"""How often the best grasp of one image is valid, on kinds of object that nothing was learnt from.

Valid is what succeeds on the exact geometry: the open hand touches nothing on its way straight
down, and what the fingers close on is held (antipodal within both friction cones, and its weight
carried).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from app.lab.grasps.closed_loop import execute
from app.lab.grasps.scenes import (
    FIRST_SEED,
    HELD_OUT,
    ROBOT,
    View,
    kind_of,
    nearest_object,
    random_view,
    random_world,
)
from behaviours.named import Region
from hw import DepthFrame
from hw.sim import DepthRenderer, World
from perception import GraspDetector

CATEGORIES = ("single", "clutter")
"""One object, or two to ten."""


@dataclass(frozen=True, kw_only=True)
class Judged:
    """What became of the best grasp of one image."""

    seed: int
    category: str
    """`single` or `clutter`."""
    kinds: tuple[str, ...]
    height: float
    """Of the camera above the floor [m]."""
    tilt: float
    """[rad]."""
    trouble: float
    """Noise, 0 to 1."""
    end: str
    """`held`, or what went wrong."""
    target: str
    """Kind of the object nearest to the grasp; empty if there was none."""

    @property
    def valid(self) -> bool:
        """Whether the grasp held."""
        return self.end == "held"


def judge_images(detector: GraspDetector, category: str, seeds: Iterable[int]) -> list[Judged]:
    """Judge the best grasp of one image for every seed."""
    return [judge_image(detector, seed, category) for seed in seeds]


def valid_rate(judged: Sequence[Judged]) -> float:
    """Share of the images whose best grasp is valid."""
    return sum(each.valid for each in judged) / len(judged)


def judge_image(detector: GraspDetector, seed: int, category: str) -> Judged:
    """Make an image, take its best grasp and execute it."""
    scenery = scenery_of(seed, category)
    detection = detector.detect(scenery.frame, scenery.region)
    end, target = f"no grasp: {detection.reason}", ""
    kinds = tuple(kind_of(o) for o in scenery.world.objects)
    if detection.grasps:
        best = detection.grasps[0]
        target = kind_of(nearest_object(scenery.world, best.wTg.translation))
        end = execute(scenery.world, best)
    return Judged(
        seed=seed,
        category=category,
        kinds=kinds,
        height=scenery.view.height,
        tilt=scenery.view.tilt,
        trouble=scenery.view.trouble,
        end=end,
        target=target,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Scenery:
    """An image to judge, and what it shows."""

    world: World
    region: Region
    view: View
    frame: DepthFrame


def scenery_of(seed: int, category: str) -> Scenery:
    """The image of a seed; the same seed and category give the same."""
    rng = np.random.default_rng((FIRST_SEED, CATEGORIES.index(category), seed))
    world, region = random_world(
        rng, HELD_OUT, 1 if category == "single" else int(rng.integers(2, 11))
    )
    view = random_view(world, rng)
    depth = DepthRenderer(ROBOT.camera.intrinsics).render(world.shapes(), view.wTc)
    depth = view.noise.apply(depth, ROBOT.camera, rng)
    frame = DepthFrame(depth=depth, intrinsics=ROBOT.camera.intrinsics, wTc=view.wTc, stamp=0.0)
    return Scenery(world=world, region=region, view=view, frame=frame)
