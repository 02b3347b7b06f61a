"""Vision of one robot: newest frame, detected grasps and tracked grasp, computed on demand.

Grasp detection takes longer than a control period: an executor searches one frame at a time, and
a tick takes the result when it is there.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from math import inf
from typing import Protocol

import numpy as np

from config.arrays import Array
from hw import Camera, DepthFrame, InlineExecutor, stopwatch
from perception import (
    Detection,
    FrameChecker,
    GraspDetector,
    GraspEstimate,
    GraspTracker,
    SceneMemory,
    Workspace,
)

_OLDEST_FRAME = 0.15  # an older frame is outdated [s]
_AHEAD = 0.25  # a frame may be newer than the reading of the robot by this [s]
_LOST_FRAME = 1.0  # frames that are older are not late but missing [s]


class Target(Workspace, Protocol):
    """A workspace that may follow the map."""

    def locate(self) -> Callable[[], Workspace]:
        """How it stands in odometry now; what it returns is called beside the loop."""


class Vision:
    """Newest frame, detection and tracked grasp of one robot.

    All leaves of a tick see the same frame. A frame is new when it is another object than the one
    before. Implausible frames are dropped.

    Args:
        camera: of the robot.
        detector: the network with its pre- and post-processing; used by the executor alone.
        executor: searches the frames; None searches a frame in the tick that asks for it.
    """

    def __init__(
        self, camera: Camera, detector: GraspDetector, executor: Executor | None = None
    ) -> None:
        self._camera, self._detector = camera, detector
        self._executor = executor or InlineExecutor()
        self._searched: tuple[DepthFrame, Target | None] | None = None  # without one it is dropped
        self._result: Future[Detection] | None = None  # of that search, until it is taken
        self._found: tuple[Target, Detection] | None = None
        self._searched_until = -inf  # stamp of the newest frame that was searched [s]
        self._judge, self._mistake = FrameChecker(), ""
        self._delivered: DepthFrame | None = None
        self._newest: DepthFrame | None = None
        self._is_new = False
        self.tracker = GraspTracker()
        self.frame: DepthFrame | None = None  # the newest that was used
        self.detection: Detection | None = None  # grasps in it; None if it was not searched
        self.grasp: GraspEstimate | None = None  # that is tracked
        self._oRa: Array | None = None  # (3, 3) axes in which grasps are down; None: the world's
        self._known_since = -inf
        self._memory = SceneMemory()
        self.seconds = 0.0  # of wall time that ticks have spent on images [s]

    def begin_tick(self) -> None:
        """Let a newer frame, or another result, count as new."""
        self._is_new = False
        self._found = None

    def detect(self, workspace: Target) -> Detection | None:
        """Grasps in a workspace; None if there is no new result in this tick."""
        if self._found is None or self._found[0] is not workspace:
            self._take()
            self._take_result(workspace)
            newest, is_idle = self._newest, self._result is None
            if newest is not None and is_idle and self._searched != (newest, workspace):
                self._searched = newest, workspace
                with self.timed():
                    # Before the search: it changes its memory.
                    if self.grasp is not None and self.grasp.velocity.any():
                        self._memory = self._memory.without(self.grasp, workspace.floor)
                    self._result = self._executor.submit(
                        self._search, newest, workspace.locate(), self._memory, self._oRa
                    )
                self._take_result(workspace)
        found = self._found
        return found[1] if found is not None and found[0] is workspace else None

    def _search(
        self,
        frame: DepthFrame,
        locate: Callable[[], Workspace],
        memory: SceneMemory,
        oRa: Array | None,
    ) -> Detection:
        return self._detector.detect(frame, locate(), memory, oRa)

    def _take_result(self, workspace: Target) -> None:
        """The result of the search; one of another region, or of before a reset, is dropped."""
        if (result := self._result) is None or not result.done() or self._searched is None:
            return
        (frame, where), self._result = self._searched, None
        if where is workspace:
            self.frame, self.detection = frame, result.result()
            self._searched_until, self._found = frame.stamp, (workspace, self.detection)

    @contextmanager
    def timed(self) -> Iterator[None]:
        """Context manager that adds its duration to `seconds`."""
        begun = stopwatch()
        yield
        self.seconds += stopwatch() - begun

    def new_frame(self) -> DepthFrame | None:
        """The frame that is new in this tick; None if there is none."""
        frame = self._take()
        if frame is not None and frame is not self.frame:
            self.frame, self.detection = frame, None
        return frame

    def picture(self, now: float) -> DepthFrame | None:
        """The newest frame, whoever asked for it first; None if there is none to believe now.

        Args:
            now: session time [s]; see `blindness`.
        """
        self.new_frame()
        return None if self.blindness(now) else self._newest

    def newest(self, after: float) -> DepthFrame | None:
        """The newest frame; the camera is asked for one after session time `after` [s]."""
        if self._newest is None or self._newest.stamp <= after:
            self._take()
        return self._newest

    def track(self, workspace: Target, now: float) -> GraspEstimate | None:
        """Track one grasp from frame to frame.

        Args:
            workspace: of the grasp.
            now: session time [s].

        Returns:
            The grasp; None if none is seen, or frames are missing. A locked grasp stays.
        """
        detection, frame, newest = self.detect(workspace), self.frame, self._newest
        if self._is_lost(now):
            if not self.tracker.locked:
                self.reset(self._oRa)
        elif detection is not None and frame is not None and newest is not None:
            if frame.stamp >= self._known_since:
                driven = float(np.linalg.norm(newest.oTc.translation - frame.oTc.translation))
                age = now - frame.stamp
                self.grasp = self.tracker.update(detection, frame.oTc, age=age, driven=driven)
            else:
                self._memory = SceneMemory()  # that frame is outdated
        return self.grasp

    def waits_for_search(self, since: float, now: float) -> bool:
        """Whether no frame of after session time `since` [s] was searched, though there are some.

        The computer is slow then: that no grasp is known says nothing of what is to be seen.
        """
        return self._searched_until <= since and not self._is_lost(now)

    def _is_lost(self, now: float) -> bool:
        """Whether there is no frame that could be believed at session time `now` [s]."""
        newest = self._newest
        return newest is None or now - newest.stamp > _LOST_FRAME or self._mistake != ""

    def blindness(self, now: float) -> str:
        """Why there is no valid frame at session time `now` [s]; empty if there is one."""
        late = inf if self._newest is None else now - self._newest.stamp
        if -_AHEAD <= late <= _OLDEST_FRAME:
            return ""
        if self._mistake or late < 0.0:
            return self._mistake or "frames are stamped ahead of the clock"
        return f"frames come {late:.2f} s late" if late <= _LOST_FRAME else "no camera frame"

    def reject(self) -> None:
        """Reject the tracked grasp in future."""
        if self.grasp is not None:
            self.tracker.reject(self.grasp.oTg)

    def reset(self, oRa: Array | None = None) -> None:
        """Stop tracking, and forget earlier frames; grasps are then straight down in axes `oRa`."""
        if self._searched is not None and self._result is not None:
            self._searched = self._searched[0], None
        self._oRa = oRa
        self.tracker.reset()
        self.grasp = None
        self._memory = SceneMemory()

    def relocalise(self, now: float) -> None:
        """Drop all grasps of frames before session time `now` [s]."""
        self._known_since = now
        self._judge.relocalise()
        self.reset(self._oRa)

    def _take(self) -> DepthFrame | None:
        """The camera's newest frame if it is new in this tick and plausible."""
        if not self._is_new:
            with self.timed():
                frame = self._camera.latest(inf)
                if frame is not self._delivered:
                    self._delivered = frame
                    self._mistake = "" if frame is None else self._judge.mistake(frame)
                    self._is_new = not self._mistake
                    self._newest = frame if self._is_new else self._newest
        return self._newest if self._is_new else None
