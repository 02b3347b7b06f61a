"""Requests that the emulated base offers: names, access groups, and answers."""

import random
from collections.abc import Callable
from dataclasses import dataclass
from math import degrees

from config.planar import Pose2D, act
from extensions.emulators.omron.onboard_controller import Controller, Teleop
from extensions.emulators.omron.options import Options
from extensions.emulators.omron.wire import Taker, Writer
from hw import stopwatch

Answer = Callable[[Taker], "bytes | None"]  # from the arguments to the reply, if there is one


@dataclass(frozen=True)
class Entry:
    """One request."""

    number: int
    group: str
    arguments: str
    answer: Answer


_OTHERS = (
    *("gotoPose", "dock", "undock", "localizeToPose", "physicalInfo", "getMapName", "getGoals"),
    *("safetyStatusEStop", "arclCommand", "DataStore_TransVel", "say"),
)
"""Requests that are listed and not answered."""
_LONG_DESCRIPTION = "goal names, one after the other; " * 320  # as long as on newer bases


def reported_pose(controller: Controller, options: Options) -> Pose2D:
    """The pose on the map that the base reports: where it takes itself to be, plus an offset."""
    x, y, theta = controller.drive.localised()
    dx, dy, turn = options.offset
    return Pose2D(x + dx, y + dy, theta + turn)


def reported_score(controller: Controller, options: Options) -> float:
    """Of its localisation, 0 to 1; 0 if it is lost."""
    return 0.0 if options.lost or controller.drive.is_lost else options.score


def signed_degrees(angle: float) -> float:
    """From -180 (not included) to 180."""
    value = degrees(angle) % 360.0
    return value - 360.0 if value > 180.0 else value


def settings(teleop: Teleop) -> dict[str, float]:
    """The section "Teleop settings" [mm/s, deg/s, s, %]."""
    reported = teleop.tells_forwards
    return {
        "Timeout": teleop.timeout,
        "FullThrottleForwards": 1000.0 * (teleop.forwards if reported is None else reported),
        "FullThrottleBackwards": teleop.backwards * 1000.0,
        "RotAtFullForwards": round(degrees(teleop.turn_forwards)),
        "RotAtFullBackwards": round(degrees(teleop.turn_backwards)),
        "RotAtStopped": round(degrees(teleop.turn_at_rest)),
        "TransDeadZone": teleop.dead_translation,
        "RotDeadZone": teleop.dead_rotation,
    }


class Requests:
    """The requests of one emulated base, with numbers that depend on the seed."""

    def __init__(
        self,
        controller: Controller,
        options: Options,
        note: Callable[[str, tuple[float, ...]], None],
    ) -> None:
        self._controller, self._options = controller, options
        self._note = note
        poses: dict[str, Callable[[], Pose2D]] = {
            "Robot": lambda: reported_pose(controller, options),
            "Encoder": lambda: controller.drive.encoders(),
        }
        table: list[tuple[str, str, str, Answer]] = [
            ("ratioDrive", "Movement", "double: trans; double: rot", self._ratio_drive),
            ("stop", "Stop", "", self._stop),
            ("gotoGoal", "Movement", _LONG_DESCRIPTION, lambda _: None),
            ("updateNumbers", "RobotInfo", "", self._numbers),
            ("updateStrings", "RobotInfo", "", self._strings),
            ("batteryInfo", "RobotInfo", "", self._battery_info),
            ("getModeInfo", "RobotInfo", "", self._mode_info),
            ("getLocState", "RobotInfo", "", self._loc_state),
            *(
                (f"DataStore_{pose}PoseInterpolated_{name}", "RobotInfo", "", stored)
                for pose, read in poses.items()
                for name, stored in self._stored(read).items()
            ),
            ("Laser_1Current", "SensorInfo", "", self._laser),
            *((name, "SensorInfo", "", lambda _: None) for name in _OTHERS),
        ]
        table = [row for row in table if row[0] not in options.omit]
        numbers = random.Random(options.seed).sample(range(256, 1145), len(table))
        self.entries = {
            name: Entry(number, group, arguments, answer)
            for number, (name, group, arguments, answer) in zip(numbers, table, strict=True)
        }

    def of_groups(self, groups: frozenset[str]) -> dict[str, Entry]:
        """The requests that these access groups may use."""
        return {name: one for name, one in self.entries.items() if one.group in groups}

    def _ratio_drive(self, taker: Taker) -> None:
        trans, rot, throttle = taker.double(), taker.double(), taker.double()
        self._note("ratioDrive", (trans, rot, throttle))
        self._controller.ratio_drive(trans, rot, throttle, stopwatch())

    def _stop(self, _: Taker) -> None:
        self._note("stop", ())
        self._controller.stop()

    def _numbers(self, _: Taker) -> bytes:
        x, y, theta = reported_pose(self._controller, self._options)
        v, w = self._controller.drive.twist()
        whole = round(signed_degrees(theta))
        writer = Writer().integer(round(self._options.charge * 1000.0), 2)
        writer.integer(int(x * 1000.0), 4).integer(int(y * 1000.0), 4)
        writer.integer(180 if whole == -180 else whole, 2)
        writer.integer(int(v * 1000.0), 2).integer(int(degrees(w)), 2).integer(0, 2)
        return writer.integer(-128, 1).body

    def _strings(self, _: Taker) -> bytes:
        controller = self._controller
        return Writer().string(controller.status).string(controller.mode).string("").body

    def _battery_info(self, _: Taker) -> bytes:
        return Writer().double(20.0).double(5.0).integer(1, 1).body

    def _mode_info(self, _: Taker) -> bytes:
        controller = self._controller
        return Writer().string(controller.mode).integer(controller.locked, 1).integer(0, 1).body

    def _loc_state(self, _: Taker) -> bytes:
        score = reported_score(self._controller, self._options)
        state = 0 if score > 0.0 else 2
        return Writer().integer(state, 1).integer(round(score * self._options.score_scale), 2).body

    def _laser(self, _: Taker) -> bytes:
        pose = reported_pose(self._controller, self._options)
        echoes = self._controller.drive.echoes()
        writer = Writer().integer(len(echoes), 4)
        for ahead, left in echoes:
            for metres in act(pose, ahead, left):
                writer.integer(round(1000.0 * metres), 4)
        return writer.body

    def _stored(self, read: Callable[[], Pose2D]) -> dict[str, Answer]:
        def answer(axis: int) -> bytes:
            x, y, theta = read()
            value = (x * 1000.0, y * 1000.0, signed_degrees(theta))[axis]
            return self._options.data_store_kind + Writer().string(f"{value:.3f}").body

        return {"X": lambda _: answer(0), "Y": lambda _: answer(1), "Th": lambda _: answer(2)}
