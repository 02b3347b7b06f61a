"""The curves: what the controller asked for and how well it did, a row every tick."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr

from app.monitor.columns import timelines
from app.monitor.snapshot import Snapshot
from controller import N_ARM, Limits

_SERIES = {
    "joint_velocity": [f"joint {i + 1}" for i in range(N_ARM)],
    "base_twist": ["vx [m/s]", "vy [m/s]", "ω [rad/s]"],
    "manipulability": ["manipulability"],
    "slack": ["slack"],
    "error": ["position [m]", "orientation [rad]", "heading [rad]"],
    "tick": ["tick [ms]"],
}


class SignalsPanel:
    """Draws the curves.

    Args:
        stream: where to.
        limits: what the joint velocities are divided by.
    """

    def __init__(self, stream: rr.RecordingStream, limits: Limits) -> None:
        self._stream = stream
        self._limits = limits
        for name, series in _SERIES.items():
            stream.log(f"signals/{name}", rr.SeriesLines(names=series), static=True)

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the rows of a batch."""
        times = timelines(batch)
        signals = [snapshot.signals for snapshot in batch]
        errors = [(s.position_error, s.orientation_error, s.heading_error) for s in signals]
        rows = {
            "joint_velocity": [s.command.qd / self._limits.qd for s in batch],
            "base_twist": [s.command.base_twist for s in batch],
            "manipulability": [(s.manipulability,) for s in signals],
            "slack": [(s.slack,) for s in signals],
            "error": errors,
            "tick": [(s.tick_ms,) for s in signals],
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
