"""The places of a region on which something can be set down, and which of them is next."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from behaviours.context import Context
from behaviours.poses import Region

Array: TypeAlias = npt.NDArray[np.float64]


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


class Places:
    """The places of one region; what is taken or blocked is known to the log of the task.

    Args:
        context: of the tree.
        region: whose floor.
        pitch: least distance between neighbouring places [m].
    """

    def __init__(self, context: Context, region: Region, pitch: float) -> None:
        self._context, self._region = context, region
        self.slots = slots(region, pitch)
        """Centres (3,) in the world [m]; places are numbered from 1."""
        self.begin()

    def begin(self) -> None:
        """No place was passed over yet."""
        self._passed_over: set[int] = set()

    def next_free(self) -> int | None:
        """The number of the first place that is neither taken nor blocked nor passed over."""
        log, name = self._context.log, self._region.name
        gone = log.places_used.get(name, set()) | log.places_blocked.get(name, set())
        gone |= self._passed_over
        return next((n for n in self._far_rows_first() if n not in gone), None)

    def pass_over(self, number: int | None) -> None:
        """Do not choose a place for this object."""
        if number is not None:
            self._passed_over.add(number)

    def none_free(self) -> str:
        """That no place is left, in words."""
        name = self._region.name
        blocked = len(self._context.log.places_blocked.get(name, set()) | self._passed_over)
        or_blocked = f" or blocked ({blocked})" if blocked else ""
        return f"all {len(self.slots)} places on {name} are taken{or_blocked}"

    def _far_rows_first(self) -> list[int]:
        """The numbers of all places: so the arm does not reach over what it has set down."""
        wTr = self._region.wTr
        base = wTr.actInv(self._context.state.wTb.translation)[:2]
        axis = int((np.abs(base) - self._region.size[:2] / 2.0).argmax())
        away = [-np.sign(base[axis]) * wTr.actInv(slot)[axis] for slot in self.slots]
        return sorted(range(1, len(away) + 1), key=lambda n: round(-away[n - 1], 6))
