"""Household object classes: boxes, cans, mugs, hammers and the like."""

import numpy as np

from hw.sim.objects.making import MAX_HEIGHT, ObjectClass, Parts, box, disc, longest, part
from robots import Box, Capsule, Cylinder, Sphere


def _box(rng: np.random.Generator, width: float) -> Parts:
    length = rng.uniform(width, longest(width))
    height = rng.uniform(max(0.02, 0.5 * width), min(MAX_HEIGHT, max(0.04, 2.0 * width)))
    return [box(length, width, height)]


def _cylinder(rng: np.random.Generator, width: float) -> Parts:
    length = rng.uniform(max(1.2 * width, 0.05), longest(width))
    return [part(Cylinder(width / 2.0, length / 2.0), 0.0, 0.0, width / 2.0, lying=True)]


def _can(rng: np.random.Generator, width: float) -> Parts:
    height = rng.uniform(0.04, min(MAX_HEIGHT, 2.5 * width))
    return [disc(width / 2.0, height)]


def _ball(_: np.random.Generator, width: float) -> Parts:
    return [part(Sphere(width / 2.0), 0.0, 0.0, width / 2.0)]


def _capsule(rng: np.random.Generator, width: float) -> Parts:
    length = rng.uniform(max(0.5 * width, 0.02), longest(width) - width)
    return [part(Capsule(width / 2.0, length / 2.0), 0.0, 0.0, width / 2.0, lying=True)]


def _mug(rng: np.random.Generator, width: float) -> Parts:
    """`width` is that of its handle."""
    radius, height = rng.uniform(0.02, 0.03), rng.uniform(0.06, 0.09)
    handle = Box((0.016, width / 2.0, 0.35 * height))
    return [disc(radius, height), part(handle, radius + 0.012, 0.0, height / 2.0)]


def _hammer(rng: np.random.Generator, width: float) -> Parts:
    length = rng.uniform(0.09, 0.12)
    thick = rng.uniform(0.5, 0.8) * width
    head = Box((thick, rng.uniform(0.03, 0.04), rng.uniform(0.6, 0.8) * width))
    return [
        part(Cylinder(width / 2.0, length / 2.0), 0.0, 0.0, width / 2.0, lying=True),
        part(head, length / 2.0, 0.0, head.half[2]),
    ]


def _screwdriver(rng: np.random.Generator, width: float) -> Parts:
    """`width` is that of its shaft."""
    handle = Capsule(rng.uniform(0.65, 0.8) * width, 0.03)
    shaft = Cylinder(width / 2.0, rng.uniform(0.02, 0.03))
    reach = handle.half_length + handle.radius + shaft.half_length
    return [
        part(handle, 0.0, 0.0, handle.radius, lying=True),
        part(shaft, 0.95 * reach, 0.0, handle.radius, lying=True),
    ]


def _corner(rng: np.random.Generator, width: float) -> Parts:
    height = rng.uniform(0.025, 0.05)
    a, b = rng.uniform(0.07, 0.11), rng.uniform(0.06, 0.09)
    half = width / 2.0
    return [
        box(a, 2.0 * half, height, a / 2.0 - half, 0.0),
        box(2.0 * half, b, height, 0.0, b / 2.0 - half),
    ]


def _tee(rng: np.random.Generator, width: float) -> Parts:
    height = rng.uniform(0.025, 0.05)
    stem, bar = rng.uniform(0.06, 0.09), rng.uniform(0.08, 0.11)
    half = width / 2.0
    return [box(stem, 2.0 * half, height, stem / 2.0 - half, 0.0), box(2.0 * half, bar, height)]


def _dumbbell(rng: np.random.Generator, width: float) -> Parts:
    end = width / 2.0 + rng.uniform(0.005, 0.012)
    half_length = rng.uniform(0.03, 0.04)
    return [
        part(Cylinder(width / 2.0, half_length), 0.0, 0.0, end, lying=True),
        part(Sphere(end), half_length, 0.0, end),
        part(Sphere(end), -half_length, 0.0, end),
    ]


HOUSEHOLD: dict[str, ObjectClass] = {
    "box": ObjectClass(make=_box),
    "cylinder": ObjectClass(make=_cylinder),
    "can": ObjectClass(make=_can, narrowest=0.025),
    "ball": ObjectClass(make=_ball, narrowest=0.025),
    "capsule": ObjectClass(make=_capsule, widest=0.05),
    "mug": ObjectClass(make=_mug, widest=0.025),
    "hammer": ObjectClass(make=_hammer, widest=0.03),
    "screwdriver": ObjectClass(make=_screwdriver, widest=0.03),
    "corner": ObjectClass(make=_corner, widest=0.035),
    "tee": ObjectClass(make=_tee, widest=0.035),
    "dumbbell": ObjectClass(make=_dumbbell, widest=0.03),
}
