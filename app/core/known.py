"""What the robot is told of its surroundings: a map, and a tracker of what moves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from controller import Obstacle
from hw import Truth
from robots import Geom, Plane


class Known(NamedTuple):
    """What stands around the robot, as far as it is told."""

    fixtures: tuple[Geom, ...] = ()
    """What never moves, in the world; not the floor, which the controller knows by itself."""
    obstacles: Callable[[float], Sequence[Obstacle]] = lambda stamp: ()
    """What moves by itself at a time on the session's clock [s]."""


def known_of(truth: Truth | None, site: Path | str | None = None) -> Known:
    """The map of a site, or that of a simulated world; and its walkers, as a tracker would tell.

    Args:
        truth: what a simulated world knows; None on hardware.
        site: a scene file that says what stands around; None for the world's own map.

    Raises:
        SceneError: there is no such file, or it has a mistake.
    """
    if site is not None:
        from hw.sim import load_fixtures

        fixtures: Sequence[Geom] = load_fixtures(site)
    else:
        fixtures = truth.mapped if truth else ()
    solid = tuple(one for one in fixtures if not isinstance(one.shape, Plane))
    return Known(solid, lambda stamp: truth.moving() if truth else ())


def known_then(scene: str, seed: int, site: Path | None) -> Known:
    """What was known in a run that is over: a scene is the same every time.

    Raises:
        SceneError: there is no such scene or map any more, or it has a mistake.
    """
    from hw.sim import load_scene

    world = load_scene(scene, seed)

    def obstacles(stamp: float) -> Sequence[Obstacle]:
        world.move_to(stamp)
        return world.moving()

    return known_of(world, site)._replace(obstacles=obstacles)
