"""The laser of the base: `Laser_1Current`, points on its map, brought back to the base.

The layout was read in the source: a number, then x and y of each point in whole millimetres. That a
base sends 5 scans a second was reported by a driver that ran on an LD-60. Points without an echo
are left out, so scans have different lengths.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from drivers.omron.packet import Fields, LayoutError
from hw import Array, Clock, Finding, LaserReading, PassivePart, stopwatch
from robots import LaserDescription, RobotDescription

LASER = "Laser_1Current"
LASER_INTERVAL = 0.2  # of scans [s]


@dataclass(frozen=True, eq=False)
class Echoes:
    """One scan; the same object is the same scan."""

    points: Array  # (n, 2) in the base [m]
    captured: float  # of `stopwatch` [s]


def read_points(fields: Fields) -> Array:
    """(n, 2) points of a scan on the map of the base [m]; LayoutError: not as many as it says."""
    count = fields.integer("i")
    if count < 0 or fields.remaining < 8 * count:
        raise LayoutError(f"a scan of {count} points in {fields.remaining} bytes")
    millimetres = np.frombuffer(fields.raw(8 * count), dtype="<i4").reshape(count, 2)
    return millimetres / 1000.0


class OmronLaser(PassivePart):
    """The laser as a part of a robot; `echoes` are the base's newest, over its connection."""

    def __init__(
        self, echoes: Callable[[], Echoes | None], description: LaserDescription, clock: Clock
    ) -> None:
        self._echoes, self._mount, self._clock = echoes, description.bTs.translation, clock
        self._read: Echoes | None = None
        self._reading: LaserReading | None = None

    def examine(self, robot: RobotDescription) -> Iterator[Finding]:
        """Nothing: the base tells of it, over whose connection it comes."""
        return iter(())

    def latest(self) -> LaserReading | None:
        """The newest scan."""
        echoes = self._echoes()
        if echoes is not None and echoes is not self._read:
            level = np.full((len(echoes.points), 1), self._mount[2])
            self._read = echoes
            self._reading = LaserReading(
                stamp=self._clock.now() - (stopwatch() - echoes.captured),
                ranges=np.linalg.norm(echoes.points - self._mount[:2], axis=1),
                points=np.hstack([echoes.points, level]),
            )
        return self._reading
