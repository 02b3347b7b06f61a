"""Object classes with curved, bent and hollow bodies; never trained on."""

import numpy as np
from pinocchio import SE3

from hw.sim.objects.making import ObjectClass, Parts
from hw.sim.objects.modelling import SIDES, cut_out, hollow, lying, swept, turned


def _bottle(rng: np.random.Generator, width: float) -> Parts:
    """Lying, with a shoulder, a neck and a rim."""
    r, length = width / 2.0, rng.uniform(0.12, 0.16)
    neck = rng.uniform(0.3, 0.4) * r
    body, top = rng.uniform(0.55, 0.65) * length, rng.uniform(0.75, 0.8) * length
    profile = [
        (0.0, 0.85 * r),
        (0.05 * length, r),
        (body, r),
        (0.5 * (body + top), 0.8 * r + 0.2 * neck),
        (top, neck),
        (0.92 * length, neck),
        (0.92 * length + 1e-4, 1.3 * neck),
        (length, 1.3 * neck),
    ]
    return lying(turned(profile))


def _flask(rng: np.random.Generator, width: float) -> Parts:
    """Standing, wide below; `width` is that of its neck."""
    neck, height = width / 2.0, rng.uniform(0.08, 0.11)
    foot = neck + rng.uniform(0.012, 0.02)
    shoulder = rng.uniform(0.45, 0.55) * height
    profile = [
        (0.0, 0.9 * foot),
        (0.06 * height, foot),
        (shoulder, neck),
        (0.95 * height, neck),
        (height, 1.1 * neck),
    ]
    return turned(profile)


def _coffee_mug(rng: np.random.Generator, width: float) -> Parts:
    """Hollow, with a bent handle."""
    r, height = width / 2.0, rng.uniform(0.07, 0.1)
    wall = rng.uniform(0.0035, 0.005)
    bend = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 7)
    deep, tall = rng.uniform(0.02, 0.028), 0.3 * height
    out, up = r - wall / 2.0 + deep * np.cos(bend), height / 2.0 + tall * np.sin(bend)
    handle = swept(np.stack([out, 0.0 * bend, up], axis=1), rng.uniform(0.010, 0.014), 0.008)
    return [*hollow([(0.0, r), (height, r)], wall, SIDES), *handle]


def _bowl(rng: np.random.Generator, width: float) -> Parts:
    """Its wall is steep; `width` is that of its wall."""
    rim, height = rng.uniform(0.055, 0.07), rng.uniform(0.035, 0.05)
    profile = [(0.0, 0.8 * rim), (0.15 * height, 0.96 * rim), (height, rim)]
    return hollow(profile, width)


def _spanner(rng: np.random.Generator, width: float) -> Parts:
    """Lying flat, open at one end; `width` is that of its shaft."""
    half, thick = width / 2.0, rng.uniform(0.012, 0.016)
    length = rng.uniform(0.085, 0.1)
    head, jaw = half + rng.uniform(0.008, 0.011), rng.uniform(0.006, 0.008)
    shaft = [(0.0, -half), (length, -0.8 * half), (length, 0.8 * half), (0.0, half)]
    root = [(-0.016, -head), (0.0, -half), (0.0, half), (-0.016, head)]
    fork = [(-0.016, jaw), (-0.016, head), (-0.038, 0.8 * head), (-0.040, jaw)]
    jaws = [[(x, side * y) for x, y in fork] for side in (-1.0, 1.0)]
    tip = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 7)
    end = [(length + 1.1 * half * np.cos(a), 0.8 * half * np.sin(a)) for a in tip]
    return [cut_out(outline, 0.0, thick) for outline in (shaft, root, end, *jaws)]


def _mallet(rng: np.random.Generator, width: float) -> Parts:
    """Lying; `width` is that of its handle, which is thicker at its end."""
    r, length = width / 2.0, rng.uniform(0.10, 0.12)
    grip = [(0.0, 0.9 * r), (0.01, 1.15 * r), (0.4 * length, r), (length, r)]
    handle = lying(turned(grip))
    wide, half = r + rng.uniform(0.004, 0.008), rng.uniform(0.028, 0.036)
    barrel = [(-half, 0.8 * wide), (-0.6 * half, wide), (0.6 * half, wide), (half, 0.8 * wide)]
    quarter = SE3(np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.zeros(3))
    there = SE3(np.eye(3), np.array([length, 0.0, 0.0]))
    return [*handle, *(part.moved(there * quarter) for part in lying(turned(barrel)))]


def _trowel(rng: np.random.Generator, width: float) -> Parts:
    """A blade that lies on the ground, and a handle above it on a bent neck."""
    r, grip = width / 2.0, rng.uniform(0.055, 0.065)
    blade = rng.uniform(0.06, 0.075)
    wide = rng.uniform(0.022, 0.03)
    side = [(0.0, wide), (0.7 * blade, 0.7 * wide)]
    plate = cut_out([*side, (blade, 0.0), *((x, -y) for x, y in reversed(side))], 0.0, 0.005)
    neck = np.array([[0.012, 0.0, 0.004], [0.0, 0.0, 0.012], [-0.01, 0.0, r], [-0.025, 0.0, r]])
    handle = lying(turned([(0.0, 0.8 * r), (0.012, r), (0.6 * grip, r), (grip, 0.7 * r)]))
    away = SE3(np.eye(3), np.array([-0.02 - grip, 0.0, 0.0]))
    return [plate, *swept(neck, 0.012, 0.008), *(part.moved(away) for part in handle)]


def _drill(rng: np.random.Generator, width: float) -> Parts:
    """A cordless drill that lies on its side; `width` is that of its grip."""
    half, thick = width / 2.0, rng.uniform(0.035, 0.045)
    long, tall = rng.uniform(0.038, 0.045), rng.uniform(0.014, 0.018)
    body = [(-long, -tall), (-0.9 * long, tall), (0.7 * long, tall), (long, 0.6 * tall)]
    body += [(long, -0.6 * tall), (0.7 * long, -tall)]
    grip = [(-0.6 * long - half, -tall), (-0.6 * long + half, -tall)]
    grip += [(-0.75 * long + half, -0.065), (-0.75 * long - half, -0.065)]
    foot = [(-1.1 * long, -0.083), (-1.1 * long, -0.065), (-0.1 * long, -0.065)]
    foot += [(-0.1 * long, -0.083)]
    chuck = lying(turned([(0.0, 0.013), (0.012, 0.013), (0.022, 0.006), (0.05, 0.003)]))
    front = SE3(np.eye(3), np.array([long, 0.0, thick / 2.0 - 0.013]))
    inset = 0.15 * thick
    return [
        cut_out(body, 0.0, thick),
        cut_out(grip, inset, thick - inset),
        cut_out(foot, 0.0, thick),
        *(part.moved(front) for part in chuck),
    ]


def _light_bulb(rng: np.random.Generator, width: float) -> Parts:
    """Lying on its glass and the rim of its socket; `width` is that of its glass."""
    r = width / 2.0
    angles = np.linspace(0.0, 0.78 * np.pi, 8)
    glass = [(r - r * float(np.cos(a)), r * float(np.sin(a)) + 1e-3) for a in angles]
    end, neck = glass[-1]
    socket = max(0.012, 0.8 * neck)
    length = end + 0.3 * r + 0.02
    profile = [*glass, (end + 0.3 * r, socket), (length, socket)]
    tilt = np.arcsin(r / np.hypot(length - r, socket)) - np.arctan2(socket, length - r)
    return lying(turned(profile), float(tilt))


MODELLED: dict[str, ObjectClass] = {
    "bottle": ObjectClass(make=_bottle, narrowest=0.03, widest=0.06),
    "flask": ObjectClass(make=_flask, narrowest=0.02, widest=0.04),
    "coffee mug": ObjectClass(make=_coffee_mug, narrowest=0.05, widest=0.068),
    "bowl": ObjectClass(make=_bowl, narrowest=0.005, widest=0.008),
    "spanner": ObjectClass(make=_spanner, narrowest=0.015, widest=0.024),
    "mallet": ObjectClass(make=_mallet, narrowest=0.016, widest=0.028),
    "trowel": ObjectClass(make=_trowel, narrowest=0.018, widest=0.028),
    "drill": ObjectClass(make=_drill, narrowest=0.02, widest=0.03),
    "light bulb": ObjectClass(make=_light_bulb, narrowest=0.04, widest=0.06),
}
