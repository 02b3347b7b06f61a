"""World model of a run: the map and the moving obstacles that the robot is given."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from controller import Obstacle
from hw import Truth
from robots import Geom, Plane

_NOWHERE = ("", "hand", "floor")


class WorldModel(NamedTuple):
    """What the robot is given of its surroundings."""

    fixtures: tuple[Geom, ...] = ()  # static geometry in the world frame, without the floor
    obstacles: Callable[[float], Sequence[Obstacle]] = lambda stamp: ()
    """Moving obstacles at a time on the session's clock [s]."""


def load_world_model(truth: Truth | None, site: Path | str | None = None) -> WorldModel:
    """The map of a site, or that of a simulated world, and its moving obstacles.

    `site` is a scene file with the map; None takes the map of the simulated world. Raises
    SceneError: the file is missing or has a mistake.
    """
    if site is not None:
        from hw.sim import load_fixtures

        fixtures: Sequence[Geom] = load_fixtures(site)
    else:
        fixtures = truth.mapped if truth else ()
    solid = tuple(one for one in fixtures if not isinstance(one.shape, Plane))
    return WorldModel(solid, lambda stamp: truth.moving() if truth else ())


def recorded_world_model(scene: str | None, seed: int, site: Path | None) -> WorldModel:
    """The world model of a finished run, recomputed from its scene and seed if it has one.

    Raises SceneError: the scene or map is missing or has a mistake.
    """
    from hw.sim import load_scene

    if scene is None:
        return load_world_model(None, site)
    world = load_scene(scene, seed)

    def obstacles(stamp: float) -> Sequence[Obstacle]:
        world.move_to(stamp)
        return world.moving()

    return load_world_model(world, site)._replace(obstacles=obstacles)


def supports(truth: Truth | None) -> Mapping[str, str]:
    """Name of what carries each simulated object; empty on hardware."""
    return truth.supports() if truth else {}


def delivered(before: Mapping[str, str], after: Mapping[str, str]) -> int:
    """Number of objects that stand on other furniture, by `supports` at the beginning and end."""
    return sum(after[name] not in (*_NOWHERE, before[name]) for name in before)
