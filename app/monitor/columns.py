"""Many ticks in one call: the two timelines and the columns of poses that all panels send."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import rerun as rr
from pinocchio import SE3, Quaternion

from app.monitor.snapshot import Snapshot

Array = npt.NDArray[np.float64]


def timelines(batch: Sequence[Snapshot]) -> list[rr.TimeColumn]:
    """Columns "t" (time since the session began) and "tick" for the rows of a batch."""
    return [
        rr.TimeColumn("t", duration=[snapshot.stamp for snapshot in batch]),
        rr.TimeColumn("tick", sequence=[snapshot.tick for snapshot in batch]),
    ]


def set_time(stream: rr.RecordingStream, snapshot: Snapshot) -> None:
    """Make a snapshot's time that of what this thread logs next."""
    stream.set_time("t", duration=snapshot.stamp)
    stream.set_time("tick", sequence=snapshot.tick)


def quaternion(pose: SE3) -> rr.Quaternion:
    """A pose's rotation."""
    return rr.Quaternion(xyzw=Quaternion(pose.rotation).coeffs())


def pose_columns(poses: Sequence[SE3]) -> rr.ComponentColumnList:
    """One transform a row."""
    return rr.Transform3D.columns(
        translation=np.array([pose.translation for pose in poses]),
        quaternion=[quaternion(pose) for pose in poses],
    )


def axes_columns(poses: Sequence[SE3 | None], length: float) -> rr.ComponentColumnList:
    """Three arrows of `length` [m] a row, none where there is no pose."""
    there = [pose for pose in poses if pose is not None]
    origins = np.array([pose.translation for pose in there]).reshape(-1, 3)
    vectors = np.array([length * pose.rotation.T for pose in there]).reshape(-1, 3)
    counts = [0 if pose is None else 3 for pose in poses]
    return rr.Arrows3D.columns(origins=np.repeat(origins, 3, axis=0), vectors=vectors).partition(
        counts
    )
