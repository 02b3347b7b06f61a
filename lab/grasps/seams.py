"""Training of the network that separates touching objects.

    python -m lab.grasps.seams perception/weights/seams.json

Objects of many classes, none of them held out, lie in heaps, in two colours only, so that many
touch others of the same colour, or apart, in pairs or in one cluster. The renderer labels the
points with their object. The network is fitted to most of the scenes and evaluated on the others.
"""

import json
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from behaviours import Region
from config.arrays import Indices
from hw import DepthFrame
from hw.sim import (
    Container,
    D435Noise,
    DepthRenderer,
    Objects,
    Scene,
    SimObject,
    Table,
    World,
    build_world,
    painted,
)
from hw.sim.objects import HOUSEHOLD, MODELLED
from lab.grasps.objects import TRAIN
from lab.shared import progress, run_in_order
from perception import (
    BOUNDARY_FEATURES,
    BoundaryModel,
    blob_of,
    boundary_features,
    candidate_boundaries,
    log_features,
    raised_regions,
)
from robots import Array, load_robot

TRAY, INNER, FLOOR = (0.80, 0.0), (0.44, 0.36), 0.456
"""Middle of the tray, its inner size and the height of its floor [m]."""
TRAY_REGION = Region(
    name="tray", mTr=SE3(np.eye(3), np.array([*TRAY, FLOOR + 0.1])), size=np.array([*INNER, 0.2])
)
CLUTTER = ("apart", "pairs", "cluster")
"""Arrangements: 6 mm or more apart; two pairs that touch; all pushed to one in the middle."""
SCENES = 2400
FIRST_SEED = 100_000
_AMBIGUOUS = ("caterpillar", "composed", "stack", "twins")  # cannot be known to be one object
_CLASSES = tuple(name for name in (*HOUSEHOLD, *TRAIN, *MODELLED) if name not in _AMBIGUOUS)
_COLOURS = ((214, 84, 70), (84, 104, 184))
_HEIGHTS = (0.36, 0.5)  # of the camera over the floor [m]
_OFF = 0.04  # the middle of the tray from the middle of the image, at most [m]
_CUT_THROUGH = 0.12  # share of an object on the smaller side of a seam that cuts it
_LEAST = 0.05  # smaller shares of a piece are noise
_HELD_OUT = 6  # one scene of this many is held out
_NEEDED = 0.9  # known classes are cut alike from 0.5 to 0.9, unknown ones less often
_HIDDEN = (32, 32)
_EPOCHS, _BATCH = 40, 512
_RATE, _DECAY = 3e-3, 1e-4


class Seam(NamedTuple):
    """A candidate seam across a piece, with its label."""

    piece: tuple[int, int]  # Scene, and number of the piece in it
    many: bool  # whether the piece is more than one object
    right: bool  # whether it separates objects and cuts none
    measures: Array


def make_world(clutter: str, rng: np.random.Generator, kinds: Sequence[str]) -> World:
    """Five to eight objects of some classes in the tray, in one of the arrangements `CLUTTER`."""
    count = int(rng.integers(5, 9))
    scene = Scene(
        container=Container(centre=TRAY, inner_size=INNER, floor_height=FLOOR),
        table=Table(centre=(0.0, 2.5)),
        objects=Objects(count=count, kinds=tuple(kinds), width_mm=(15.0, 60.0)),
    )
    world = build_world(scene, rng)
    if clutter == "pairs":
        for obj in world.objects[:2]:
            others = [other for other in world.objects if other is not obj]
            _push(world, obj, min(others, key=lambda other: _gap(other, obj.pose.translation)))
    elif clutter == "cluster":
        middle = min(world.objects, key=lambda obj: _gap(obj, np.array([*TRAY, 0.0])))
        others = sorted(world.objects, key=lambda obj: _gap(obj, middle.pose.translation))
        for obj in others[1:]:
            _push(world, obj, middle)
    return world


def _push(world: World, obj: SimObject, other: SimObject) -> None:
    """Push an object along the floor towards another one, until it is blocked."""
    way = other.pose.translation - obj.pose.translation
    way[2] = 0.0
    length = float(np.linalg.norm(way))
    world.push(obj, way / length, length)


def _gap(obj: SimObject, point: Array) -> float:
    return float(np.linalg.norm((obj.pose.translation - point)[:2]))


def seen_from_above(
    world: World, rng: np.random.Generator, height: float, off: tuple[float, float]
) -> tuple[DepthFrame, Indices]:
    """A noisy frame of the tray, and the number of the object in each pixel; -1 is none.

    The camera is at `height` over the floor of the tray, and `off` its middle along x and y [m].
    """
    camera = load_robot("frankie").camera
    position = np.array([TRAY[0] + off[0], TRAY[1] + off[1], FLOOR + height])
    wTc = SE3(np.diag([1.0, -1.0, -1.0]), position)
    shapes = world.shapes()
    depth, ids = DepthRenderer(camera.intrinsics).render_with_ids(shapes, wTc)
    names = {obj.name: number for number, obj in enumerate(world.objects)}
    owner = np.array([*(names.get(shape.name, -1) for shape in shapes), -1])[ids]
    colours = painted(shapes, ids)
    frame = DepthFrame(
        depth=D435Noise().apply(depth, camera, rng),
        intrinsics=camera.intrinsics,
        oTc=wTc,
        stamp=0.0,
        paint=lambda: colours,
    )
    return frame, owner


def scene_seams(seed: int) -> list[Seam]:
    """All labelled seams of a scene."""
    rng = np.random.default_rng((seed, 31))
    natural = seed % 2 == 1
    world = make_world(CLUTTER[seed % 3 if natural else 1 + seed // 2 % 2], rng, _CLASSES)
    for obj in [] if natural else world.objects:
        colour = _COLOURS[rng.integers(len(_COLOURS))]
        obj.parts = tuple(replace(part, colour=colour) for part in obj.parts)
    off = (rng.uniform(-_OFF, _OFF), rng.uniform(-_OFF, _OFF))
    frame, owner = seen_from_above(world, rng, rng.uniform(*_HEIGHTS), off)
    what = raised_regions(frame, TRAY_REGION)
    if what is None:
        return []
    found = []
    for number in range(1, int(what.of_point.max()) + 1):
        mine = what.of_point == number
        piece, at = blob_of(what.points[mine], TRAY_REGION.floor, what.cell)
        owners = owner[what.raised][mine]
        ones, counts = np.unique(owners[owners >= 0], return_counts=True)
        ones = ones[counts >= _LEAST * counts.sum()]
        for parts in candidate_boundaries(piece):
            inside = parts[0][at]
            shares = np.array([inside[owners == one].mean() for one in ones])
            through = bool((np.minimum(shares, 1.0 - shares) > _CUT_THROUGH).any())
            right = not through and len(set(shares > 0.5)) == 2
            if through or right:
                many = len(ones) > 1
                found.append(Seam((seed, number), many, right, boundary_features(piece, parts)))
    return found


def fit(seams: Sequence[Seam]) -> BoundaryModel:
    """The model fitted to seams, always the same; a seam weighs 1 / √(seams of its piece)."""
    import torch
    from torch import nn

    torch.manual_seed(0)
    measures = np.array([one.measures for one in seams])
    logs = log_features(measures)
    model = BoundaryModel(
        middle=logs.mean(axis=0), spread=logs.std(axis=0) + 1e-9, layers=(), needed=0.0
    )
    of_piece = Counter(one.piece for one in seams)
    weights = np.array([of_piece[one.piece] ** -0.5 for one in seams])
    inputs, right, weight = (
        torch.tensor(np.asarray(each), dtype=torch.float32)
        for each in (
            model.inputs(measures),
            [[float(one.right)] for one in seams],
            (weights / weights.mean())[:, None],
        )
    )
    linear = [nn.Linear(n, m) for n, m in pairwise((inputs.shape[1], *_HIDDEN, 1))]
    network = nn.Sequential(*(layer for one in linear for layer in (one, nn.ReLU())))[:-1]
    optimiser = torch.optim.AdamW(network.parameters(), _RATE, weight_decay=_DECAY)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, _EPOCHS)
    for _ in range(_EPOCHS):
        for batch in torch.split(torch.randperm(len(inputs)), _BATCH):
            optimiser.zero_grad()
            loss = nn.functional.binary_cross_entropy_with_logits(
                network(inputs[batch]), right[batch], weight=weight[batch]
            )
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
        schedule.step()
    layers = tuple(
        (one.weight.detach().numpy().astype(float), one.bias.detach().numpy().astype(float))
        for one in linear
    )
    return replace(model, layers=layers)


def mistakes(model: BoundaryModel, seams: Sequence[Seam]) -> dict[float, int]:
    """Number of pieces cut wrongly or wrongly left whole, by the threshold of the likelihood."""
    likely = model.likely(np.array([one.measures for one in seams]))
    best: dict[tuple[int, int], tuple[float, Seam]] = {}
    for likelihood, one in zip(likely, seams, strict=True):
        if one.piece not in best or likelihood > best[one.piece][0]:
            best[one.piece] = (float(likelihood), one)
    return {
        float(needed): sum(
            not one.right if likelihood > needed else one.many for likelihood, one in best.values()
        )
        for needed in np.arange(0.1, 0.95, 0.05).round(2)
    }


def main() -> None:
    """Fit, and write the file given as the argument."""
    (file,) = sys.argv[1:]
    with progress("scenes", SCENES) as advance:
        found = run_in_order(
            scene_seams,
            range(FIRST_SEED, FIRST_SEED + SCENES),
            lambda seams: advance(False),
            workers=None,
            batch=20,
        )
    held_out = [n for n in range(SCENES) if n % _HELD_OUT == 1]
    model = fit([one for n in range(SCENES) if n not in held_out for one in found[n]])
    wrong = mistakes(model, [one for n in held_out for one in found[n]])
    print(f"mistakes in {len(held_out)} scenes, by threshold: {wrong}")
    weights = {
        "measures": BOUNDARY_FEATURES,
        "middle": _plain(model.middle),
        "spread": _plain(model.spread),
        "layers": [[_plain(each) for each in layer] for layer in model.layers],
        "needed": _NEEDED,
    }
    Path(file).write_text(json.dumps(weights) + "\n", encoding="utf-8")


def _plain(values: Array) -> object:
    """For JSON, with five digits."""
    return np.vectorize(lambda each: float(f"{each:.5g}"))(values).tolist()


if __name__ == "__main__":
    main()
