"""What people do to objects meanwhile; needs a world that can be interfered with."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
from pinocchio import SE3

from hw.faults.effect import Effect, Site
from hw.truth import DisturbableWorld

OUTSIDE = np.array([-8.0, -8.0, 0.5])
"""Where objects are taken: far from everything, from where they fall to the floor [m]."""

_TRIES = 24  # Directions in which an object is tried to be moved without leaving what carries it

_AWAY = ("", "floor")


class _ObjectFault(Effect):
    """Concerns one object at random that is not lost already."""

    def begin(self, site: Site) -> None:
        """Choose the object."""
        super().begin(site)
        if site.world is None:
            return
        supports = site.world.supports()
        candidates = [one for one in site.world.objects if supports[one.name] not in _AWAY]
        if candidates:
            chosen = candidates[int(site.rng.integers(len(candidates)))]
            self.disturb(site.world, chosen.name, chosen.pose, supports[chosen.name])

    def disturb(self, world: DisturbableWorld, name: str, wTo: SE3, support: str) -> None:
        """Do it.

        Args:
            world: where.
            name: of the object.
            wTo: where the object is.
            support: what carries it.
        """
        raise NotImplementedError


class ObjectMoved(_ObjectFault):
    """Someone pushes an object aside, without pushing it down; a held one slips out of the hand.

    Args:
        distance: how far [m].
    """

    def __init__(self, distance: float) -> None:
        self._distance = distance

    def disturb(self, world: DisturbableWorld, name: str, wTo: SE3, support: str) -> None:
        """Once, when it begins."""
        if support == "hand":
            world.put(name, wTo)
            return
        for _ in range(_TRIES):
            towards = self.site.rng.uniform(-pi, pi)
            aside = self._distance * np.array([cos(towards), sin(towards), 0.0])
            world.put(name, SE3(wTo.rotation, wTo.translation + aside))
            if world.supports()[name] == support:
                return
        world.put(name, wTo)


class ObjectTaken(_ObjectFault):
    """Someone takes an object away, out of the hand too, and brings it back when it is cleared."""

    _taken: tuple[str, SE3] | None = None

    def disturb(self, world: DisturbableWorld, name: str, wTo: SE3, support: str) -> None:
        """Once, when it begins."""
        self._taken = name, self.site.homes[name] if support == "hand" else wTo
        world.put(name, SE3(wTo.rotation, OUTSIDE))

    def end(self) -> None:
        """Bring it back to where it was; one from the hand to where it was to begin with."""
        if self._taken is not None and self.site.world is not None:
            self.site.world.put(*self._taken)
