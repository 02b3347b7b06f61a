"""Plots of the recording: commanded velocities, errors and computing time, a row per tick."""

from collections.abc import Callable, Mapping, Sequence
from itertools import cycle, islice
from math import degrees, hypot, isfinite, nan
from typing import NamedTuple

import numpy as np
import rerun as rr

from app.live.monitor.columns import timelines
from app.live.monitor.glyphs import Colour
from app.live.run_snapshot import Snapshot
from config.arrays import Array
from config.planar import Pose2D
from robots import RobotDescription

_SEVEN: tuple[Colour, ...] = (
    (230, 80, 70),
    (240, 160, 40),
    (225, 220, 70),
    (90, 200, 90),
    (60, 200, 215),
    (90, 130, 255),
    (210, 110, 230),
)
"""Distinct colours on a dark ground: all for the joints, `_FEW` for other curves."""
_FEW = (_SEVEN[4], _SEVEN[1])


class Curves(NamedTuple):
    """The curves of one plot, all in one unit."""

    name: str
    series: Sequence[str]
    row: Callable[[Snapshot], object]  # values of the curves


SHARES = "joint_velocity"
PLOTS = {
    SHARES: Curves(
        "joint velocities / limits",
        [],  # a curve a joint
        lambda s: s.command.qd,
    ),
    "base_velocity": Curves(
        "base velocity [m/s]", ["vx", "vy"], lambda s: s.command.base_twist[:2]
    ),
    "base_rotation": Curves("base rotation [rad/s]", ["ω"], lambda s: s.command.base_twist[2:]),
    "distance": Curves(
        "distance to the goal [m]", ["distance"], lambda s: (s.report.position_error,)
    ),
    "angle": Curves(
        "angles to the goal [rad]",
        ["hand", "heading θε"],
        lambda s: (s.report.orientation_error, s.report.heading_error),
    ),
    "clearance": Curves(
        "nearest obstacle [m]",
        ["clearance"],
        lambda s: (s.report.clearance if isfinite(s.report.clearance) else nan,),
    ),
    "manipulability": Curves(
        "manipulability [m^3]", ["manipulability"], lambda s: (s.report.manipulability,)
    ),
    "slack": Curves("slack of the programme [m/s, rad/s]", ["slack"], lambda s: (s.report.slack,)),
    "tick": Curves("tick [ms]", ["tick"], lambda s: (1000.0 * s.seconds,)),
}
"""By entity, below /signals; one unit per axis."""


def _error(s: Snapshot) -> Pose2D:
    """The true error of the believed pose, in the true base."""
    if s.estimate is None or s.estimate.true_base is None:
        return Pose2D(nan, nan, nan)
    return Pose2D.of(s.mTb).relative_to(Pose2D.of(s.estimate.true_base))


def _two_sigma(s: Snapshot) -> tuple[float, float]:
    return (nan, nan) if s.estimate is None else s.estimate.two_sigma


POSE_PLOTS = {
    "pose_position": Curves(
        "position of the base [mm]",
        ["2 sigma", "true error"],
        lambda s: (1000.0 * _two_sigma(s)[0], 1000.0 * hypot(*_error(s)[:2])),
    ),
    "pose_heading": Curves(
        "heading of the base [deg]",
        ["2 sigma", "true error"],
        lambda s: (degrees(_two_sigma(s)[1]), degrees(abs(_error(s)[2]))),
    ),
}
"""More of them, where the pose of the base is an estimate."""


class SignalsPanel:
    """Draws the curves of `plots`; joint velocities as shares of `limits`."""

    def __init__(
        self, stream: rr.RecordingStream, robot: RobotDescription, plots: Mapping[str, Curves]
    ) -> None:
        self._stream, self._limits, self._plots = stream, robot.limits, plots
        for entity, curves in plots.items():
            names = curves.series or [robot.arm.called(i) for i in range(len(robot.limits.qd))]
            colours = _SEVEN if len(names) > len(_FEW) else _FEW
            look = rr.SeriesLines(names=names, colors=list(islice(cycle(colours), len(names))))
            stream.log(f"signals/{entity}", look, static=True)

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the rows of a batch."""
        times = timelines(batch)
        for entity, curves in self._plots.items():
            table: Array = np.array([curves.row(snapshot) for snapshot in batch], dtype=float)
            if entity == SHARES:
                table /= self._limits.qd
            rows = rr.Scalars.columns(scalars=table.ravel())
            self._stream.send_columns(
                f"signals/{entity}",
                indexes=times,
                columns=rows.partition([table.shape[1]] * len(batch)),
            )
