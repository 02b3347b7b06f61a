"""A fault turns the robot red and hangs a banner over it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import rerun as rr

from app.live.monitor.columns import WORLD, set_time
from app.live.monitor.glyphs import Colour, printable
from app.live.snapshot import Snapshot

_RED: Colour = (225, 45, 40)
_PLAIN: Colour = (255, 255, 255)
_BANNER = "world/fault"
_ABOVE = np.array([0.0, 0.0, 1.45])
"""The banner over the base, where no arm hides it [m]."""


class FaultPanel:
    """Draws the faults."""

    def __init__(self, stream: rr.RecordingStream, bodies: Mapping[str, Sequence[Any]]) -> None:
        self._stream = stream
        self._shown: tuple[str, ...] | None = None
        self._looks: list[tuple[str, type[Any], Any]] = []
        colours: dict[int, Any] = {}  # both fingers are drawn from the same
        for path, some in bodies.items():
            for body in some:
                if not isinstance(body, rr.Mesh3D) and id(body) not in colours:
                    colours[id(body)] = body.colors.pa_array.to_numpy(zero_copy_only=False)
                    body.colors = None  # a colour that never changes could not turn red
                self._looks.append((path, type(body), colours.get(id(body))))
        stream.log(_BANNER, rr.CoordinateFrame(WORLD), static=True)
        look = rr.Points3D.from_fields(colors=[_RED], radii=0.02, show_labels=True)
        stream.log(_BANNER, look, static=True)

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the faults of a batch."""
        for snapshot in batch:
            faults = tuple(fault.text for fault in snapshot.state.faults)
            if faults != self._shown:
                set_time(self._stream, snapshot)
                if self._shown is None or bool(faults) is not bool(self._shown):
                    self._paint(bool(faults))
                self._hang(snapshot, faults)
                self._shown = faults

    def _paint(self, is_red: bool) -> None:
        for path, kind, colours in self._looks:
            if kind is rr.Mesh3D:
                look = rr.Mesh3D.from_fields(albedo_factor=_RED if is_red else _PLAIN)
            else:
                look = kind.from_fields(colors=[_RED] if is_red else colours)
            self._stream.log(path, look)

    def _hang(self, snapshot: Snapshot, faults: Sequence[str]) -> None:
        places = [snapshot.state.wTb.translation + _ABOVE] if faults else []
        labels = [f"⚠ FAULT: {printable('; '.join(faults))}"] if faults else []
        self._stream.log(_BANNER, rr.Points3D.from_fields(positions=places, labels=labels))
