"""Set down what is held, each object on a free slot of a region."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2
from typing import ClassVar

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from py_trees.common import Status

from behaviours.context import Context
from behaviours.leaf import Leaf
from behaviours.poses import Region
from behaviours.progress import Progress
from controller import PoseGoal


def slots(region: Region, pitch: float) -> list[np.ndarray]:
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
        self._slots = slots(on, pitch_m)

    @property
    def phase(self) -> str:
        """`approach` until the hand is over the place, then `lower`, `release` and `rise`."""
        return {self._approach: "approach", self._lower: "lower", self._rise: "rise"}.get(
            self._step, "release"
        )

    def initialise(self) -> None:
        """Choose the place; the hand keeps the turn about the vertical that it has."""
        context = self.context
        used = context.log.places_used.get(self._on.name, 0)
        self._number = used + 1
        self._step = self._approach
        self._progress = Progress(self.settings.progress)
        if used >= len(self._slots):
            return
        x_axis = context.wTe.rotation[:, 0]
        rotation = pin.rpy.rpyToMatrix(np.pi, 0.0, atan2(x_axis[1], x_axis[0]))
        height = context.log.grip_height + self.settings.place.clearance
        self._down = SE3(rotation, self._slots[used] + np.array([0.0, 0.0, height]))
        up = np.array([0.0, 0.0, self.settings.place.above])
        self._above = SE3(rotation, self._down.translation + up)

    def update(self) -> Status:
        """One tick of the phase that the placing is in."""
        if fault := self.fault():
            return self.failure(fault)
        if self._number > len(self._slots):
            return self.failure(f"all {len(self._slots)} places on {self._on.name} are taken")
        return self._step()

    def _approach(self) -> Status:
        s = self.settings.place
        speed, tolerance = s.approach_speed, s.approach_tolerance
        return self._move("over the place", self._above, speed, tolerance, self._lower)

    def _lower(self) -> Status:
        s = self.settings.place
        return self._move("lowering", self._down, s.lower_speed, s.lower_tolerance, self._release)

    def _release(self) -> Status:
        self.open_gripper()
        self._step = self._open
        return self.running("letting go")

    def _open(self) -> Status:
        if (waiting := self.fingers("letting go")) is not None:
            return waiting
        log = self.context.log
        log.place(self.context.clock.now())
        log.places_used[self._on.name] = self._number
        self._step = self._rise
        return self.running("rising")

    def _rise(self) -> Status:
        s = self.settings.place
        return self._move("rising", self._above, s.rise_speed, s.rise_tolerance, self._done)

    def _done(self) -> Status:
        return self.success(f"placed on {self._on.name}, place {self._number}")

    def _move(
        self, what: str, wTe: SE3, speed: float, tolerance: float, then: Callable[[], Status]
    ) -> Status:
        """One tick of a straight motion of the hand, then the next phase."""
        if then is not self._done and self.gripper_is_closed:
            return self.failure("nothing left between the fingers")
        report = self.pursue(
            PoseGoal(wTe=wTe, speed=speed, position_tolerance=tolerance, straight=True), what
        )
        if report is None:
            return self.running(what)
        if report.arrived:
            self._step, self._progress = then, Progress(self.settings.progress)
            return then()
        if self._progress.is_stuck(report, self.context.clock.now()):
            return self.failure(f"{what}: stuck {report.position_error:.2f} m away")
        return self.running(f"{what}, {report.position_error:.2f} m to go")
