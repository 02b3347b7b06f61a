"""Held-out object classes for the evaluation of grasps."""

from math import cos, pi, sin, tan

import numpy as np

from hw.sim.objects import ObjectClass, Parts, box, disc, part
from robots import Box, Capsule, Cylinder, Sphere


def _lying_bottle(rng: np.random.Generator, width: float) -> Parts:
    radius, half, neck = width / 2.0, rng.uniform(0.03, 0.042), rng.uniform(0.008, 0.012)
    return [
        part(Cylinder(radius, half), 0.0, 0.0, radius, lying=True),
        part(Cylinder(0.7 * radius, 0.006), half + 0.006, 0.0, radius, lying=True),
        part(Cylinder(neck, 0.012), half + 0.022, 0.0, radius, lying=True),
    ]


def _standing_bottle(rng: np.random.Generator, width: float) -> Parts:
    """`width` is that of its body."""
    radius, height, neck = width / 2.0, rng.uniform(0.045, 0.07), rng.uniform(0.009, 0.013)
    return [
        disc(radius, height),
        disc(0.75 * radius, 0.008, z=height),
        part(Cylinder(neck, 0.013), 0.0, 0.0, height + 0.020),
    ]


def _cross(rng: np.random.Generator, width: float) -> Parts:
    height = rng.uniform(0.02, 0.045)
    a, b = rng.uniform(0.035, 0.055, 2)
    return [box(2.0 * a, width, height), box(width, 2.0 * b, height)]


def _horseshoe(rng: np.random.Generator, width: float) -> Parts:
    height, back, arm = rng.uniform(0.02, 0.045), rng.uniform(0.05, 0.065), rng.uniform(0.05, 0.08)
    half = width / 2.0
    side = Box((arm / 2.0, half, height / 2.0))
    return [
        box(2.0 * half, back, height),
        part(side, arm / 2.0 - half, back / 2.0 - half, height / 2.0),
        part(side, arm / 2.0 - half, half - back / 2.0, height / 2.0),
    ]


def _banana(rng: np.random.Generator, width: float) -> Parts:
    """Seven rods along an arc, thinner towards the ends."""
    radius, bend, whole = rng.uniform(0.05, 0.09), rng.uniform(1.0, 1.6), width / 2.0
    half = radius * bend / 12.0
    parts = []
    for angle in np.linspace(-0.5, 0.5, 7) * bend:
        thin = whole * (1.0 - 0.35 * (2.0 * angle / bend) ** 2)
        x, y = radius * sin(angle), radius * (1.0 - cos(angle))
        parts.append(part(Capsule(thin, half), x, y, thin, lying=True, yaw=float(angle)))
    return parts


def _spray_bottle(rng: np.random.Generator, width: float) -> Parts:
    """Standing; `width` is that of its body."""
    radius, height = width / 2.0, rng.uniform(0.045, 0.06)
    head = Box((rng.uniform(0.02, 0.028), 0.009, 0.009))
    return [
        disc(radius, height),
        disc(0.5 * radius, 0.02, z=height),
        part(head, 0.010, 0.0, height + 0.029),
    ]


def _wrench(rng: np.random.Generator, width: float) -> Parts:
    """`width` is that of its shaft."""
    height, half = rng.uniform(0.014, 0.022), rng.uniform(0.035, 0.05)
    jaw = Box((0.011, 0.006, height / 2.0))
    return [
        box(2.0 * half, width, height),
        disc(width / 2.0 + 0.006, height, -half),
        box(0.012, 0.034, height, half),
        *(part(jaw, half + 0.016, side * 0.012, height / 2.0) for side in (-1.0, 1.0)),
    ]


def _cup(rng: np.random.Generator, width: float) -> Parts:
    """Open at the top, with a handle; `width` is that of its wall."""
    sides, height = 20, rng.uniform(0.05, 0.08)
    radius = width / 2.0 + rng.uniform(0.028, 0.036)
    half = (radius + width / 2.0) * tan(pi / sides)
    wall = Box((width / 2.0, half, height / 2.0))
    handle = Box((0.012, 0.006, 0.3 * height))
    return [
        *(
            part(wall, radius * cos(a), radius * sin(a), height / 2.0, yaw=a)
            for a in np.arange(sides) * 2.0 * pi / sides
        ),
        disc(radius, 0.006),
        part(handle, radius + width / 2.0 + 0.011, 0.0, height / 2.0),
    ]


def _scissors(rng: np.random.Generator, width: float) -> Parts:
    """Two crossed blades with grips; `width` is that of a blade."""
    opening, half, thick = rng.uniform(0.25, 0.6), rng.uniform(0.05, 0.06), rng.uniform(0.014, 0.02)
    blade = Box((half, width / 2.0, thick / 2.0))
    grip = Cylinder(0.014, thick / 2.0)
    parts = []
    for turn in (-opening, opening):
        x, y = -(half + 0.010) * cos(turn), -(half + 0.010) * sin(turn)
        parts += [part(blade, 0.0, 0.0, thick / 2.0, yaw=turn), part(grip, x, y, thick / 2.0)]
    return parts


def _aeroplane(rng: np.random.Generator, width: float) -> Parts:
    """`width` is that of its fuselage."""
    half, radius = rng.uniform(0.04, 0.05), width / 2.0
    wing = Box((0.014, rng.uniform(0.045, 0.06), 0.005))
    return [
        part(Capsule(radius, half), 0.0, 0.0, radius, lying=True),
        part(wing, 0.012, 0.0, radius),
        part(Box((0.008, 0.022, 0.004)), -half, 0.0, radius),
        part(Box((0.010, 0.004, 0.010)), -half, 0.0, 2.0 * radius + 0.006),
    ]


def _pan(rng: np.random.Generator, width: float) -> Parts:
    """A flat disc with a handle; `width` is that of the handle."""
    radius, half = rng.uniform(0.036, 0.042), rng.uniform(0.025, 0.032)
    return [
        disc(radius, 0.024),
        part(Box((half, width / 2.0, 0.009)), radius + half - 0.004, 0.0, 0.015),
    ]


def _lamp(rng: np.random.Generator, width: float) -> Parts:
    """A pocket lamp, lying; `width` is that of its tube."""
    head, half = width / 2.0 + rng.uniform(0.004, 0.010), rng.uniform(0.03, 0.045)
    return [
        part(Cylinder(width / 2.0, half), 0.0, 0.0, head, lying=True),
        part(Cylinder(head, 0.014), half + 0.010, 0.0, head, lying=True),
    ]


def _animal(rng: np.random.Generator, width: float) -> Parts:
    """A toy on four legs; `width` is that of its body."""
    leg, half, radius = rng.uniform(0.015, 0.028), rng.uniform(0.018, 0.03), width / 2.0
    foot = Cylinder(0.006, leg / 2.0 + 0.004)
    return [
        part(Capsule(radius, half), 0.0, 0.0, leg + radius, lying=True),
        part(Sphere(0.7 * radius + 0.004), half + radius, 0.0, leg + 1.7 * radius),
        *(
            part(foot, a * half, b * 0.6 * radius, leg / 2.0 + 0.004)
            for a in (-1.0, 1.0)
            for b in (-1.0, 1.0)
        ),
    ]


def _key(rng: np.random.Generator, width: float) -> Parts:
    """A large key; `width` is that of its shaft."""
    thick, half = rng.uniform(0.014, 0.02), rng.uniform(0.03, 0.04)
    tooth = Box((0.005, 0.008, thick / 2.0))
    return [
        box(2.0 * half, width, thick),
        disc(rng.uniform(0.016, 0.022), thick, -half - 0.012),
        *(part(tooth, half - x, width / 2.0 + 0.006, thick / 2.0) for x in (0.005, 0.020)),
    ]


HELDOUT: dict[str, ObjectClass] = {
    "lying bottle": ObjectClass(make=_lying_bottle, narrowest=0.03, widest=0.06),
    "standing bottle": ObjectClass(make=_standing_bottle, narrowest=0.035, widest=0.06),
    "cross": ObjectClass(make=_cross, widest=0.03),
    "horseshoe": ObjectClass(make=_horseshoe, narrowest=0.012, widest=0.02),
    "banana": ObjectClass(make=_banana, narrowest=0.02, widest=0.038),
    "spray bottle": ObjectClass(make=_spray_bottle, narrowest=0.035, widest=0.055),
    "wrench": ObjectClass(make=_wrench, narrowest=0.012, widest=0.022),
    "cup": ObjectClass(make=_cup, narrowest=0.006, widest=0.010),
    "scissors": ObjectClass(make=_scissors, narrowest=0.010, widest=0.016),
    "aeroplane": ObjectClass(make=_aeroplane, narrowest=0.016, widest=0.03),
    "pan": ObjectClass(make=_pan, narrowest=0.012, widest=0.02),
    "lamp": ObjectClass(make=_lamp, narrowest=0.02, widest=0.04),
    "animal": ObjectClass(make=_animal, narrowest=0.025, widest=0.045),
    "key": ObjectClass(make=_key, narrowest=0.012, widest=0.02),
}
"""Never trained on."""
