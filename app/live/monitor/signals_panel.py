"""Plots of the recording: commanded velocities, errors and computing time, a row per tick."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite, nan
from typing import NamedTuple

import numpy as np
import rerun as rr

from app.live.monitor.columns import Array, timelines
from app.live.monitor.glyphs import Colour
from app.live.snapshot import Snapshot
from controller import N_ARM
from robots import Limits

SEVEN: tuple[Colour, ...] = (
    (230, 80, 70),
    (240, 160, 40),
    (225, 220, 70),
    (90, 200, 90),
    (60, 200, 215),
    (90, 130, 255),
    (210, 110, 230),
)
"""Distinct colours on a dark ground: all for the joints, `FEW` for other curves."""
FEW = (SEVEN[4], SEVEN[1], SEVEN[6])


class Curves(NamedTuple):
    """The curves of one plot, all in one unit."""

    name: str
    series: Sequence[str]
    unit: str


PLOTS = {
    "joint_velocity": Curves(
        "joint velocities / limits", [f"joint {i + 1}" for i in range(N_ARM)], "1"
    ),
    "base_velocity": Curves("base velocity [m/s]", ["vx", "vy"], "m/s"),
    "base_rotation": Curves("base rotation [rad/s]", ["ω"], "rad/s"),
    "distance": Curves("distance to the goal [m]", ["distance"], "m"),
    "angle": Curves("angles to the goal [rad]", ["hand", "heading θε"], "rad"),
    "clearance": Curves("nearest obstacle [m]", ["clearance"], "m"),
    "manipulability": Curves("manipulability", ["manipulability"], "m^3"),
    "slack": Curves("slack of the programme [m/s, rad/s]", ["slack"], "mixed norm"),
    "tick": Curves("tick [ms]", ["tick"], "ms"),
    "dropped": Curves("dropped snapshots", ["dropped"], "1"),
}
"""By entity, below /signals; one unit per axis."""

_Row = Callable[[Snapshot], object]
_ROWS: dict[str, _Row] = {
    "base_velocity": lambda s: s.command.base_twist[:2],
    "base_rotation": lambda s: s.command.base_twist[2:],
    "distance": lambda s: (s.report.position_error,),
    "angle": lambda s: (s.report.orientation_error, s.report.heading_error),
    "clearance": lambda s: (s.report.clearance if isfinite(s.report.clearance) else nan,),
    "manipulability": lambda s: (s.report.manipulability,),
    "slack": lambda s: (s.report.slack,),
    "tick": lambda s: (1000.0 * s.seconds,),
}


class SignalsPanel:
    """Draws the curves; joint velocities as shares of `limits`."""

    def __init__(self, stream: rr.RecordingStream, limits: Limits) -> None:
        self._stream = stream
        self._limits = limits
        self._written = 0
        for entity, curves in PLOTS.items():
            colours = (SEVEN if len(curves.series) > len(FEW) else FEW)[: len(curves.series)]
            look = rr.SeriesLines(names=curves.series, colors=colours)
            stream.log(f"signals/{entity}", look, static=True)

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the rows of a batch."""
        # A tick that is missing here was dropped by the feed.
        self._written += len(batch)
        dropped = batch[-1].tick + 1 - self._written
        self._send("joint_velocity", batch, [s.command.qd / self._limits.qd for s in batch])
        self._send("dropped", batch[-1:], [(dropped,)])
        for entity, row in _ROWS.items():
            self._send(entity, batch, [row(snapshot) for snapshot in batch])

    def _send(self, entity: str, batch: Sequence[Snapshot], rows: Sequence[object]) -> None:
        table: Array = np.array(rows, dtype=float)
        self._stream.send_columns(
            f"signals/{entity}",
            indexes=timelines(batch),
            columns=rr.Scalars.columns(scalars=table.ravel()).partition(
                [table.shape[1]] * len(batch)
            ),
        )
