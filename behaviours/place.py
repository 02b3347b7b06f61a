"""Set down what is held, each thing on a free place of a region."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2
from typing import ClassVar

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from py_trees.common import Status

from behaviours.context import Context
from behaviours.leaf import Leaf, Progress, remaining
from behaviours.named import Region
from behaviours.retreat_check import CLOSED
from controller import PoseGoal

_CLEARANCE = 0.008
"""Height over the surface at which the object is let go [m]."""
_ABOVE = 0.12
"""Height over the place that the hand comes from and goes back to [m]."""


def places(region: Region, pitch: float) -> list[np.ndarray]:
    """Centres (3,) of the places on the floor of a region, in rows, in the world [m]."""
    columns, rows = (max(1, int((edge + 1e-9) // pitch)) for edge in region.size[:2])
    return [
        region.wTr.act(
            np.array(
                [
                    (column - (columns - 1) / 2.0) * pitch,
                    (row - (rows - 1) / 2.0) * pitch,
                    -region.size[2] / 2.0,
                ]
            )
        )
        for row in range(rows)
        for column in range(columns)
    ]


class Place(Leaf):
    """Set the held object down on the next free place of a region and rise.

    The hand stops as high above the region's floor as it was above what the object stood on when it
    was grasped. Fails when nothing is held, no place is free, the hand does not get there, or the
    robot has a fault.

    Args:
        on: region of the task file whose floor is the surface to place on.
        pitch_m: distance between neighbouring places [m].
    """

    key: ClassVar[str] = "place"

    def __init__(self, name: str, context: Context, *, on: Region, pitch_m: float = 0.2) -> None:
        super().__init__(name, context)
        self._on = on
        self._places = places(on, pitch_m)

    def initialise(self) -> None:
        """Choose the place; the hand keeps the turn about the vertical that it has."""
        context = self.context
        used = context.log.places_used.get(self._on.name, 0)
        self._number = used + 1
        self._phase = self._approach
        self._progress = Progress()
        if used >= len(self._places):
            return
        x_axis = context.wTe.rotation[:, 0]
        rotation = pin.rpy.rpyToMatrix(np.pi, 0.0, atan2(x_axis[1], x_axis[0]))
        height = context.log.grip_height + _CLEARANCE
        self._down = SE3(rotation, self._places[used] + np.array([0.0, 0.0, height]))
        self._above = SE3(rotation, self._down.translation + np.array([0.0, 0.0, _ABOVE]))

    def update(self) -> Status:
        """One tick of the phase that the placing is in."""
        if fault := self.fault():
            return self.failure(fault)
        if self._number > len(self._places):
            return self.failure(f"all {len(self._places)} places on {self._on.name} are taken")
        return self._phase()

    def _approach(self) -> Status:
        return self._move("over the place", self._above, 0.6, 0.015, self._lower)

    def _lower(self) -> Status:
        return self._move("lowering", self._down, 0.2, 0.004, self._release)

    def _release(self) -> Status:
        self.grip(self.context.robot.description.gripper.opening, 20.0)
        self._phase = self._open
        return self.running("letting go")

    def _open(self) -> Status:
        if (waiting := self.fingers("letting go")) is not None:
            return waiting
        log = self.context.log
        log.place(self.context.clock.now())
        log.places_used[self._on.name] = self._number
        self._phase = self._rise
        return self.running("rising")

    def _rise(self) -> Status:
        return self._move("rising", self._above, 0.5, 0.03, self._done)

    def _done(self) -> Status:
        return self.success(f"placed on {self._on.name}, place {self._number}")

    def _move(
        self, what: str, wTe: SE3, speed: float, tolerance: float, then: Callable[[], Status]
    ) -> Status:
        """One tick of a straight motion of the hand, then the next phase."""
        if then is not self._done and self.context.state.gripper_width < CLOSED:
            return self.failure("nothing left between the fingers")
        report = self.pursue(
            PoseGoal(wTe=wTe, speed=speed, position_tolerance=tolerance, straight=True), what
        )
        if report is None:
            return self.running(what)
        if report.arrived:
            self._phase, self._progress = then, Progress()
            return then()
        if self._progress.stalled(remaining(report), self.context.clock.now()):
            return self.failure(f"{what}: stuck {report.position_error:.2f} m away")
        return self.running(f"{what}, {report.position_error:.2f} m to go")
