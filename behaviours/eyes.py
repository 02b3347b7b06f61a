"""The wrist camera and what perception makes of it, looked at only when a behaviour asks."""

from __future__ import annotations

from hw import DepthFrame, Robot, stopwatch
from perception import Detection, GraspDetector, GraspEstimate, GraspTracker, Workspace


class Eyes:
    """Newest frame, detection and tracked grasp of one robot.

    Args:
        robot: whose camera.
        detector: the network with its pre- and post-processing.
    """

    def __init__(self, robot: Robot, detector: GraspDetector) -> None:
        self._robot = robot
        self._detector = detector
        self.tracker = GraspTracker()
        self.frame: DepthFrame | None = None
        """The newest frame that was looked at."""
        self.detection: Detection | None = None
        """What was found in it."""
        self.grasp: GraspEstimate | None = None
        """The grasp that is followed, if any."""
        self.seconds = 0.0
        """Real time spent on looking so far [s]."""

    def look(self, workspace: Workspace) -> Detection | None:
        """Detect grasps in the newest frame; None if there is no new one."""
        begun = stopwatch()
        frame = self._robot.depth()
        if frame is None:
            return None
        self.frame = frame
        self.detection = self._detector.detect(frame, workspace)
        self.seconds += stopwatch() - begun
        return self.detection

    def follow(self, workspace: Workspace) -> GraspEstimate | None:
        """Follow one grasp from frame to frame; None if it is not, or no longer, seen."""
        detection = self.look(workspace)
        if detection is not None and self.frame is not None:
            self.grasp = self.tracker.update(detection, self.frame.wTc)
        return self.grasp

    def reject(self) -> None:
        """Remember the followed grasp as one that failed."""
        if self.grasp is not None:
            self.tracker.reject(self.grasp.wTg)

    def lose(self) -> None:
        """Follow no grasp any longer."""
        self.tracker.reset()
        self.grasp = None
