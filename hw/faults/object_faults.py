"""Disturbances of objects by people; they need a world that can be disturbed."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
from pinocchio import SE3

from hw.faults.effect import Effect, Injectable, Site
from hw.truth import DisturbableWorld

_OUTSIDE = np.array([-8.0, -8.0, 0.5])  # where objects are taken [m]
_DISTANCE = 0.1  # [m]
_TRIES = 24  # directions that are tried so that a pushed object stays on its support


class _ObjectFault(Effect):
    """Affects one random object that is not lost already."""

    def begin(self, site: Site) -> None:
        super().begin(site)
        if site.world is None:
            return
        supports = site.world.supports()
        candidates = [one for one in site.world.objects if supports[one.name] not in ("", "floor")]
        if candidates:
            chosen = candidates[int(site.rng.integers(len(candidates)))]
            self.disturb(site.world, chosen.name, chosen.pose, supports[chosen.name])

    def disturb(self, world: DisturbableWorld, name: str, wTo: SE3, support: str) -> None:
        raise NotImplementedError


class _ObjectMoved(_ObjectFault):
    """An object is pushed aside on its support; a held one slips out of the hand."""

    def disturb(self, world: DisturbableWorld, name: str, wTo: SE3, support: str) -> None:
        if support == "hand":
            world.put(name, wTo)
            return
        for _ in range(_TRIES):
            towards = self.site.rng.uniform(-pi, pi)
            aside = _DISTANCE * np.array([cos(towards), sin(towards), 0.0])
            world.put(name, SE3(wTo.rotation, wTo.translation + aside))
            if world.supports()[name] == support:
                return
        world.put(name, wTo)


class _ObjectTaken(_ObjectFault):
    """An object is taken away, and brought back to its place when the fault is cleared."""

    _taken: tuple[str, SE3] | None = None

    def disturb(self, world: DisturbableWorld, name: str, wTo: SE3, support: str) -> None:
        self._taken = name, self.site.homes[name] if support == "hand" else wTo
        world.put(name, SE3(wTo.rotation, _OUTSIDE))

    def end(self) -> None:
        if self._taken is not None and self.site.world is not None:
            self.site.world.put(*self._taken)


OBJECT_FAULTS = (
    Injectable(
        "object moved",
        _ObjectMoved,
        "an object is pushed aside by 0.1 m; a held one is dropped",
        of_world=True,
    ),
    Injectable(
        "object taken",
        _ObjectTaken,
        "an object is taken away, out of the hand too, until the fault is cleared",
        of_world=True,
    ),
)
