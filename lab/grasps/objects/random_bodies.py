"""Random bodies, turned, hollow, bent and cut, for training."""

import numpy as np
from pinocchio import SE3, exp3

from hw.sim.objects import (
    SIDES,
    Maker,
    ObjectClass,
    Parts,
    corners_of,
    cut_out,
    hollow,
    lying,
    swept,
    turned,
    turned_over,
)
from robots import Array, hull_of


def _profile(rng: np.random.Generator, widest: float, height: float) -> list[tuple[float, float]]:
    """A random outline of a turned body; its largest radius is half of `widest`."""
    count = int(rng.integers(2, 6))
    heights = height * np.sort([0.0, 1.0, *(0.1 + 0.8 * rng.random(count - 2))])
    heights += 1e-3 * np.arange(count)  # no two at one height
    radii = rng.uniform(0.35, 1.0, count)
    radii *= widest / 2.0 / radii.max()
    return [(float(h), float(r)) for h, r in zip(heights, radii, strict=True)]


def _lathe(rng: np.random.Generator, width: float) -> Parts:
    """A solid of revolution, standing or lying."""
    height = rng.uniform(0.02, 0.1)
    if rng.random() < 0.5:
        return turned(_profile(rng, width, height))
    return lying(turned(_profile(rng, width, 1.6 * height)))


def _vessel(rng: np.random.Generator, width: float) -> Parts:
    """Hollow, with a thin wall, of any profile, now and then with a grip; `width` is the outer."""
    height, wall = rng.uniform(0.02, 0.1), rng.uniform(0.002, 0.006)
    outer = width * rng.uniform(1.0, 2.0)
    foot, rim = rng.uniform(0.5, 1.0, 2)
    largest = outer / 2.0 / max(foot, rim)
    middle = (rng.uniform(0.3, 0.7) * height, largest * rng.uniform(min(foot, rim), 1.0))
    profile = [(0.0, foot * largest), middle, (height, rim * largest)]
    parts = hollow(profile, wall, int(rng.choice((SIDES // 2, SIDES))))
    if rng.random() < 0.3:
        bend = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 5)
        out = middle[1] - 0.004 + rng.uniform(0.015, 0.05) * np.cos(bend)
        up = height * (0.5 + 0.35 * np.sin(bend))
        path = np.stack([out, 0.0 * bend, up], axis=1)
        parts += swept(path, rng.uniform(0.008, 0.02), rng.uniform(0.006, 0.012))
    return parts


def _bent_bar(rng: np.random.Generator, width: float) -> Parts:
    """A bar along a bent line, lying flat."""
    length, turn = rng.uniform(0.08, 0.2), rng.uniform(-2.5, 2.5, 2)
    at = np.linspace(0.0, 1.0, 7)
    heading = turn[0] * at + turn[1] * at**2
    path = np.zeros((len(at), 3))
    steps = length / (len(at) - 1) * np.stack([np.cos(heading), 0.0 * at, np.sin(heading)], axis=1)
    path[1:] = np.cumsum(0.5 * (steps[1:] + steps[:-1]), axis=0)
    thick = rng.uniform(0.012, 0.03)
    return turned_over(swept(path, thick, width), np.array([np.pi / 2.0, 0.0, 0.0]))


def _cut_plates(rng: np.random.Generator, width: float) -> Parts:
    """One to three plates with convex outlines, beside and on each other."""
    parts: Parts = []
    for _ in range(int(rng.integers(1, 4))):
        corners = int(rng.integers(3, 8))
        angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, corners))
        size = width * np.array([rng.uniform(0.6, 2.2), rng.uniform(0.5, 1.0)])
        outline = 0.5 * size * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        outline = outline @ _turn(rng).T + (rng.uniform(-0.5, 0.5, 2) * width if parts else 0.0)
        low = 0.0 if not parts or rng.random() < 0.5 else rng.uniform(0.0, 0.015)
        try:
            plate = cut_out([(x, y) for x, y in outline], low, low + rng.uniform(0.012, 0.05))
        except ValueError:
            continue
        parts.append(plate)
    return parts or turned([(0.0, width / 2.0), (0.03, width / 2.0)])


def _stone(rng: np.random.Generator, width: float) -> Parts:
    points = rng.standard_normal((int(rng.integers(6, 24)), 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    points *= 0.5 * width * np.array([rng.uniform(1.0, 2.0), 1.0, rng.uniform(0.5, 1.2)])
    return [hull_of(points - [0.0, 0.0, points[:, 2].min()])]


def _tool(rng: np.random.Generator, width: float) -> Parts:
    """A turned grip with something at one of its ends."""
    grip = lying(turned(_profile(rng, width, rng.uniform(0.06, 0.14))))
    end = (_stone, _lathe, _cut_plates)[int(rng.integers(3))](rng, width * rng.uniform(0.8, 2.0))
    away = SE3(exp3(np.array([0.0, 0.0, rng.uniform(-np.pi, np.pi)])), np.zeros(3))
    return [*grip, *(part.moved(away) for part in end)]


def _turn(rng: np.random.Generator) -> Array:
    angle = rng.uniform(-np.pi, np.pi)
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def _on_the_ground(make: Maker) -> Maker:
    """The same bodies with their lowest point on the ground."""

    def moved(rng: np.random.Generator, width: float) -> Parts:
        parts = make(rng, width)
        low = min(float(corners_of(part)[:, 2].min()) for part in parts)
        down = SE3(np.eye(3), np.array([0.0, 0.0, -low]))
        return [part.moved(down) for part in parts]

    return moved


RANDOM_BODIES: dict[str, ObjectClass] = {
    "lathe": ObjectClass(make=_on_the_ground(_lathe), narrowest=0.02, widest=0.09),
    "vessel": ObjectClass(make=_on_the_ground(_vessel), narrowest=0.03, widest=0.08),
    "bent bar": ObjectClass(make=_on_the_ground(_bent_bar), narrowest=0.01, widest=0.04),
    "plates": ObjectClass(make=_on_the_ground(_cut_plates), narrowest=0.02, widest=0.07),
    "stone": ObjectClass(make=_on_the_ground(_stone), narrowest=0.02, widest=0.07),
    "tool": ObjectClass(make=_on_the_ground(_tool), narrowest=0.012, widest=0.035),
}
