"""What two pads can carry: forces at their contacts, within friction, that balance the weight.

An object stays in the hand if the contacts can balance its weight, turning included, by forces that
lie in their friction cones and press together as hard as the fingers do. Where such forces exist is
the test of force closure of a grip of limited force, a linear programme with the cones cut into
edges (Kerr and Roth, "Analysis of multifingered hands", IJRR 1986; Ferrari and Canny, "Planning
optimal grasps", ICRA 1992). Pads resist to turning about their normals, too, as soft fingers do.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from robots import Array

Contact: TypeAlias = tuple[Array, Array]
"""(N, 3) points of a patch, and the (3,) unit normal from the pad to the object."""

GRAVITY = 9.81  # [m/s²]

TORSION = 0.005
"""Radius over which a contact resists to turning about its normal [m]: that of the physical world,
and of a pad's print with its edge of 17 mm (two thirds of its half)."""

_EDGES = 8  # Of a friction cone
_MOST = 50.0
_LENGTH = 0.02  # Torques are measured with this lever, so that they are as large as the forces [m]


def carried(
    sides: Sequence[Sequence[Contact]],
    axes: Sequence[Array],
    centre: Array,
    mass: float,
    friction: float,
    force: float,
) -> float | None:
    """How many times its weight a grip carries, at most 50.

    Args:
        sides: the contacts of each pad.
        axes: (3,) unit vector along which each finger presses.
        centre: (3,) of mass, in the world [m].
        mass: [kg].
        friction: Coulomb's coefficient.
        force: of each finger [N].

    Returns:
        None if the contacts cannot hold it without any weight, since they do not oppose each other.
    """
    from scipy.optimize import linprog  # slow to import

    columns = [
        np.array([*edge, *(np.cross(point - centre, edge) + twist) / _LENGTH, edge @ axis])
        for contacts, axis in zip(sides, axes, strict=True)
        for points, normal in contacts
        for edge in _cone(normal, friction)
        for point in points
        for twist in (TORSION * normal, -TORSION * normal)
    ]
    if not columns:
        return None
    weight = np.array([0.0, 0.0, -mass * GRAVITY, 0.0, 0.0, 0.0, 0.0])
    found = linprog(
        [*[0.0] * len(columns), -1.0],
        A_eq=np.column_stack([*columns, weight]),
        b_eq=[*[0.0] * 6, 2.0 * force],
        bounds=[*[(0.0, None)] * len(columns), (0.0, _MOST)],
    )
    return float(found.x[-1]) if found.status == 0 else None


def _cone(normal: Array, friction: float) -> Array:
    """(_EDGES, 3) edges of a friction cone."""
    across = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    across /= np.linalg.norm(across)
    angles = np.arange(_EDGES) * (2.0 * np.pi / _EDGES)
    around = np.outer(np.cos(angles), across) + np.outer(np.sin(angles), np.cross(normal, across))
    edges: Array = normal + friction * around
    return edges
