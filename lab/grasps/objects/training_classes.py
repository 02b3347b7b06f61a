"""Object classes for training only: rings, stairs, beams, toys, and random compositions."""

from math import cos, pi, sin, sqrt, tan

import numpy as np

from hw.sim.objects import MAX_HEIGHT, ObjectClass, Parts, box, disc, longest, part
from robots import Box, Capsule, Cylinder, Sphere


def _plate(rng: np.random.Generator, width: float) -> Parts:
    length, height = rng.uniform(width, longest(width)), rng.uniform(0.012, 0.022)
    return [box(length, width, height)]


def _disc(rng: np.random.Generator, width: float) -> Parts:
    height = rng.uniform(0.012, 0.035)
    return [disc(width / 2.0, height)]


def _hexagon(rng: np.random.Generator, width: float) -> Parts:
    """A regular hexagon is three rectangles, each turned by 60 degrees."""
    height = rng.uniform(0.015, min(MAX_HEIGHT, 1.5 * width + 0.02))
    slab = Box((width / (2.0 * sqrt(3.0)), width / 2.0, height / 2.0))
    return [part(slab, 0.0, 0.0, height / 2.0, yaw=i * pi / 3.0) for i in range(3)]


def _stack(rng: np.random.Generator, width: float) -> Parts:
    """A smaller box on a larger one; `width` is that of the smaller."""
    low, high = rng.uniform(0.02, 0.04), rng.uniform(0.02, 0.04)
    length = rng.uniform(width, 1.8 * width)
    base = Box((length / 2.0 + rng.uniform(0.005, 0.02), width / 2.0 + 0.012, low / 2.0))
    return [part(base, 0.0, 0.0, low / 2.0), box(length, width, high, z=low)]


def _pyramid(rng: np.random.Generator, width: float) -> Parts:
    """Three storeys; `width` is that of the topmost."""
    storey, step = rng.uniform(0.015, 0.03), rng.uniform(0.004, 0.010)
    return [
        part(
            Box((width / 2.0 + (2 - i) * step,) * 2 + (storey / 2.0,)), 0.0, 0.0, (i + 0.5) * storey
        )
        for i in range(3)
    ]


def _peg(rng: np.random.Generator, width: float) -> Parts:
    foot, height = rng.uniform(0.008, 0.016), rng.uniform(0.03, 0.07)
    radius = width / 2.0 + rng.uniform(0.008, 0.02)
    return [disc(radius, foot), disc(width / 2.0, height, z=foot)]


def _tapered(rng: np.random.Generator, width: float) -> Parts:
    """A cone in four steps, upright or upside down."""
    storey = rng.uniform(0.010, 0.022)
    radii = width / 2.0 * (1.0 - rng.uniform(0.05, 0.12) * np.arange(4))
    if rng.random() < 0.5:
        radii = radii[::-1]
    return [
        part(Cylinder(float(r), storey / 2.0), 0.0, 0.0, (i + 0.5) * storey)
        for i, r in enumerate(radii)
    ]


def _jar(rng: np.random.Generator, width: float) -> Parts:
    """A cylinder under a lid that is wider or narrower; `width` is that of the wider."""
    height, lid = rng.uniform(0.03, 0.07), rng.uniform(0.010, 0.02)
    other = width / 2.0 - rng.uniform(0.003, 0.008)
    body, top = (width / 2.0, other) if rng.random() < 0.5 else (other, width / 2.0)
    return [disc(body, height), disc(top, lid, z=height)]


def _ring(rng: np.random.Generator, width: float) -> Parts:
    """A hollow polygon; `width` is that of its wall."""
    sides = int(rng.choice((5, 6, 8, 14, 16)))
    radius = width / 2.0 + rng.uniform(0.026, 0.035)
    height = rng.uniform(0.02, 0.05)
    half = (radius + width / 2.0) * tan(pi / sides)
    wall = Box((width / 2.0, half, height / 2.0))
    return [
        part(wall, radius * cos(a), radius * sin(a), height / 2.0, yaw=a)
        for a in np.arange(sides) * 2.0 * pi / sides
    ]


def _stairs(rng: np.random.Generator, width: float) -> Parts:
    steps = int(rng.integers(2, 5))
    deep, rise = rng.uniform(0.018, 0.03), rng.uniform(0.012, 0.022)
    return [box(deep, width, (i + 1) * rise, (i - (steps - 1) / 2.0) * deep) for i in range(steps)]


def _beam(rng: np.random.Generator, width: float) -> Parts:
    height, web = rng.uniform(0.02, 0.045), rng.uniform(0.05, 0.08)
    flange = Box((width / 2.0, rng.uniform(0.02, 0.045), height / 2.0))
    reach = web / 2.0 + width / 2.0
    return [
        box(web, width, height),
        part(flange, reach, 0.0, height / 2.0),
        part(flange, -reach, 0.0, height / 2.0),
    ]


def _zigzag(rng: np.random.Generator, width: float) -> Parts:
    height, arm = rng.uniform(0.02, 0.045), rng.uniform(0.03, 0.04)
    middle = rng.uniform(0.05, 0.08)
    half = width / 2.0
    return [
        box(2.0 * half, middle, height),
        box(2.0 * arm, 2.0 * half, height, arm - half, middle / 2.0 - half),
        box(2.0 * arm, 2.0 * half, height, half - arm, half - middle / 2.0),
    ]


def _tripod(rng: np.random.Generator, width: float) -> Parts:
    turns = np.cumsum(rng.uniform(1.6, 2.6, 3))
    parts = []
    for angle in turns:
        half = rng.uniform(0.022, 0.032)
        x, y = half * cos(angle), half * sin(angle)
        parts.append(part(Capsule(width / 2.0, half), x, y, width / 2.0, lying=True, yaw=angle))
    return parts


def _elbow(rng: np.random.Generator, width: float) -> Parts:
    bend = rng.uniform(0.4, 2.0)
    parts = []
    for angle in (0.0, pi - bend):
        half = rng.uniform(0.022, 0.036)
        x, y = half * cos(angle), half * sin(angle)
        parts.append(part(Capsule(width / 2.0, half), x, y, width / 2.0, lying=True, yaw=angle))
    return parts


def _lollipop(rng: np.random.Generator, width: float) -> Parts:
    """A ball on a stick, lying; `width` is that of the ball."""
    radius, stick, half = width / 2.0, rng.uniform(0.005, 0.008), rng.uniform(0.03, 0.045)
    return [
        part(Sphere(radius), 0.0, 0.0, radius),
        part(Cylinder(stick, half), radius + half - 0.004, 0.0, radius, lying=True),
    ]


def _spoon(rng: np.random.Generator, width: float) -> Parts:
    """`width` is that of its handle."""
    half, bowl = rng.uniform(0.03, 0.042), rng.uniform(0.018, 0.028)
    return [
        part(Capsule(width / 2.0, half), 0.0, 0.0, width / 2.0, lying=True),
        disc(bowl, 0.012, half + bowl, 0.0),
    ]


def _brush(rng: np.random.Generator, width: float) -> Parts:
    """A block with bristles at the end of a handle; `width` is that of the block."""
    length, height = rng.uniform(0.05, 0.08), rng.uniform(0.025, 0.045)
    grip, half = rng.uniform(0.007, 0.012), rng.uniform(0.02, 0.03)
    return [
        box(length, width, height),
        part(Capsule(grip, half), length / 2.0 + half, 0.0, height - grip, lying=True),
    ]


def _plug(rng: np.random.Generator, width: float) -> Parts:
    length, height = rng.uniform(0.035, 0.06), rng.uniform(0.025, 0.04)
    pin = Cylinder(0.003, 0.010)
    apart = min(0.3 * width, 0.01)
    return [
        box(length, width, height),
        *(
            part(pin, length / 2.0 + 0.009, side * apart, height / 2.0, lying=True)
            for side in (-1.0, 1.0)
        ),
    ]


def _toy_car(rng: np.random.Generator, width: float) -> Parts:
    length, body = rng.uniform(0.07, 0.10), rng.uniform(0.016, 0.024)
    wheel = rng.uniform(0.010, 0.014)
    cabin = rng.uniform(0.016, 0.026)
    wheels = Cylinder(wheel, width / 2.0)
    return [
        part(Box((length / 2.0, 0.45 * width, body / 2.0)), 0.0, 0.0, wheel + body / 2.0),
        part(
            Box((0.25 * length, 0.4 * width, cabin / 2.0)),
            rng.uniform(-0.2, 0.1) * length,
            0.0,
            wheel + body + cabin / 2.0,
        ),
        *(
            part(wheels, side * 0.32 * length, 0.0, wheel, lying=True, yaw=pi / 2.0)
            for side in (-1.0, 1.0)
        ),
    ]


def _bridge(rng: np.random.Generator, width: float) -> Parts:
    length, clear, slab = rng.uniform(0.06, 0.10), rng.uniform(0.02, 0.04), rng.uniform(0.015, 0.03)
    post = Box((0.008, width / 2.0, clear / 2.0))
    return [
        box(length, width, slab, z=clear),
        part(post, length / 2.0 - 0.008, 0.0, clear / 2.0),
        part(post, 0.008 - length / 2.0, 0.0, clear / 2.0),
    ]


def _basket(rng: np.random.Generator, width: float) -> Parts:
    """A box under a handle; `width` is that of the handle."""
    length, height = rng.uniform(0.06, 0.085), rng.uniform(0.025, 0.04)
    rise = rng.uniform(0.025, 0.04)
    post = Box((0.006, width / 2.0, rise / 2.0))
    bar = Box((length / 2.0, width / 2.0, 0.008))
    return [
        part(Box((length / 2.0, rng.uniform(0.025, 0.035), height / 2.0)), 0.0, 0.0, height / 2.0),
        part(post, length / 2.0 - 0.006, 0.0, height + rise / 2.0),
        part(post, 0.006 - length / 2.0, 0.0, height + rise / 2.0),
        part(bar, 0.0, 0.0, height + rise + 0.008),
    ]


def _caterpillar(rng: np.random.Generator, width: float) -> Parts:
    radius, count = width / 2.0, int(rng.integers(3, 6))
    bends = np.cumsum(rng.uniform(-0.5, 0.5, count))
    step = 1.4 * radius
    x, y = np.cumsum(step * np.cos(bends)), np.cumsum(step * np.sin(bends))
    return [
        part(Sphere(radius), float(a - x.mean()), float(b - y.mean()), radius)
        for a, b in zip(x, y, strict=True)
    ]


def _twins(rng: np.random.Generator, width: float) -> Parts:
    radius, height = width / 2.0, rng.uniform(0.03, 0.07)
    return [disc(radius, height, side * 0.9 * radius, 0.0) for side in (-1.0, 1.0)]


def _composed(rng: np.random.Generator, width: float) -> Parts:
    """Two to four parts about one place; the narrowest is as wide as `width`."""
    parts = []
    for _ in range(int(rng.integers(2, 5))):
        x, y = rng.uniform(-0.028, 0.028, 2)
        yaw, wide = rng.uniform(0.0, pi), width * rng.uniform(1.0, 1.3)
        long, height = rng.uniform(0.02, 0.04), rng.uniform(0.02, 0.06)
        match int(rng.integers(4)):
            case 0:
                shape = Box((long, wide / 2.0, height / 2.0))
                parts.append(part(shape, x, y, height / 2.0, yaw=yaw))
            case 1:
                parts.append(disc(wide / 2.0, height, x, y))
            case 2:
                parts.append(part(Sphere(wide / 2.0), x, y, wide / 2.0))
            case _:
                rod = Capsule(wide / 2.0, long)
                parts.append(part(rod, x, y, wide / 2.0, lying=True, yaw=yaw))
    return parts


TRAIN: dict[str, ObjectClass] = {
    "plate": ObjectClass(make=_plate, narrowest=0.025),
    "disc": ObjectClass(make=_disc, narrowest=0.025),
    "hexagon": ObjectClass(make=_hexagon, narrowest=0.02),
    "stack": ObjectClass(make=_stack, widest=0.05),
    "pyramid": ObjectClass(make=_pyramid, widest=0.05),
    "peg": ObjectClass(make=_peg, widest=0.04),
    "tapered": ObjectClass(make=_tapered, narrowest=0.03),
    "jar": ObjectClass(make=_jar, narrowest=0.035, widest=0.068),
    "ring": ObjectClass(make=_ring, narrowest=0.008, widest=0.016),
    "stairs": ObjectClass(make=_stairs, narrowest=0.02, widest=0.06),
    "beam": ObjectClass(make=_beam, narrowest=0.012, widest=0.03),
    "zigzag": ObjectClass(make=_zigzag, narrowest=0.012, widest=0.03),
    "tripod": ObjectClass(make=_tripod, narrowest=0.018, widest=0.03),
    "elbow": ObjectClass(make=_elbow, narrowest=0.018, widest=0.04),
    "lollipop": ObjectClass(make=_lollipop, narrowest=0.03, widest=0.06),
    "spoon": ObjectClass(make=_spoon, narrowest=0.016, widest=0.028),
    "brush": ObjectClass(make=_brush, narrowest=0.025, widest=0.05),
    "plug": ObjectClass(make=_plug, narrowest=0.025, widest=0.05),
    "toy car": ObjectClass(make=_toy_car, narrowest=0.03, widest=0.05),
    "bridge": ObjectClass(make=_bridge, narrowest=0.02, widest=0.05),
    "basket": ObjectClass(make=_basket, narrowest=0.010, widest=0.02),
    "caterpillar": ObjectClass(make=_caterpillar, narrowest=0.025, widest=0.04),
    "twins": ObjectClass(make=_twins, narrowest=0.025, widest=0.04),
    "composed": ObjectClass(make=_composed, narrowest=0.015, widest=0.04),
}
