"""The wrist camera and what perception makes of it, looked at only when a behaviour asks."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from hw import DepthFrame, Robot, stopwatch
from perception import Detection, GraspDetector, GraspEstimate, GraspTracker, Workspace

OLDEST_FRAME = 0.15
"""A frame older than this says nothing about where a grasp is now [s]."""


class Vision:
    """Newest frame, detection and tracked grasp of one robot.

    All leaves of a tick see the same frame, whichever asks first.

    Args:
        robot: whose camera.
        detector: the network with its pre- and post-processing.
    """

    def __init__(self, robot: Robot, detector: GraspDetector) -> None:
        self._robot = robot
        self._detector = detector
        self._fresh = False
        self.tracker = GraspTracker()
        self.frame: DepthFrame | None = None
        """The newest frame that was looked at."""
        self.detection: Detection | None = None
        """What grasps were found in it; None if nobody looked for any."""
        self.grasp: GraspEstimate | None = None
        """The grasp that is followed, if any."""
        self.seconds = 0.0
        """Real time spent on looking so far [s]."""

    def begin_tick(self) -> None:
        """From now on a newer frame counts as new."""
        self._fresh = False

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """What is computed inside counts as looking."""
        begun = stopwatch()
        yield
        self.seconds += stopwatch() - begun

    def new_frame(self) -> DepthFrame | None:
        """The frame that has come since the last tick; None if there is none."""
        if not self._fresh:
            with self.at_work():
                frame = self._robot.depth()
            if frame is not None:
                self._fresh, self.frame, self.detection = True, frame, None
        return self.frame if self._fresh else None

    def look(self, workspace: Workspace) -> Detection | None:
        """Detect grasps in the newest frame; None if there is no new one."""
        frame = self.new_frame()
        if frame is not None:
            with self.at_work():
                self.detection = self._detector.detect(frame, workspace)
        return None if frame is None else self.detection

    def follow(self, workspace: Workspace, now: float) -> GraspEstimate | None:
        """Follow one grasp from frame to frame.

        Args:
            workspace: where it has to be.
            now: the session's time [s].

        Returns:
            The grasp; None if it is not, or no longer, seen, or if the newest frame is too old to
            be believed. A locked grasp stays.
        """
        detection = self.look(workspace)
        if detection is not None and self.frame is not None:
            self.grasp = self.tracker.update(detection, self.frame.wTc)
        elif self.blind(now) and not self.tracker.locked:
            self.lose()
        return self.grasp

    def blind(self, now: float) -> bool:
        """Whether there is no frame, or only one that is too old to be believed."""
        return self.frame is None or now - self.frame.stamp > OLDEST_FRAME

    def reject(self) -> None:
        """Remember the followed grasp as one that failed."""
        if self.grasp is not None:
            self.tracker.reject(self.grasp.wTg)

    def lose(self) -> None:
        """Follow no grasp any longer."""
        self.tracker.reset()
        self.grasp = None
