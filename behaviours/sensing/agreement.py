"""Whether laser and camera see the furniture where the map has it, or the robot is lost."""

from math import inf

import numpy as np

from hw import Fault, FaultKind
from perception.registration import Registration, Surfaces

_LOST_FOR = 2.5  # without any agreement [s]
_RAYS, _FEW = 8, 3  # that go through furniture, and through one piece, which does not stand there


class Agreement:
    """Notes registrations that agree with the map, and furniture that the robot sees through.

    Where one piece alone is missed, after something agreed, that piece has gone. Before anything
    has agreed, what hides two pieces may be one of them, elsewhere on the map.
    """

    def __init__(self) -> None:
        self.last = -inf
        """Stamp of the newest that agreed [s]."""
        self.fault: Fault | None = None
        """That the robot is lost; until something agrees, or a person says that it may go on."""
        self.since: float | None = None
        """Stamp of the first, after that, that spoke against the map [s]."""
        self._gone: set[int] = set()
        self._is_quiet = False

    def note(self, stamp: float, agrees: bool, seen: Registration, surfaces: Surfaces) -> None:
        """Take a registration at a time [s], and whether the estimate took it."""
        through, hidden = seen.missed
        if agrees and len(seen.points) > through.sum():
            self.last, self.fault, self.since = stamp, None, None
            self._gone, self._is_quiet = set(), False
            return
        is_new = self.last == -inf
        rays = through + hidden if is_new else through
        if rays.sum() < _RAYS:
            return
        self._gone |= set(np.flatnonzero(rays >= _FEW).tolist())
        is_one = len({int(surfaces.stacks[piece]) for piece in self._gone}) < 2
        if is_one and not (is_new and through.sum() >= _RAYS):
            return
        self.since = stamp if self.since is None else self.since
        if stamp - self.since >= _LOST_FOR and self.fault is None and not self._is_quiet:
            names = " and ".join(sorted(f"`{surfaces.names[piece]}`" for piece in self._gone))
            text = f"lost: {names} should be in sight, and nothing is where the map has it"
            self.fault = Fault(kind=FaultKind.LOST, text=text, clearable=False)

    def acknowledge(self) -> None:
        """A person lets it go on: be quiet until something has agreed."""
        self.fault, self._is_quiet = None, True
