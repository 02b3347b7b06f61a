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
from math import inf
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
from hw.realsense.stream import EndedError, HangsError, Stream, open_stream

_STARTING = 30.0
"""What the library may take to start or stop a camera [s]."""
_HUNG = 5.0
"""A camera from which nothing comes, not even that nothing comes, hangs [s]."""
_AGAIN = 0.2
"""Between two attempts to open a camera that is lost [s]."""
_AFTER_HANGING = (0.1, 0.5, 1.0, 2.0)
"""Before a camera that hung once, twice, ... is opened again; from the second time on it is reset
before. After all of them a person is asked [s]."""
_AT_FIRST = 2
"""A camera that never sent anything may hang so often."""
_RESETTING = 6.0
"""A camera that is reset is back within this [s]."""


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
        self._hung, self._reset = 0, -inf
        self._told = -inf
        """Stamp of the last image, as the camera gave it [ms]."""

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
                hangs = isinstance(error, HangsError)
                is_resetting = stopwatch() - self._reset < _RESETTING
                is_helped = self._hung <= _AT_FIRST if hangs else is_resetting
                if not self._has_begun and not is_helped:
                    raise
                trouble = str(error)
                if is_resetting and not hangs:
                    trouble = f"it was reset and is not back yet ({trouble})"
                if self._has_begun:
                    self._tell(Status(trouble=trouble))
                pauses = _AFTER_HANGING[: self._hung] if hangs else (_AGAIN,)
                self._wait(pauses[-1])

    def _wait(self, pause: float) -> None:
        until = stopwatch() + pause
        while stopwatch() < until and self._parent.commands():
            time.sleep(0.05)

    def _next(self, stream: Stream) -> Any:
        """The next set of frames of a camera; one that hangs is helped, and then a person asked.

        Raises:
            LostError: none comes; the text says what is done about it, or what is to be done.
            EndedError: the recording is over.
        """
        try:
            frames = stream.next(self._told)
        except HangsError as error:
            self._hung += 1
            if self._hung == 1:
                raise HangsError(f"{error}: it is opened again") from error
            if self._hung > (len(_AFTER_HANGING) if self._has_begun else _AT_FIRST):
                text = f"{error}, and a reset does not help: unplug it and plug it in again"
                raise HangsError(text) from error
            stream.reset()  # before the pipeline is stopped, which may never return
            self._reset = stopwatch()
            raise HangsError(f"{error}: it is reset") from error
        self._hung = 0
        return frames

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
            frames = self._next(stream)
            arrived, calendar = stopwatch(), epoch()
            still_alive(_HUNG)
            depth = frames.get_depth_frame()
            grey = frames.get_infrared_frame(1) if settings.infrared else None
            if settings.infrared and not grey:
                continue  # a set that lacks one
            self._told = depth.get_timestamp()
            number = depth.get_frame_number()
            if first is None:
                first = number - self._frames - 1
            self._frames = max(self._frames + 1, number - first)
            has_calendar = not settings.file and (
                depth.get_frame_timestamp_domain() != rs.timestamp_domain.hardware_clock
            )
            stamp = clock.stamp(
                self._told / 1e3 - _exposed_before(rs, depth),
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
