"""Are as many objects told apart as there are? Judged by the simulated world that made them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from rich.table import Table

from hw.sim import HELDOUT
from lab.bench.choosing_scenes import (
    CLUTTER,
    TRAY_REGION,
    make_scene,
    make_world,
    seen_from_above,
)
from lab.shared import percent, run_all
from perception import segment_objects

SETS = ("household", "held out")
"""Classes of the objects: those of `bench choosing`, and those that nothing was fitted to."""


class Counted(NamedTuple):
    """One scene."""

    of: str
    """One of `SETS`."""
    clutter: str
    objects: int
    counted: int

    @property
    def is_right(self) -> bool:
        """Whether as many were counted as there are."""
        return self.counted == self.objects


def count(seed: int) -> list[Counted]:
    """In one noisy frame, once with each set of classes."""
    clutter = CLUTTER[seed % len(CLUTTER)]
    others = make_world(clutter, np.random.default_rng((seed, 77)), tuple(HELDOUT))
    counted = []
    for of, world in zip(SETS, (make_scene(seed)[0], others), strict=True):
        frame, _ = seen_from_above(world, np.random.default_rng((seed, 29)))
        seen = segment_objects(frame, TRAY_REGION) or ()
        counted.append(Counted(of, clutter, len(world.objects), len(seen)))
    return counted


def run_counting(seeds: Sequence[int], *, workers: int, cluster: str | None) -> list[Counted]:
    """All scenes, in the order of the seeds; arguments as for `run_choosing`."""
    results = dict(run_all(count, seeds, workers=workers, cluster=cluster, batch=8))
    return [one for number in range(len(seeds)) for one in results[number]]


def counting_table(counted: Sequence[Counted]) -> Table:
    """By set of classes and kind of clutter: the share of scenes, with its 95 % interval."""
    names = ("scenes", "counted rightly [%]", "too many", "too few")
    table = Table("objects, scenes", *names)
    for of in SETS:
        for clutter in (*CLUTTER, "all"):
            group = [one for one in counted if one.of == of and clutter in (one.clutter, "all")]
            table.add_row(
                f"{of}, {clutter}",
                str(len(group)),
                percent([one.is_right for one in group]),
                str(sum(one.counted > one.objects for one in group)),
                str(sum(one.counted < one.objects for one in group)),
            )
    return table
