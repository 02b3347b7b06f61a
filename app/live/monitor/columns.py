"""Rows of many ticks in one call: both timelines, poses, and what changes rarely.

All poses are on one entity: a recording pays for every entity and every batch.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain
from operator import is_
from typing import Any, NamedTuple

import numpy as np
import rerun as rr
from pinocchio import SE3, Quaternion

from app.live.run_snapshot import Snapshot

WORLD = "world"
_POSES = "world/poses"


class Instant(NamedTuple):
    """A time on both timelines, other than that of a snapshot."""

    tick: int
    stamp: float  # on the session's clock [s]


Time = Snapshot | Instant


def timelines(times: Sequence[Time]) -> list[rr.TimeColumn]:
    """Columns "t" (session time) and "tick" for the rows of a batch."""
    return [
        rr.TimeColumn("t", duration=[time.stamp for time in times]),
        rr.TimeColumn("tick", sequence=[time.tick for time in times]),
    ]


def set_time(stream: rr.RecordingStream, time: Time) -> None:
    """Set the time of what this thread logs next."""
    stream.set_time("t", duration=time.stamp)
    stream.set_time("tick", sequence=time.tick)


def log_static(
    stream: rr.RecordingStream, looks: Mapping[str, Iterable[Any]], frame: str | None = None
) -> None:
    """Log archetypes by entity, in a named frame; without a name, each in a frame of its own."""
    for path, bodies in looks.items():
        for body in (rr.CoordinateFrame(frame or path), *bodies):
            stream.log(path, body, static=True)


def send_poses(stream: rr.RecordingStream, rows: Sequence[tuple[Time, Mapping[str, SE3]]]) -> None:
    """Send poses of named frames in the world, rows of a time and its frames, in order."""
    poses = [pose for _, frames in rows for pose in frames.values()]
    if not poses:
        return
    rotations = [Quaternion(pose.rotation).coeffs() for pose in poses]
    stream.send_columns(
        _POSES,
        indexes=timelines([time for time, frames in rows for _ in frames]),
        columns=rr.Transform3D.columns(
            translation=np.array([pose.translation for pose in poses]),
            quaternion=np.array(rotations),
            parent_frame=[WORLD] * len(poses),
            child_frame=[name for _, frames in rows for name in frames],
        ),
    )


class Changes:
    """Sends a row to an entity for each snapshot in which it has changed."""

    def __init__(self, stream: rr.RecordingStream) -> None:
        self._stream = stream
        self._last: dict[str, tuple[object, ...]] = {}

    def send(
        self,
        path: str,
        kind: Any,
        shown: Iterable[Snapshot],
        source: Callable[[Snapshot], tuple[object, ...]],
        drawn: Callable[[Snapshot], Mapping[str, Any]],
    ) -> None:
        """Send the snapshots in which an object of `source` is another than before.

        `drawn` returns the columns of some instances of the archetype `kind`.
        """
        times, rows = [], []
        for snapshot in shown:
            now = source(snapshot)
            if path not in self._last or not all(map(is_, now, self._last[path])):
                self._last[path] = now
                times.append(snapshot)
                rows.append(drawn(snapshot))
        if rows:
            columns = {name: [*chain(*(row[name] for row in rows))] for name in rows[0]}
            counts = [len(next(iter(row.values()))) for row in rows]
            instances = kind.columns(**columns).partition(counts)
            self._stream.send_columns(path, indexes=timelines(times), columns=instances)
