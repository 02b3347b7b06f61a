"""Conditions on the robot's state, on detected objects, and on values."""

from math import degrees, inf
from typing import Annotated, ClassVar

import numpy as np
from pinocchio import SE3, log3
from py_trees.common import Status

from behaviours.core.arguments import validate_compare
from behaviours.core.context import Context
from behaviours.core.leaf import Condition
from behaviours.core.parameter_types import (
    BasePose,
    Bounds,
    Deviation,
    LowerBound,
    Posture,
    Region,
    ToolPose,
)

_CONFIRMED = 5.0  # where the base is counts as known for so long after a measurement of it [s]


class ArmHealthy(Condition):
    """Succeeds if the robot has no fault."""

    key: ClassVar[str] = "arm_healthy"

    def update(self) -> Status:
        """One tick."""
        return self.failure(fault) if (fault := self.fault()) else self.success("no fault")


class BatteryAbove(Condition):
    """Succeeds if the battery has more charge than this.

    That is not known where the robot does not tell.

    Args:
        percent: of a full battery [%].
    """

    key: ClassVar[str] = "battery_above"

    def __init__(
        self, name: str, context: Context, *, percent: Annotated[float, Bounds(least=1, most=100)]
    ) -> None:
        super().__init__(name, context)
        self._percent = percent

    def update(self) -> Status:
        """One tick."""
        charge = self.context.state.battery
        if charge is None:
            return self.unknown("the robot does not tell the charge of its battery")
        text = f"battery at {100.0 * charge:.1f} %"
        return self.success(text) if 100.0 * charge > self._percent else self.failure(text)


class Near(Condition):
    """Succeeds if the hand, the base or the arm is near a pose.

    Args:
        pose: of the task file; a tool pose is about the hand, a base pose about the base, a posture
            about the arm.
        within_m: how near [m]; of a posture it says nothing.
        within_deg: how little turned away from it, of a posture each joint [deg]; without it any
            turn will do, of a posture 3.
    """

    key: ClassVar[str] = "near"

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        pose: ToolPose | BasePose | Posture,
        within_m: Annotated[float, Bounds(least=0.0, most=10.0)] = 0.1,
        within_deg: Deviation | None = None,
    ) -> None:
        super().__init__(name, context)
        self._pose, self._within, self._within_deg = pose, within_m, within_deg

    def update(self) -> Status:
        """One tick."""
        pose, context = self._pose, self.context
        if isinstance(pose, Posture):
            away = degrees(float(np.abs(context.state.q - pose.q).max()))
            is_near = away <= (3.0 if self._within_deg is None else self._within_deg)
            return (self.success if is_near else self.failure)(f"{away:.1f}° from {pose.name}")
        if isinstance(pose, ToolPose):
            error: SE3 = context.oTe.actInv(pose.oTe)
        else:
            error = context.state.oTb.actInv(pose.oTb)
        distance = float(np.linalg.norm(error.translation))
        turn = degrees(float(np.linalg.norm(log3(error.rotation))))
        text = f"{distance:.2f} m, {turn:.0f}° from {pose.name}"
        turned = self._within_deg is not None and turn > self._within_deg
        return self.failure(text) if distance > self._within or turned else self.success(text)


class Localised(Condition):
    """Succeeds if it is known where the base is on the map.

    Fails when what laser and camera see, or the base's own localisation, speaks against it. Until
    they have seen what is on the map, while nothing has confirmed it for five seconds, or not so
    exactly, or what they see could be seen as well from up to 1.8 m away, it is not known.

    Args:
        within_m: how exactly, in two standard deviations [m].
    """

    key: ClassVar[str] = "localised"

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        within_m: Annotated[float, Bounds(least=0.001, most=10.0)] = 0.1,
    ) -> None:
        super().__init__(name, context)
        self._within = within_m

    def update(self) -> Status:
        """One tick."""
        here, now = self.context.localisation, self.context.now
        fault = here.agreement.fault
        wrong = fault.text if fault else here.doubt or (now.relocalised if now.lost else "")
        if wrong:
            return self.failure(wrong)
        if here.estimate is None:
            return self.success("the robot tells its place on the map")
        known = f"known within {1000.0 * here.uncertainty:.0f} mm"
        if here.agreement.since is not None:
            return self.unknown("nothing in sight is where the map has it")
        if here.confirmed == -inf:
            return self.unknown("nothing in sight was found on the map yet")
        if (age := now.state.stamp - here.confirmed) > _CONFIRMED:
            return self.unknown(f"not confirmed for {age:.0f} s")
        if here.rival:
            return self.unknown(here.rival)
        return self.success(known) if here.uncertainty <= self._within else self.unknown(known)


class HoldingObject(Condition):
    """Succeeds if the fingers rest on something.

    They do if they have moved when they were told to close, something stopped them before they were
    closed, and they are still there. While they move that is not known; while a node lets go on
    purpose, as `place` does, nothing is lost and it succeeds.
    """

    key: ClassVar[str] = "holding_object"
    hand_before: ClassVar[str] = "full"
    hand_after: ClassVar[str] = "full"

    def update(self) -> Status:
        """One tick."""
        context, leaf = self.context, self.context.memory.letting_go
        if leaf is not None and leaf.status is Status.RUNNING:
            return self.success(f"{leaf.name} lets go of it")
        width = f"{1000 * context.log.fingers.width:.0f} mm between the fingers"
        if context.state.gripper_moving and not self.fingers_have_opened:
            return self.unknown(f"{width}: the fingers still move")
        reason = self.empty_hand
        if reason is None:
            return self.success(width)
        return self.failure(f"nothing held, {width}: {reason}")


class AllPlaced(Condition):
    """Succeeds if as many objects were placed as were ever seen in a region.

    It compares how many `region_empty` or `scan_for_objects` have seen there with how many `place`
    has seen standing since the first of these looks. Objects that touch count as one there, so it
    fails too when one was lost on the way, or not seen to stand. After one has fallen back, that is
    not known until one of them has looked again, nor if what it lay with covers less by then.

    Args:
        taken_from: region of the task file that the objects were taken from.
    """

    key: ClassVar[str] = "all_placed"

    def __init__(self, name: str, context: Context, *, taken_from: Region) -> None:
        super().__init__(name, context)
        self._region = taken_from.name

    def update(self) -> Status:
        """One tick."""
        log = self.context.log
        stock = log.stocks.get(self._region)
        if stock is None:
            return self.unknown(f"nothing looked at what was in {self._region}")
        placed = log.placed - stock.placed_before
        text = f"{placed} of {stock.most} objects placed that were seen in {self._region}"
        if lost := log.lost(stock):
            return self.failure(f"{text}, and {lost} more left the hand, not seen to stand")
        if stock.fell:
            return self.unknown(f"{self._region} was not looked at since one fell back")
        if stock.lacks:
            return self.unknown(f"one fell back, and less was in {self._region} then than before")
        return self.success(text) if placed >= stock.most else self.failure(text)


class Compare(Condition):
    """Succeeds if a value is another value, or a number is not smaller than another one.

    Args:
        value: for example a key, as in `value: $count`.
        equals: what it has to be.
        least: the smallest number that will do.
    """

    key: ClassVar[str] = "compare"
    needs_robot: ClassVar[bool] = False
    comparable: ClassVar[tuple[str, ...]] = ("value", "equals", "least")
    validate = staticmethod(validate_compare)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        value: bool | int | float | str,
        equals: bool | int | float | str | None = None,
        least: float | None = None,
    ) -> None:
        super().__init__(name, context)
        self._value, self._equals, self._least = value, equals, least

    def update(self) -> Status:
        """One tick."""
        value, other = self._value, self._equals
        if self._least is not None and isinstance(value, int | float):
            return self._is_least(value, self._least)
        for one, than in ((value, other), (other, value)):
            if isinstance(one, LowerBound) and isinstance(than, int | float) and one <= than:
                return self.unknown(f"it is {value}, asked for {other}")
        # True is not 1 in a task file.
        if value == other and isinstance(value, bool) is isinstance(other, bool):
            return self.success(f"it is {other}")
        return self.failure(f"it is {value}, not {other}")

    def _is_least(self, value: float, least: float) -> Status:
        text = f"{value:g} of at least {least:g}"
        is_enough = value >= least
        if isinstance(least if is_enough else value, LowerBound):
            return self.unknown(f"it is {value}, asked for {least}")
        return self.success(text) if is_enough else self.failure(text)
