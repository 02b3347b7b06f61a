"""The process that holds the camera.

Some calls of the vendor's library keep Python's interpreter lock (`pipeline.start` does), and
some are known to hang when a camera is unplugged. Here they hold up nobody: a process that hangs is
ended by the system, and a new one is started.
"""

from __future__ import annotations

import json
import sys
import time
from dataclasses import asdict
from typing import Any

import numpy as np

from hw.clock import epoch, stopwatch
from hw.processes.child import Parent, claim, leave, still_alive
from hw.processes.mailbox import PAGE, Mailbox, open_memory
from hw.realsense.album import Album
from hw.realsense.images import Filters, Rectifier, Wanted, metres
from hw.realsense.records import STATUS, Status
from hw.realsense.settings import RealSenseSettings
from hw.realsense.stamps import CameraClock
from hw.realsense.stream import EndedError, Stream, open_stream

_STARTING = 30.0
"""What the library may take to start or stop a camera [s]."""
_HUNG = 5.0
"""A camera from which nothing comes, not even that nothing comes, hangs [s]."""
_AGAIN = 0.2
"""Between two attempts to open a camera that is lost [s]."""


class CameraProcess:
    """Opens the camera, again and again if need be, and puts its images into shared memory.

    Args:
        library: of the vendor.
        settings: of the camera.
        wanted: images.
        memory: descriptor of the shared memory.
        parent: whom the images are for.
    """

    def __init__(
        self,
        library: Any,
        settings: RealSenseSettings,
        wanted: Wanted,
        memory: int,
        parent: Parent,
    ) -> None:
        self._library, self._settings, self._wanted = library, settings, wanted
        self._parent = parent
        shared = open_memory(memory)
        self._status = Mailbox(shared, 0, STATUS)
        self._album = Album(shared, PAGE, wanted.width, wanted.height)
        self._has_begun = False
        self._frames = 0

    def run(self) -> None:
        """Until nobody wants images any more.

        Raises:
            RuntimeError: the camera cannot be opened at first.
            EndedError: the recording is over.
        """
        while self._parent.commands():
            still_alive(_STARTING)
            try:
                with open_stream(self._library, self._settings) as stream:
                    self._deliver(stream)
            except RuntimeError as error:
                if not self._has_begun:
                    raise
                self._tell(Status(trouble=str(error)))
                time.sleep(_AGAIN)

    def _deliver(self, stream: Stream) -> None:
        rs, settings, wanted = self._library, self._settings, self._wanted
        told = stream.intrinsics(rs.stream.depth)
        rectifier, filters = Rectifier(told, wanted), Filters(rs, settings)
        clock, scale = CameraClock(settings.delay), stream.depth_scale
        status: Status | None = Status(
            **asdict(stream.identity), intrinsics=(told.fx, told.fy, told.ppx, told.ppy)
        )
        first = None
        while self._parent.commands():
            frames = stream.next()
            arrived, calendar = stopwatch(), epoch()
            still_alive(_HUNG)
            depth = frames.get_depth_frame()
            grey = frames.get_infrared_frame(1) if settings.infrared else None
            if not depth or (settings.infrared and not grey):
                continue  # a set that lacks one
            number = depth.get_frame_number()
            if first is None:
                first = number - self._frames - 1
            self._frames = max(self._frames + 1, number - first)
            has_calendar = not settings.file and (
                depth.get_frame_timestamp_domain() != rs.timestamp_domain.hardware_clock
            )
            stamp = clock.stamp(
                depth.get_timestamp() / 1e3 - _exposed_before(rs, depth),
                arrived,
                calendar if has_calendar else None,
            )
            pixels = np.asanyarray(filters.apply(depth).get_data())
            self._album.put(
                self._frames,
                stamp,
                arrived,
                metres(rectifier.depth(pixels), scale, wanted),
                rectifier.grey(np.asanyarray(grey.get_data())) if grey else None,
            )
            if status is not None:
                self._tell(status)
                status = None

    def _tell(self, status: Status) -> None:
        status.put(self._status)
        if not self._has_begun:
            self._has_begun = True
            self._parent.tell(ready=True)


def _exposed_before(rs: Any, frame: Any) -> float:
    """How long before its stamp, which is that of the readout, a frame was exposed [s]."""
    kind = rs.frame_metadata_value
    both = (kind.frame_timestamp, kind.sensor_timestamp)
    if not all(frame.supports_frame_metadata(one) for one in both):
        return 0.0
    read, exposed = (frame.get_frame_metadata(one) for one in both)
    before = (read - exposed) / 1e6
    return before if 0.0 <= before <= 0.1 else 0.0


def main() -> None:
    """Serve one parent; arguments: address, settings as JSON, descriptor of the shared memory."""
    address, told, memory = sys.argv[1], json.loads(sys.argv[2]), int(sys.argv[3])
    settings, wanted = RealSenseSettings(**told["settings"]), Wanted(**told["wanted"])
    parent = Parent()
    try:
        import pyrealsense2

        parent.tell(loaded=True)
        is_shared = bool(settings.file or settings.emulator)
        if not is_shared and (other := claim("RealSense", address)):
            parent.tell(error=other)
            leave(1)
        CameraProcess(pyrealsense2, settings, wanted, memory, parent).run()
    except EndedError:
        parent.tell(error="its recording is over")
        leave(1)
    except Exception as error:
        parent.tell(error=str(error) or type(error).__name__)
        leave(1)
    leave()
