"""Places of a region for objects that are set down, and their order."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pinocchio import SE3

from behaviours.core.held_object import way_off
from behaviours.core.parameter_types import Region
from config.arrays import Array

if TYPE_CHECKING:
    from behaviours.core.context import Context

_CLOSER = 0.5  # least share of the pitch between a place and the others, when the rows are full
_GRID = 0.02  # of the places between rows [m]


def slots(region: Region, pitch: float) -> list[Array]:
    """World centres (3,) of places on a region's floor, in rows at least `pitch` apart [m]."""
    return [region.oTr.act(slot) for slot in _rows(region, pitch)]


def _rows(region: Region, pitch: float) -> list[Array]:
    """The same in the region."""
    length, width, height = region.size
    columns, rows = (max(1, int((edge + 1e-9) // pitch)) for edge in (length, width))
    return [
        np.array(
            [
                (column - (columns - 1) / 2.0) * length / columns,
                (row - (rows - 1) / 2.0) * width / rows,
                -height / 2.0,
            ]
        )
        for row in range(rows)
        for column in range(columns)
    ]


def _grid(region: Region, margin: float) -> list[Array]:
    """Points (3,) on the floor of a region without its margin, in the region [m]."""
    length, width, height = np.maximum(region.size / 2.0 - [margin, margin, 0.0], 0.0)
    return [
        np.array([x, y, -height])
        for y in np.arange(-width, width + 1e-9, _GRID)
        for x in np.arange(-length, length + 1e-9, _GRID)
    ]


class Places:
    """The places of one region; the task log has those that are used or blocked.

    Args:
        context: shared by the leaves.
        region: whose floor.
        pitch: least distance between neighbouring places [m].
    """

    def __init__(self, context: Context, region: Region, pitch: float) -> None:
        self._context, self._region = context, region
        regular = _rows(region, pitch)
        self._regular, self._spare_pitch = len(regular), _CLOSER * pitch
        self._slots = [*regular, *_grid(region, self._spare_pitch / 2.0)]
        """Centres (3,) in the region [m]."""
        self.begin()

    @property
    def slots(self) -> list[Array]:
        """World centres (3,) [m]; places are numbered from 1, those between rows last."""
        oTr = self._region.oTr
        return [oTr.act(slot) for slot in self._slots]

    def centre(self, number: int) -> Array:
        """(3,) of one place, in odometry, now [m]."""
        centre: Array = self._region.oTr.act(self._slots[number - 1])
        return centre

    def beside(self, number: int | None, oRe: Array, most: float) -> Array:
        """By how much (3,) a place is moved off what was set down beside it, in odometry [m].

        Zero if what the hand holds needs more room than `most` [m] gives it.
        """
        if number is None:
            return np.zeros(3)
        memory, oTe = self._context.memory, SE3(oRe, self.centre(number))
        mTe = self._context.to_map(oTe)
        off = oRe @ mTe.rotation.T @ way_off(memory.held, memory.set_down.extents, mTe)
        return off if np.linalg.norm(off) <= most else np.zeros(3)

    def name(self, number: int | None) -> str:
        """What a person reads of a place: those in rows have numbers."""
        in_row = number is not None and number <= self._regular
        return f"place {number}" if in_row else "a place between the rows"

    def begin(self, *, far_first: bool = True) -> None:
        """Forget the places that were passed over.

        `far_first` is whether rows far from the base are filled first, so that the arm does not
        reach over placed objects; else near ones.
        """
        self._sign = -1.0 if far_first else 1.0
        self._passed_over: set[int] = set()

    def next_free(self) -> int | None:
        """The number of the first free place, or between full rows the one with the most room.

        Places that were not seen come after the others of the rows.
        """
        log, name = self._context.log, self._region.name
        taken = log.places_used.get(name, set()) | log.places_blocked.get(name, set())
        taken |= self._passed_over
        unseen = log.places_unseen.get(name, set())
        free = (n for n in self._in_order() if n not in taken)
        first = min(free, key=unseen.__contains__, default=None)
        return self._between(taken) if first is None else first

    def _between(self, numbers: set[int]) -> int | None:
        here = np.array(self.slots)[:, :2]
        taken = here[np.array(sorted(numbers)) - 1]
        room = np.linalg.norm(here[:, None] - taken, axis=2).min(axis=1)
        room[: self._regular] = 0.0
        best = int(room.argmax())
        return best + 1 if room[best] >= self._spare_pitch else None

    def pass_over(self, number: int | None) -> None:
        """Skip a place for this object."""
        if number is not None:
            self._passed_over.add(number)

    def none_free(self) -> str:
        """The message when no place is free."""
        name = self._region.name
        blocked = len(self._context.log.places_blocked.get(name, set()) | self._passed_over)
        or_blocked = f" or blocked ({blocked})" if blocked else ""
        return f"no place free on {name}, {self._regular} taken{or_blocked}"

    def _in_order(self) -> list[int]:
        """The numbers of the places, row by row."""
        oTr = self._region.oTr
        base = oTr.actInv(self._context.state.oTb.translation)[:2]
        axis = int((np.abs(base) - self._region.size[:2] / 2.0).argmax())
        regular = [oTr.act(slot) for slot in self._slots[: self._regular]]
        away = [-np.sign(base[axis]) * oTr.actInv(slot)[axis] for slot in regular]
        return sorted(range(1, len(away) + 1), key=lambda n: round(self._sign * away[n - 1], 6))
