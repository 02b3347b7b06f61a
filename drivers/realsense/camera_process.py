"""The process that holds the camera.

Some calls of the vendor's library keep Python's interpreter lock (`pipeline.start` does), and
some hang when a camera is unplugged. A process that hangs is ended by the system and replaced.
"""

import time
from math import inf
from typing import Any

import numpy as np

from drivers.processes.child import Parent, serve, still_alive
from drivers.processes.mailbox import PAGE, Mailbox, open_memory
from drivers.processes.timestamps import SensorClock
from drivers.realsense.device_settings import STATUS, RealSenseSettings, Status
from drivers.realsense.image_buffer import ImageBuffer
from drivers.realsense.rectifier import ImageSpec, Rectifier, metres
from drivers.realsense.stream import HangsError, Stream, open_stream
from hw.clock import epoch, stopwatch

_STARTING = 30.0  # longest time that the library may take to start or stop a camera [s]
_HUNG = 5.0  # longest time that the library may block while the camera streams [s]
_REOPEN = 0.2  # pause before a lost camera is opened again [s]
_REOPEN_HUNG = (0.1, 0.5, 1.0, 2.0)
"""The same for a camera that hung once, twice, ... [s]; from the second time on it is reset first.
After all of them the user has to act."""
_AT_FIRST = 2  # how often a camera may hang before its first image
_RESETTING = 6.0  # a reset camera is back within this time [s]


class CameraProcess:
    """Opens the camera, repeatedly if necessary, and puts its images into shared memory."""

    def __init__(
        self,
        library: Any,
        settings: RealSenseSettings,
        spec: ImageSpec,
        memory: int,
        parent: Parent,
    ) -> None:
        self._library, self._settings, self._spec = library, settings, spec
        self._parent = parent
        shared = open_memory(memory)
        self._status = Mailbox(shared, 0, STATUS)
        self._buffer = ImageBuffer(shared, PAGE, spec.width, spec.height)
        self._has_begun = False
        self._frames = 0
        self._hung, self._reset = 0, -inf
        self._last = -inf  # camera stamp of the last image [ms]

    def run(self) -> None:
        """Deliver images until the parent ends; RuntimeError: it cannot be opened at first."""
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
                    self._publish(Status(trouble=trouble))
                pauses = _REOPEN_HUNG[: self._hung] if hangs else (_REOPEN,)
                self._wait(pauses[-1])

    def _wait(self, pause: float) -> None:
        until = stopwatch() + pause
        while stopwatch() < until and self._parent.commands():
            time.sleep(0.05)

    def _next(self, stream: Stream) -> Any:
        """The next set of frames; a camera that hangs is reopened, then reset: LostError."""
        try:
            frames = stream.next(self._last)
        except HangsError as error:
            self._hung += 1
            if self._hung == 1:
                raise HangsError(f"{error}: it is opened again") from error
            if self._hung > (len(_REOPEN_HUNG) if self._has_begun else _AT_FIRST):
                text = f"{error}, and a reset does not help: unplug it and plug it in again"
                raise HangsError(text) from error
            stream.reset()  # before the pipeline is stopped, which may never return
            self._reset = stopwatch()
            raise HangsError(f"{error}: it is reset") from error
        self._hung = 0
        return frames

    def _deliver(self, stream: Stream) -> None:
        rs, settings, spec = self._library, self._settings, self._spec
        rectifier, clock = Rectifier(stream.depth_intrinsics, spec), SensorClock(settings.delay)
        scale, status = stream.depth_scale, stream.identity
        first, is_new = None, True
        while self._parent.commands():
            frames = self._next(stream)
            arrived, calendar = stopwatch(), epoch()
            still_alive(_HUNG)
            depth = frames.get_depth_frame()
            grey = frames.get_infrared_frame(1) if settings.infrared else None
            if settings.infrared and not grey:
                continue  # an incomplete set
            self._last = depth.get_timestamp()
            number = depth.get_frame_number()
            if first is None:
                first = number - self._frames - 1
            self._frames = max(self._frames + 1, number - first)
            has_calendar = depth.get_frame_timestamp_domain() != rs.timestamp_domain.hardware_clock
            stamp = clock.stamp(
                self._last / 1e3 - _exposure_age(rs, depth),
                arrived,
                calendar if has_calendar else None,
            )
            self._buffer.put(
                self._frames,
                stamp,
                arrived,
                metres(rectifier.depth(np.asanyarray(depth.get_data())), scale, spec),
                rectifier.grey(np.asanyarray(grey.get_data())) if grey else None,
            )
            if is_new:
                self._publish(status)
                is_new = False

    def _publish(self, status: Status) -> None:
        status.put(self._status)
        if not self._has_begun:
            self._has_begun = True
            self._parent.tell(ready=True)


def _exposure_age(rs: Any, frame: Any) -> float:
    """Time from the exposure of a frame to its stamp, which is that of the readout [s]."""
    kind = rs.frame_metadata_value
    both = (kind.frame_timestamp, kind.sensor_timestamp)
    if not all(frame.supports_frame_metadata(one) for one in both):
        return 0.0
    read, exposed = (frame.get_frame_metadata(one) for one in both)
    before = (read - exposed) / 1e6
    return before if 0.0 <= before <= 0.1 else 0.0


def _work(parent: Parent, address: str, values: Any, memory: int) -> None:
    import pyrealsense2

    parent.tell(loaded=True)
    settings, spec = RealSenseSettings(**values["settings"]), ImageSpec(**values["spec"])
    if not settings.emulator:
        parent.claim(f"RealSense {address}")
    CameraProcess(pyrealsense2, settings, spec, memory, parent).run()


def main() -> None:
    """Serve one parent."""
    serve(_work, lambda error: str(error) or type(error).__name__)
