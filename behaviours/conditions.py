"""Conditions on the robot's state, on detected objects, and on values."""

from dataclasses import replace
from math import degrees, inf
from typing import Annotated, ClassVar

import numpy as np
from pinocchio import SE3, log3
from py_trees.common import Status

from behaviours.core.arguments import validate_looks_like, validate_times
from behaviours.core.context import Context
from behaviours.core.leaf import Condition
from behaviours.core.parameter_types import (
    BasePose,
    Bounds,
    Deviation,
    LowerBound,
    Millimetres,
    Posture,
    Region,
    ToolPose,
)
from behaviours.views.objects import Choice
from perception import ColourName, DetectedObject

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


class TimeBetween(Condition):
    """Succeeds at a time of the day, on the clock of the computer.

    A simulated run begins at noon.

    Args:
        after: hours and minutes, as in `08:30`.
        before: the same; where it is earlier than `after`, of the next day.
    """

    key: ClassVar[str] = "time_between"
    validate = staticmethod(validate_times)

    def __init__(self, name: str, context: Context, *, after: str, before: str) -> None:
        super().__init__(name, context)
        if wrong := self.validate({"after": after, "before": before}):
            raise ValueError(wrong)
        self._after, self._before = after, before

    def update(self) -> Status:
        """One tick."""
        minutes = int((self.context.began_at + self.context.state.stamp) / 60.0) % (24 * 60)
        now = f"{minutes // 60:02}:{minutes % 60:02}"
        since, until = self._after <= now, now < self._before
        is_between = since and until if self._after < self._before else since or until
        return (self.success if is_between else self.failure)(f"it is {now}")


class Near(Condition):
    """Succeeds if the hand, or the base, is near a pose.

    Args:
        pose: of the task file; a tool pose is about the hand, a base pose about the base.
        within_m: how near [m].
        within_deg: how little turned away from it [deg]; without it any turn will do.
    """

    key: ClassVar[str] = "near"

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        pose: ToolPose | BasePose,
        within_m: Annotated[float, Bounds(least=0.0, most=10.0)] = 0.1,
        within_deg: Deviation | None = None,
    ) -> None:
        super().__init__(name, context)
        self._pose, self._within, self._within_deg = pose, within_m, within_deg

    def update(self) -> Status:
        """One tick."""
        pose, context = self._pose, self.context
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


class ArmAt(Condition):
    """Succeeds if the arm is in a posture.

    Args:
        posture: of the task file; `ready` is always there.
        within_deg: how far each joint may be from it [deg].
    """

    key: ClassVar[str] = "arm_at"

    def __init__(
        self, name: str, context: Context, *, posture: Posture, within_deg: Deviation = 3.0
    ) -> None:
        super().__init__(name, context)
        self._posture, self._within_deg = posture, within_deg

    def update(self) -> Status:
        """One tick."""
        away = degrees(float(np.abs(self.context.state.q - self._posture.q).max()))
        text = f"{away:.1f}° from {self._posture.name}"
        return self.success(text) if away <= self._within_deg else self.failure(text)


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


class LooksLike(Condition):
    """Succeeds if a detected object is what is asked for.

    Not known where the camera has no colours and one is asked for.

    Args:
        object: that `detect` found.
        colour: it has this colour.
        min_width_mm: its shorter edge, seen from above, is at least this [mm].
        max_width_mm: its shorter edge is at most this [mm].
    """

    key: ClassVar[str] = "looks_like"
    validate = staticmethod(validate_looks_like)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        object: DetectedObject,
        colour: ColourName | None = None,
        min_width_mm: Millimetres | None = None,
        max_width_mm: Millimetres | None = None,
    ) -> None:
        super().__init__(name, context)
        self._object = object
        self._choice = Choice.of("best", None, colour, min_width_mm, max_width_mm)

    def update(self) -> Status:
        """One tick."""
        here, one = self.context.state.oTb.translation, self._object
        fits, but_for_colour = (
            bool(choice.fitting([one], here))
            for choice in (self._choice, replace(self._choice, colour=None))
        )
        if but_for_colour and not fits and not one.colour:
            return self.unknown("its colour was not seen")
        return (self.success if fits else self.failure)(str(one))


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


class Equals(Condition):
    """Succeeds if a value is another value.

    Args:
        value: for example a key, as in `value: $side`.
        to: what it has to be.
    """

    key: ClassVar[str] = "equals"
    needs_robot: ClassVar[bool] = False
    comparable: ClassVar[tuple[str, ...]] = ("value", "to")

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        value: bool | int | float | str,
        to: bool | int | float | str,
    ) -> None:
        super().__init__(name, context)
        self._value, self._to = value, to

    def update(self) -> Status:
        """One tick."""
        for one, other in ((self._value, self._to), (self._to, self._value)):
            if isinstance(one, LowerBound) and isinstance(other, int | float) and one <= other:
                return self.unknown(f"it is {self._value}, asked for {self._to}")
        # True is not 1 in a task file.
        if self._value == self._to and isinstance(self._value, bool) is isinstance(self._to, bool):
            return self.success(f"it is {self._to}")
        return self.failure(f"it is {self._value}, not {self._to}")


class AtLeast(Condition):
    """Succeeds if a number is not smaller than another one.

    Args:
        value: for example a key, as in `value: $count`.
        least: the smallest number that will do.
    """

    key: ClassVar[str] = "at_least"
    needs_robot: ClassVar[bool] = False

    def __init__(self, name: str, context: Context, *, value: float, least: float) -> None:
        super().__init__(name, context)
        self._value, self._least = value, least

    def update(self) -> Status:
        """One tick."""
        text = f"{self._value:g} of at least {self._least:g}"
        is_enough = self._value >= self._least
        if isinstance(self._least if is_enough else self._value, LowerBound):
            return self.unknown(f"it is {self._value}, asked for {self._least}")
        return self.success(text) if is_enough else self.failure(text)
