"""Moving obstacles, such as a person who walks to and fro."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from pinocchio import SE3

from controller import Obstacle
from robots import Array, Colour, Cylinder, Geom

_ACCELERATION = 2.0  # at each way point [m/s²]
_CLOTHES: Colour = (86, 98, 140)


@dataclass(frozen=True)
class _Leg:
    start: Array
    direction: Array
    length: float
    speed: float

    @property
    def _ramp(self) -> float:
        """Time from rest to full speed, or to the middle of a short leg [s]."""
        return float(min(self.speed / _ACCELERATION, np.sqrt(self.length / _ACCELERATION)))

    @property
    def duration(self) -> float:
        """[s]."""
        top = _ACCELERATION * self._ramp
        return self.length / top + self._ramp

    def at(self, time: float) -> tuple[Array, Array]:
        """(2,) position [m] and (2,) velocity [m/s] at a time since its start [s]."""
        ramp, top = self._ramp, _ACCELERATION * self._ramp
        left = self.duration - time
        if time < ramp:
            gone, speed = 0.5 * _ACCELERATION * time**2, _ACCELERATION * time
        elif left < ramp:
            gone, speed = self.length - 0.5 * _ACCELERATION * left**2, _ACCELERATION * left
        else:
            gone, speed = top * (time - 0.5 * ramp), top
        return self.start + gone * self.direction, speed * self.direction


class Walker:
    """An upright cylinder that walks along way points (x, y) [m], and back, whatever is there."""

    def __init__(
        self, name: str, radius: float, height: float, way: Sequence[Sequence[float]], speed: float
    ) -> None:
        self.name = name
        self.parts = (Geom(Cylinder(radius, height / 2.0), SE3.Identity(), name, _CLOTHES),)
        self._height = height
        points = [np.array(point, dtype=float) for point in way]
        there_and_back = [*points, *points[-2::-1]]
        self._legs = [
            _Leg(a, (b - a) / np.linalg.norm(b - a), float(np.linalg.norm(b - a)), speed)
            for a, b in pairwise(there_and_back)
        ]
        self._round = sum(leg.duration for leg in self._legs)
        self.move_to(0.0)

    def move_to(self, now: float) -> None:
        """Move to its pose at a time [s]."""
        time = now % self._round
        for leg in self._legs:
            if time <= leg.duration:
                break
            time -= leg.duration
        (x, y), (vx, vy) = leg.at(min(time, leg.duration))
        self.pose = SE3(np.eye(3), np.array([x, y, self._height / 2.0]))  # of its middle
        self.velocity: Array = np.array([vx, vy, 0.0])  # (3,) in the world [m/s]

    def placed(self) -> list[Geom]:
        """Its shape in the world."""
        return [part.moved(self.pose) for part in self.parts]

    @property
    def obstacle(self) -> Obstacle:
        """Its present shape and velocity, as a tracker would report them."""
        return Obstacle(self.placed()[0], self.velocity)
