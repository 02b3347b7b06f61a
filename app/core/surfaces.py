"""Whether there is something to place on, where a task places: told before the run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import coal
import numpy as np

from behaviours import LEAVES, Region, slots
from controller import Array
from robots import Geom, coal_geometry
from trees.language import LeafNode, SubtreeNode, Task, nodes_below

_NEAR = 0.03
"""A surface this near to the floor of a region is the one that is meant [m]."""


def unsupported_places(task: Task, fixtures: Sequence[Geom]) -> list[str]:
    """Warnings about regions that a task places on, and that have no surface under their floor.

    Args:
        task: checked, its parameters with their values.
        fixtures: what stands in the scene, in the world.

    Returns:
        A text for each region; empty if all is well.
    """
    texts: dict[str, str] = {}
    for file, node in _places(task):
        usual = node.type.parameters["pitch_m"].default
        region, pitch = node.arguments["on"], node.arguments.get("pitch_m", usual)
        if not isinstance(region, Region) or not isinstance(pitch, int | float):
            continue  # known only while the task runs
        heights = [_distance(point, fixtures) for point in slots(region, pitch)]
        missing = sum(height > _NEAR for height in heights)
        if missing:
            where = f"{file.path.name}:{node.location.line}:{node.location.column}"
            texts[region.name] = (
                f"{where}: {missing} of the {len(heights)} places on `{region.name}` have no "
                f"surface of the scene under them; the nearest is {min(heights):.2f} m away"
            )
    return list(texts.values())


def _places(task: Task) -> Iterator[tuple[Task, LeafNode]]:
    """The nodes of a task and its subtrees that place something, and their files."""
    for node in nodes_below(task.root):
        if isinstance(node, SubtreeNode):
            yield from _places(node.task)
        elif isinstance(node, LeafNode) and node.type.behaviour is LEAVES["place"]:
            yield task, node


def _distance(point: Array, fixtures: Sequence[Geom]) -> float:
    """From a (3,) point to the nearest surface of a fixture, both in the world [m]."""
    ball, at = coal.Sphere(1e-4), coal.Transform3s(np.eye(3), point)
    request, nearest = coal.DistanceRequest(), float("inf")
    for fixture in fixtures:
        shape, pose = coal_geometry(fixture.shape), fixture.pose
        placed = coal.Transform3s(pose.rotation, pose.translation)
        gap = coal.distance(ball, at, shape, placed, request, coal.DistanceResult())
        nearest = min(nearest, abs(gap))
    return nearest
