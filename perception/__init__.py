"""From a depth frame to a tracked grasp.

`GraspDetector` turns one depth frame into ranked grasps in odometry: a network proposes
candidates, which are refined and tested for feasibility on the measured depth. `GraspTracker`
tracks one grasp over frames.
"""

from typing import TYPE_CHECKING

from perception.objects.detected_object import DetectedObject, DetectedObjects

if TYPE_CHECKING:
    from perception.face import *
else:

    def __getattr__(name: str) -> object:
        import perception.face

        return getattr(perception.face, name)
