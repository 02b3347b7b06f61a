"""Furniture: upright boxes and cylinders with names."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config.arrays import Array
from config.poses import MapPose
from robots import Box, Cylinder, Geom

TABLE_HEIGHT = (0.68, 0.78)  # of table tops [m]

_BOARD = 0.02  # thickness of boards [m]
_TOP = 0.04  # thickness of a table's top [m]
_LEG = 0.05  # width of a table's legs [m]
_WALL = 0.10  # thickness of a wall [m]
_WALL_HEIGHT = 2.2


def pose(place: Array, heading: float, z: float = 0.0) -> SE3:
    """An upright pose at (2,) x, y [m] and a heading [rad]."""
    return SE3(pin.utils.rotate("z", heading), np.array([*place, z]))


def box(name: str, size: Sequence[float] | Array, centre: Sequence[float] | Array) -> Geom:
    """A box by edge lengths and centre [m]."""
    a, b, c = (0.5 * float(edge) for edge in size)
    return Geom(Box((a, b, c)), SE3(np.eye(3), np.array(centre, float)), name)


def column(name: str, radius: float, height: float) -> Geom:
    """A cylinder that stands on the floor [m]."""
    centre = SE3(np.eye(3), np.array([0.0, 0.0, height / 2.0]))
    return Geom(Cylinder(radius, height / 2.0), centre, name)


def table(name: str, length: float, width: float, height: float) -> list[Geom]:
    """A top on four legs, its length along y [m]."""
    parts = [box(f"{name} top", (width, length, _TOP), (0.0, 0.0, height - _TOP / 2.0))]
    x, y, leg = width / 2.0 - _LEG, length / 2.0 - _LEG, height - _TOP
    for number, (i, k) in enumerate(((1, 1), (1, -1), (-1, 1), (-1, -1)), start=1):
        parts.append(box(f"{name} leg{number}", (_LEG, _LEG, leg), (i * x, k * y, leg / 2.0)))
    return parts


def shelf(name: str, width: float, depth: float, boards: Sequence[float]) -> list[Geom]:
    """Boards at heights between two sides, before a back; open towards -x, width along y [m]."""
    height = boards[-1] + _BOARD
    parts = [
        box(f"{name} board{number}", (depth, width, _BOARD), (0.0, 0.0, z + _BOARD / 2.0))
        for number, z in enumerate(boards, start=1)
    ]
    for side, y in (("left", width / 2.0), ("right", -width / 2.0)):
        size = (depth, _BOARD, height)
        parts.append(box(f"{name} {side} side", size, (0.0, y, height / 2.0)))
    back = (_BOARD, width, height)
    parts.append(box(f"{name} back", back, (depth / 2.0 + _BOARD / 2.0, 0.0, height / 2.0)))
    return parts


def walls(low: Array, high: Array) -> list[Geom]:
    """Four walls around a rectangle between two corners (2,) [m]."""
    centre, size = (low + high) / 2.0, high - low
    z = _WALL_HEIGHT / 2.0
    parts = []
    for number, axis in enumerate((0, 0, 1, 1), start=1):
        edges = np.array([*(size + 2.0 * _WALL), _WALL_HEIGHT])
        edges[axis] = _WALL
        place = np.array([*centre, z])
        outside = size[axis] / 2.0 + _WALL / 2.0
        place[axis] += outside if number % 2 else -outside
        parts.append(box(f"wall{number}", edges, place))
    return parts


def random_furniture(name: str, rng: np.random.Generator) -> list[Geom]:
    """A box, a table or a column on the floor."""
    match rng.integers(3):
        case 0:
            size = rng.uniform((0.3, 0.3, 0.3), (1.0, 0.8, 1.2))
            return [box(f"{name} box", size, (0.0, 0.0, size[2] / 2.0))]
        case 1:
            length, width = rng.uniform((0.7, 0.6), (1.5, 0.9))
            return table(f"{name} table", length, width, rng.uniform(*TABLE_HEIGHT))
        case _:
            radius, height = rng.uniform(0.05, 0.25), rng.choice([0.5, 1.0, 2.2])
            return [column(f"{name} column", float(radius), float(height))]


def random_object(name: str, rng: np.random.Generator) -> Geom:
    """A small box, can or bottle on the plane z = 0."""
    if rng.random() < 0.5:
        size = rng.uniform((0.06, 0.06, 0.05), (0.20, 0.20, 0.25))
        return box(name, size, (0.0, 0.0, size[2] / 2.0))
    return column(name, float(rng.uniform(0.03, 0.06)), float(rng.uniform(0.08, 0.30)))


def placed(parts: Sequence[Geom], mTs: MapPose) -> list[Geom]:
    """The parts of one piece, in the world."""
    return [part.moved(mTs) for part in parts]
