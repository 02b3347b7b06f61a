"""The places of a region on which something can be set down, and which of them is next."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from behaviours.poses import Region

if TYPE_CHECKING:
    from behaviours.context import Context

Array: TypeAlias = npt.NDArray[np.float64]


_CLOSER = 0.5
"""Between full rows a place is this share of the pitch from the others, at least."""
_FINE = 0.02
"""Places between rows lie on a grid as fine as this [m]."""


def slots(region: Region, pitch: float) -> list[Array]:
    """Centres (3,) of the places on the floor of a region, spread in rows, in the world [m].

    Args:
        region: whose floor.
        pitch: least distance between neighbouring places [m].
    """
    length, width, height = region.size
    columns, rows = (max(1, int((edge + 1e-9) // pitch)) for edge in (length, width))
    return [
        region.wTr.act(
            np.array(
                [
                    (column - (columns - 1) / 2.0) * length / columns,
                    (row - (rows - 1) / 2.0) * width / rows,
                    -height / 2.0,
                ]
            )
        )
        for row in range(rows)
        for column in range(columns)
    ]


def _finely(region: Region, margin: float) -> list[Array]:
    """Points (3,) all over the floor of a region but for its margin, in the world [m]."""
    length, width, height = np.maximum(region.size / 2.0 - [margin, margin, 0.0], 0.0)
    return [
        region.wTr.act(np.array([x, y, -height]))
        for y in np.arange(-width, width + 1e-9, _FINE)
        for x in np.arange(-length, length + 1e-9, _FINE)
    ]


class Places:
    """The places of one region; what is taken or blocked is known to the log of the task.

    Args:
        context: of the tree.
        region: whose floor.
        pitch: least distance between neighbouring places [m].
        far_first: whether rows far from the base are filled first, so that the arm does not reach
            over what it has set down; else near ones, as where it does not reach far.
    """

    def __init__(
        self, context: Context, region: Region, pitch: float, *, far_first: bool = True
    ) -> None:
        self._context, self._region = context, region
        self._sign = -1.0 if far_first else 1.0
        regular = slots(region, pitch)
        self._regular, self._spare_pitch = len(regular), _CLOSER * pitch
        self.slots = [*regular, *_finely(region, self._spare_pitch / 2.0)]
        """Centres (3,) in the world [m]; places are numbered from 1, those between rows last."""
        self.begin()

    def begin(self) -> None:
        """No place was passed over yet."""
        self._passed_over: set[int] = set()

    def next_free(self) -> int | None:
        """The number of the first place that is neither taken nor blocked nor passed over.

        When the rows are full, it is the place between them that is farthest from all others.
        """
        log, name = self._context.log, self._region.name
        gone = log.places_used.get(name, set()) | log.places_blocked.get(name, set())
        gone |= self._passed_over
        free = next((n for n in self._in_order() if n not in gone), None)
        return self._between(gone) if free is None else free

    def _between(self, gone: set[int]) -> int | None:
        here = np.array(self.slots)[:, :2]
        taken = here[np.array(sorted(gone)) - 1]
        room = np.linalg.norm(here[:, None] - taken, axis=2).min(axis=1)
        room[: self._regular] = 0.0
        best = int(room.argmax())
        return best + 1 if room[best] >= self._spare_pitch else None

    def pass_over(self, number: int | None) -> None:
        """Do not choose a place for this object."""
        if number is not None:
            self._passed_over.add(number)

    def none_free(self) -> str:
        """That no place is left, in words."""
        name = self._region.name
        blocked = len(self._context.log.places_blocked.get(name, set()) | self._passed_over)
        or_blocked = f" or blocked ({blocked})" if blocked else ""
        return f"all {self._regular} places on {name} are taken{or_blocked}"

    def _in_order(self) -> list[int]:
        """The numbers of the places, row by row."""
        wTr = self._region.wTr
        base = wTr.actInv(self._context.state.wTb.translation)[:2]
        axis = int((np.abs(base) - self._region.size[:2] / 2.0).argmax())
        regular = self.slots[: self._regular]
        away = [-np.sign(base[axis]) * wTr.actInv(slot)[axis] for slot in regular]
        return sorted(range(1, len(away) + 1), key=lambda n: round(self._sign * away[n - 1], 6))
