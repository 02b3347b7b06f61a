"""Where furniture stands that was moved from its place on the map."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from math import radians

import numpy as np
from pinocchio import SE3, utils

from config.arrays import Array
from perception.registration import DISPLACED, Displacement, Registration, Surfaces
from robots import Geom, half_extents

_UNKNOWN = np.diag(np.square(DISPLACED))
"""Covariance of the displacement of a piece of which nothing is known yet."""
_WALK = np.diag(np.square([0.001, 0.001, radians(0.05)]))
"""What its covariance grows by from one registration to the next: a piece may be moved again."""
_PERSISTS = 5  # registrations that must show a displacement before it counts
_LONGEST = 2.5  # what is longer is a wall [m]
_NOTICEABLE, _TURN = 0.005, radians(0.5)  # of displacements, and of their changes [m, rad]


@dataclass(eq=False)
class _Piece:
    """What is known of a piece that was seen out of its place."""

    centre: Array  # (2,) of the piece on the map, about which it turned [m]
    by: Array  # (3,) x, y [m] and turn [rad]
    covariance: Array  # (3, 3) of that
    times: int = 0  # registrations that showed it

    def take(self, one: Displacement) -> None:
        """A Kalman step; what the points do not show stays as it was."""
        self.centre = one.centre
        known = np.linalg.inv(self.covariance + _WALK)
        measured = np.linalg.inv(one.covariance)
        # Without the prior with which they were matched.
        self.covariance = np.linalg.inv(known + measured - np.linalg.inv(_UNKNOWN))
        self.by = self.covariance @ (known @ self.by + measured @ one.by)


@dataclass(frozen=True, eq=False)
class _Standing:
    """Where a piece is taken to stand."""

    by: Array
    motion: SE3  # from its place on the map


class Furniture:
    """Keeps the newest displacement of every piece that several registrations in a row agree on."""

    def __init__(self) -> None:
        self._pieces: dict[str, _Piece] = {}
        self._shown: dict[str, _Standing] = {}
        """Those that count; another dictionary when one of them changes."""
        self._placed: tuple[object, object, tuple[Geom, ...]] = None, None, ()

    @property
    def names(self) -> list[str]:
        """Pieces that may have been moved: a pose must not rest on them."""
        return list(self._pieces)

    def motion(self, piece: str) -> SE3 | None:
        """The motion, on the map, of what stands on a piece; None if that is in its place."""
        return self._shown[piece].motion if piece in self._shown else None

    def covariance(self, piece: str) -> Array:
        """(3, 3) how far a piece may be from where it is taken to stand: x, y [m], turn [rad]."""
        return _UNKNOWN if piece in self._pieces else np.zeros((3, 3))

    def standing(self, fixtures: tuple[Geom, ...]) -> tuple[Geom, ...]:
        """Fixtures of the map where they stand; the same tuple until one was moved noticeably."""
        if not self._shown:
            return fixtures
        if self._placed[0] is not fixtures or self._placed[1] is not self._shown:
            motions = [self.motion(one.piece) for one in fixtures]
            both = zip(fixtures, motions, strict=True)
            moved = tuple(one if by is None else one.moved(by) for one, by in both)
            self._placed = fixtures, self._shown, moved
        return self._placed[2]

    def forget(self) -> None:
        """Everything stands in its place: what was seen rests on a pose that was wrong."""
        self._pieces, self._shown = {}, {}

    def suspect(self, pieces: Iterable[str]) -> None:
        """Let no pose rest on these pieces until a registration shows where they are."""
        for name in pieces:
            self._pieces.setdefault(name, _Piece(np.zeros(2), np.zeros(3), _UNKNOWN))

    def note(self, result: Registration) -> None:
        """Take what a registration says of the furniture."""
        self.suspect(one.piece for one in result.displaced)
        for one in (*result.displaced, *result.uncertain):
            if (piece := self._pieces.get(one.piece)) is not None:
                piece.take(one)
                piece.times += one in result.displaced
        self._pieces = {name: one for name, one in self._pieces.items() if _is_noticeable(one.by)}
        certain = {name: one for name, one in self._pieces.items() if one.times >= _PERSISTS}
        shown = {name: self._show(name, one) for name, one in certain.items()}
        if shown != self._shown:
            self._shown = shown

    def _show(self, name: str, piece: _Piece) -> _Standing:
        before = self._shown.get(name)
        if before is not None and not _is_noticeable(piece.by - before.by):
            return before
        centre, (x, y, turn) = np.append(piece.centre, 0.0), piece.by.tolist()
        rotation = utils.rotate("z", turn)
        there = centre + np.array([x, y, 0.0]) - rotation @ centre
        return _Standing(piece.by, SE3(rotation, there))


def _is_noticeable(by: Array) -> bool:
    return bool(np.hypot(by[0], by[1]) > _NOTICEABLE or abs(by[2]) > _TURN)


def map_surfaces(fixtures: Collection[Geom]) -> Surfaces:
    """The surfaces of a map; what is too long for furniture is a wall, and cannot be moved."""
    pieces: dict[str, list[Geom]] = {}
    for one in fixtures:
        pieces.setdefault(one.piece, []).append(one)
    walls = {one.piece for one in fixtures if max(half_extents(one.shape)[:2]) > _LONGEST / 2.0}
    return Surfaces(pieces, walls)
