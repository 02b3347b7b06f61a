"""The postures of the bank that a search for a stance looks at, the likely ones first."""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from controller.command import Array
from controller.stance.posture_bank import PostureBank

Indices: TypeAlias = npt.NDArray[np.int64]

_WINDOWS = ((0.08, 0.96), (0.2, 0.85))
"""How far the height [m] and tilt (a cosine) of a posture may be from the goal's before refinement:
the first window that holds enough postures is taken, and among fixtures the next one after it."""
_MIN_CANDIDATES = 12
"""A window with fewer postures than this is too narrow."""
_FALLBACK_CANDIDATES = 300
"""Nearest postures that are ranked where every window is too narrow."""
_METRES_PER_TILT = 0.3
"""What the cosine of the tilt counts like in that search [m]."""

_FAR = 800
"""Postures of the second window that are ranked at most."""
_TURNED = 160
"""Postures of the first window that are ranked at most for each turn of the base."""
_TURNS = (-1.5, -1.0, -0.5, 0.5, 1.0, 1.5)
"""How far the base is turned: the hand is then beside it [rad]."""
_DOWN = 0.3
"""A hand that points less sideways than this may as well be beside the base from the start."""


class Candidates(NamedTuple):
    """Postures of the bank, the first joint turned."""

    indices: Indices
    """(N,) in the bank."""
    turns: Array
    """(N,) of the first joint [rad]: by so much the base turns the other way."""


def candidates(
    bank: PostureBank, wTe: SE3, *, among_fixtures: bool = False
) -> Iterator[Candidates]:
    """The postures whose end effector is about as high and as tilted as a pose.

    Where the end effector points down, some of them come again, the base turned below the arm.
    Among fixtures the postures of the next window follow, and those.

    Args:
        bank: the postures to choose from.
        wTe: the pose to reach.
        among_fixtures: whether more than the first window is worth a look.
    """
    heights, verticals = bank.tools.positions[:, 2], bank.tools.rotations[:, 2]
    height, vertical = wTe.translation[2], wTe.rotation[2]
    windows: list[Indices] = []
    for window, min_cosine in _WINDOWS:
        first, last = np.searchsorted(heights, [height - window, height + window])
        found: Indices = first + np.flatnonzero(verticals[first:last] @ vertical > min_cosine)
        if len(found) >= _MIN_CANDIDATES:
            windows.append(found)
    if not windows:
        distance = np.abs(heights - height) - _METRES_PER_TILT * (verticals @ vertical)
        windows.append(np.argpartition(distance, _FALLBACK_CANDIDATES)[:_FALLBACK_CANDIDATES])
    near = windows[0]
    some = near[:: 1 + len(near) // _TURNED]
    turned = Candidates(np.tile(some, len(_TURNS)), np.repeat(_TURNS, len(some)))
    straight = Candidates(near, np.zeros(len(near)))
    yield _both(straight, turned) if sideways(wTe) < _DOWN else straight
    if among_fixtures:
        far = windows[1][:: 1 + len(windows[1]) // _FAR] if len(windows) > 1 else near[:0]
        yield _both(Candidates(far, np.zeros(len(far))), turned)


def sideways(wTe: SE3) -> float:
    """By how much an end effector points sideways: 0 is straight up or down, 1 is horizontal."""
    return hypot(*wTe.rotation[:2, 2].tolist())


def _both(one: Candidates, other: Candidates) -> Candidates:
    return Candidates(*(np.concatenate(pair) for pair in zip(one, other, strict=True)))
