"""The curves: commanded velocities, errors and computing time, a row every tick."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr

from app.live.monitor.columns import timelines
from app.live.snapshot import Snapshot
from controller import N_ARM
from robots import Limits

_SERIES = {
    "joint_velocity": [f"joint {i + 1}" for i in range(N_ARM)],
    "base_twist": ["vx [m/s]", "vy [m/s]", "ω [rad/s]"],
    "error": ["position [m]", "orientation [rad]", "heading θε [rad]"],
    "controller": ["manipulability", "slack"],
    "loop": ["tick [ms]", "dropped snapshots"],
}
"""Entities and their series; few entities keep the recording small."""


class SignalsPanel:
    """Draws the curves.

    Args:
        stream: where to.
        limits: the joint velocities are drawn as shares of these.
    """

    def __init__(self, stream: rr.RecordingStream, limits: Limits) -> None:
        self._stream = stream
        self._limits = limits
        self._written = 0
        for name, series in _SERIES.items():
            stream.log(f"signals/{name}", rr.SeriesLines(names=series), static=True)

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the rows of a batch."""
        times = timelines(batch)
        signals = [snapshot.signals for snapshot in batch]
        errors = [(s.position_error, s.orientation_error, s.heading_error) for s in signals]
        # A tick that is missing here was dropped by the feed.
        self._written += len(batch)
        dropped = batch[-1].tick + 1 - self._written
        rows = {
            "joint_velocity": [s.command.qd / self._limits.qd for s in batch],
            "base_twist": [s.command.base_twist for s in batch],
            "error": errors,
            "controller": [(s.manipulability, s.slack) for s in signals],
            "loop": [(s.tick_ms, dropped) for s in signals],
        }
        for name, values in rows.items():
            table = np.array(values, dtype=float)
            self._stream.send_columns(
                f"signals/{name}",
                indexes=times,
                columns=rr.Scalars.columns(scalars=table.ravel()).partition(
                    [table.shape[1]] * len(batch)
                ),
            )
