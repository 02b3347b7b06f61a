"""Rows of many ticks in one call: both timelines, and poses.

All poses are on one entity: a recording pays for every entity and every batch.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import rerun as rr
from pinocchio import SE3, Quaternion

from app.live.snapshot import Snapshot

Array = npt.NDArray[np.float64]


class Instant(NamedTuple):
    """A time on both timelines, other than that of a snapshot."""

    tick: int
    stamp: float
    """On the session's clock [s]."""


Time = Snapshot | Instant


def timelines(times: Sequence[Time]) -> list[rr.TimeColumn]:
    """Columns "t" (session time) and "tick" for the rows of a batch."""
    return [
        rr.TimeColumn("t", duration=[time.stamp for time in times]),
        rr.TimeColumn("tick", sequence=[time.tick for time in times]),
    ]


def quaternion(pose: SE3) -> rr.Quaternion:
    """A pose's rotation."""
    return rr.Quaternion(xyzw=Quaternion(pose.rotation).coeffs())


def set_time(stream: rr.RecordingStream, time: Time) -> None:
    """Set the time of what this thread logs next."""
    stream.set_time("t", duration=time.stamp)
    stream.set_time("tick", sequence=time.tick)


WORLD = "world"

_POSES = "world/poses"


def send_poses(stream: rr.RecordingStream, rows: Sequence[tuple[Time, Mapping[str, SE3]]]) -> None:
    """Send poses of named frames in the world, rows of a time and its frames, in order."""
    poses = [pose for _, frames in rows for pose in frames.values()]
    names = [name for _, frames in rows for name in frames]
    if not poses:
        return
    rotations = [Quaternion(pose.rotation).coeffs() for pose in poses]
    stream.send_columns(
        _POSES,
        indexes=timelines([time for time, frames in rows for _ in frames]),
        columns=rr.Transform3D.columns(
            translation=np.array([pose.translation for pose in poses]),
            quaternion=np.array(rotations),
            parent_frame=[WORLD] * len(names),
            child_frame=names,
        ),
    )
