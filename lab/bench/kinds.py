"""What the shipped recogniser is worth: what it calls the objects of simulated scenes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from rich.table import Table

from hw.sim import HELDOUT, HOUSEHOLD, MODELLED
from lab.bench.choosing_scenes import CLUTTER, TRAY_REGION, make_world, seen_from_above
from lab.shared import percent, run_all
from perception import SHAPE_CLASSES, segment_objects, with_classes

STRANGE = "among others"
"""Scenes in which most objects are of classes that are none of its kinds."""
_NEAR = 0.02
"""Something seen this near to the middle of an object is that object [m]."""
_TRUE = {"box": "box", "can": "can", "ball": "ball", "cylinder": "roll", "capsule": "roll"}
"""The kind of a class of objects; all others are of none."""
_OTHERS = (*HELDOUT, *MODELLED)


class Called(NamedTuple):
    """One object of a scene."""

    seed: int
    scene: str
    true: str
    """Its kind; empty if it is none of those."""
    called: str
    """What the recogniser took it for; empty for nothing."""


def call(seed: int) -> list[Called]:
    """What the objects of a scene are called, in one noisy frame."""
    kinds = (*CLUTTER, STRANGE)
    scene = kinds[seed % len(kinds)]
    if scene == STRANGE:
        world = make_world("apart", np.random.default_rng((seed, 23)), (*_TRUE, *_OTHERS))
    else:
        world = make_world(scene, np.random.default_rng((seed, 23)), tuple(HOUSEHOLD))
    frame, _ = seen_from_above(world, np.random.default_rng((seed, 29)))
    objects = segment_objects(frame, TRAY_REGION)
    seen = () if objects is None else with_classes(frame, objects, SHAPE_CLASSES[0])
    called = []
    for one in world.objects:
        middle = one.pose.translation[:2]
        near = [other for other in seen if np.linalg.norm(other.position[:2] - middle) < _NEAR]
        true = _TRUE.get(one.name.rpartition(" ")[0], "")
        kind = near[0].kind if near else ""
        called.append(Called(seed, scene, true, kind))
    return called


def run_kinds(seeds: Sequence[int], *, workers: int, cluster: str | None) -> list[Called]:
    """All objects of all scenes, in the order of the seeds; arguments as for `run_choosing`."""
    results = dict(run_all(call, seeds, workers=workers, cluster=cluster, batch=8))
    return [one for number in range(len(seeds)) for one in results[number]]


def kinds_table(called: Sequence[Called]) -> Table:
    """By kind and by scene, each share with its 95 % interval.

    Beside it stands how often an object taken blindly would be of the kind.
    """
    names = ("objects", "called so [%]", "of those called so, are [%]", "blindly [%]")
    table = Table("kind, scenes", *names)
    groups = [("all", list(called))]
    groups += [
        (scene, [one for one in called if one.scene == scene]) for scene in (*CLUTTER, STRANGE)
    ]
    for scene, group in groups:
        for kind in (*SHAPE_CLASSES, "") if scene == "all" else ("any",):
            wanted = [one for one in group if one.true == kind or (kind == "any" and one.true)]
            named = [one for one in group if one.called == kind or (kind == "any" and one.called)]
            table.add_row(
                f"{kind or 'none of these'}, {scene}",
                str(len(wanted)),
                percent([one.called == one.true for one in wanted]),
                percent([one.called == one.true for one in named]),
                percent([one in wanted for one in group]),
            )
    return table
