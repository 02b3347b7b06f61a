"""The objects that a scene file names one by one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from pinocchio import SE3

from hw.sim.furniture import Item, Objects
from hw.sim.meshes import convex_parts, fewer
from hw.sim.objects import DENSITY, FRICTION, OBJECT_CLASSES, PAINT, PALETTE, fitting, make_object
from hw.sim.sim_object import SimObject
from hw.sim.surface import Mesh
from robots import Geom, centroid, volume


def make_item(item: Item, number: int, others: Objects, rng: np.random.Generator) -> SimObject:
    """One object, resting on z = 0 with its centre of mass above the origin.

    Args:
        item: what the scene file says of it.
        number: of the object.
        others: the ranges from which masses and widths are drawn.
        rng: where the randomness comes from.

    Raises:
        MeshError: its mesh cannot be split into convex parts.
    """
    low, high = others.mass_g[0] / 1000.0, others.mass_g[1] / 1000.0
    if item.kind is not None:
        of_kind = OBJECT_CLASSES[item.kind]
        widths = (others.width_mm[0] / 1000.0, others.width_mm[1] / 1000.0)
        if not fitting(OBJECT_CLASSES, [item.kind], widths):
            widths = (of_kind.narrowest, of_kind.widest)
        made = make_object(f"{item.kind} {number}", of_kind, widths, (low, high), rng)
    else:
        made = _of_mesh(item, number, (low, high), rng)
    if item.colour is not None:
        paint = PAINT[item.colour]
        made = replace(made, parts=tuple(Geom(p.shape, p.pose, p.name, paint) for p in made.parts))
    return replace(
        made,
        mass=made.mass if item.mass_g is None else item.mass_g / 1000.0,
        friction=made.friction if item.friction is None else item.friction,
    )


def _of_mesh(
    item: Item, number: int, masses: tuple[float, float], rng: np.random.Generator
) -> SimObject:
    assert item.mesh is not None
    mesh = item.read()
    parts = convex_parts(mesh, Path(item.mesh).name)
    volumes = np.array([volume(part.shape) for part in parts])
    centre = volumes @ [part.pose.act(centroid(part.shape)) for part in parts] / volumes.sum()
    name = f"{Path(item.mesh).stem[:40]} {number}"
    colour = PALETTE[rng.integers(len(PALETTE))]
    drawn = fewer(mesh)
    made = SimObject(
        name=name,
        parts=tuple(
            Geom(part.shape, SE3(np.eye(3), part.pose.translation - centre), name, colour)
            for part in parts
        ),
        mass=float(np.clip(volumes.sum() * rng.uniform(*DENSITY), *masses)),
        friction=rng.uniform(*FRICTION),
        pose=SE3.Identity(),
        mesh=Mesh(drawn.vertices - centre, drawn.triangles, drawn.closed),
    )
    made.pose = SE3(np.eye(3), np.array([0.0, 0.0, made.reach(np.array([0.0, 0.0, -1.0]))]))
    return made
