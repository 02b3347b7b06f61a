"""Many ticks in one call: the two timelines, and poses.

Poses are of named frames in the world, and those of all frames lie on one entity: a recording pays
for every entity and batch, live views are fed often, and a robot has many links.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import rerun as rr
from pinocchio import SE3, Quaternion

from app.live.monitor.snapshot import Snapshot

Array = npt.NDArray[np.float64]


def timelines(batch: Sequence[Snapshot]) -> list[rr.TimeColumn]:
    """Columns "t" (time since the session began) and "tick" for the rows of a batch."""
    return [
        rr.TimeColumn("t", duration=[snapshot.stamp for snapshot in batch]),
        rr.TimeColumn("tick", sequence=[snapshot.tick for snapshot in batch]),
    ]


def quaternion(pose: SE3) -> rr.Quaternion:
    """A pose's rotation."""
    return rr.Quaternion(xyzw=Quaternion(pose.rotation).coeffs())


def set_time(stream: rr.RecordingStream, snapshot: Snapshot) -> None:
    """Make a snapshot's time that of what this thread logs next."""
    stream.set_time("t", duration=snapshot.stamp)
    stream.set_time("tick", sequence=snapshot.tick)


WORLD = "world"
"""The frame that all others are in. They are called as the entities that are drawn in them."""

_POSES = "world/poses"


def send_poses(
    stream: rr.RecordingStream, rows: Sequence[tuple[Snapshot, Mapping[str, SE3]]]
) -> None:
    """Send where frames are in the world.

    Args:
        stream: where to.
        rows: snapshots in order of time, each with the poses of some frames.
    """
    poses = [pose for _, frames in rows for pose in frames.values()]
    names = [name for _, frames in rows for name in frames]
    if not poses:
        return
    rotations = [Quaternion(pose.rotation).coeffs() for pose in poses]
    stream.send_columns(
        _POSES,
        indexes=timelines([snapshot for snapshot, frames in rows for _ in frames]),
        columns=rr.Transform3D.columns(
            translation=np.array([pose.translation for pose in poses]),
            quaternion=np.array(rotations),
            parent_frame=[WORLD] * len(names),
            child_frame=names,
        ),
    )
