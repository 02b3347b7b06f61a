"""What a grasp is looked for on, and other views of it.

Any object in a region, or one that is chosen once and then followed.
"""

from collections.abc import Callable, Iterator

import numpy as np
from pinocchio import SE3
from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.directions import Direction
from behaviours.core.leaf import Leaf
from behaviours.core.parameter_types import Region
from behaviours.core.reachable_directions import sideways
from behaviours.views.objects import Choice, Chosen, ObjectDetection, detect_once, neighbours
from behaviours.views.survey import finding_place, views
from behaviours.views.viewpoint import MoveCamera, camera_pose, looking_along
from config import counted
from config.arrays import Array, Mask
from perception import DetectedObject, GraspEstimate

DOUBTFUL = 0.1  # grasp quality below which an attempt looks again ...
_DOUBTFUL_TILTED = 0.5  # ... and that of a tilted hand, which may come from another side
LOOKS = 2  # attempts look again this often, where no grasp, or a doubtful one, is seen
LOOK_HEIGHT = 0.4  # distance of the camera then [m]
_BESIDE = 0.3  # ... and when it looks from a side, from where it reaches less far [m]
_VIEW = 0.36  # side of the part of a region that it shows then [m]


class _InView:
    """A region where the newest frame shows the furniture around it, as a `Target`."""

    def __init__(self, context: Context, region: Region) -> None:
        self._context, self._region = context, region

    @property
    def floor(self) -> float:
        """Height of its floor in odometry [m]."""
        return self._region.floor

    def contains(self, points: Array) -> Mask:
        """Which of (N, 3) points in odometry [m] lie inside."""
        return self._region.contains(points)

    def locate(self) -> Callable[[], Region]:
        """How it stands in odometry now."""
        region, frame = self._region, self._context.vision.newest(-np.inf)
        if frame is None:
            return region.locate()
        place = finding_place(self._context, region, frame)
        return lambda: region.at(place().oTr)


class GraspTarget:
    """What `grasp` looks for grasps on.

    Args:
        context: shared by the leaves.
        within: a region, or a detected object.
        choice: among the objects of a region.
        neighbour: take what stands beside the chosen object instead.
    """

    def __init__(
        self,
        context: Context,
        within: Region | DetectedObject,
        choice: Choice,
        *,
        neighbour: bool = False,
    ) -> None:
        self._context, self._within, self._choice = context, within, choice
        self._neighbour = neighbour
        self._detection = None
        self._in_view = _InView(context, within) if isinstance(within, Region) else None
        if isinstance(within, Region) and not choice.is_free:
            self._detection = ObjectDetection(context, within, choice)
        self.begin()

    def begin(self, since: float = -np.inf) -> None:
        """Choose again, by frames from session time `since` [s] on."""
        self.reason = ""
        """Why nothing is chosen; empty if something is, or no frame has come yet."""
        self._chosen: Chosen | None = None
        if self._detection is not None:
            self._detection.begin(since)
        if isinstance(self._within, DetectedObject):
            self._chosen = Chosen(objects=(self._within,))

    def track(self, now: float) -> GraspEstimate | None:
        """The grasp that `Vision.track` follows on it; None if nothing is chosen.

        Args:
            now: session time [s].
        """
        vision = self._context.vision
        if self._in_view is not None and self._choice.is_free:
            return vision.track(self._in_view, now)
        if self._chosen is None and self._detection is not None:
            self._choose(self._detection)
        if self._chosen is None:
            return None
        return vision.track(self._chosen, now)

    def centre(self) -> Array | None:
        """(3,) of the target, the largest of several, in the newest frame and the world [m]."""
        state = self._context.state
        frame, base = self._context.vision.picture(state.stamp), state.oTb.translation
        if self._chosen is not None:
            return self._chosen.objects[0].position
        if frame is None or not isinstance(self._within, Region):
            return None
        with self._context.vision.timed():
            objects = detect_once(self._context, frame, self._within, self._choice)
        if isinstance(objects, str):
            return None
        fitting = self._choice.fitting(objects, base)
        return max(fitting, key=lambda one: one.area).position if fitting else None

    def _choose(self, detection: ObjectDetection) -> None:
        objects = detection.update()
        if objects is None:
            return
        if isinstance(objects, str):
            self.reason = objects
            return
        fitting = self._choice.fitting(objects, self._context.state.oTb.translation)
        if not fitting:
            seen = counted(len(objects), "object")
            self.reason = f"{self._choice} is not among the {seen} in sight"
            return
        is_one = self._choice.choose != "best"
        meant = fitting[:1] if is_one else fitting
        if self._neighbour and not (meant := neighbours(meant[0], objects)):
            self.reason = "nothing stands beside what is meant"
            return
        others = tuple(one for one in objects if one not in meant)
        self._chosen, self.reason = Chosen(objects=tuple(meant), others=others), ""


class OtherViews:
    """Views of the target, or of a region in which nothing is seen.

    From the second view on, a tilted hand looks from the sides from which it gets to what is there.

    Args:
        leaf: sets the goals and gets the feedback message.
        target: what is looked at.
        within: the region, or the object.
        way: direction of the camera on the map.
        timeout: to reach a view [s].
    """

    def __init__(
        self,
        leaf: Leaf,
        target: GraspTarget,
        within: Region | DetectedObject,
        way: Direction,
        timeout: float,
    ) -> None:
        self._leaf, self._target, self._timeout = leaf, target, timeout
        self._within, self._way = within, way
        self._turned = leaf.context.direction_now(within, way)
        self._begun = self._has_sides = False
        # Straight down, the way point of the task shows what a hand can reach.
        self._parts: list[Array] = []
        if isinstance(within, Region) and not way.is_straight:
            self._parts, self._has_sides = views(within, _VIEW), within.front is None
        self._left = LOOKS + self._has_sides

    @property
    def oRa(self) -> Array | None:
        """(3, 3) the axes of the present direction; None for straight down."""
        return None if self._turned.is_straight else self._turned.rotation

    @property
    def doubtful(self) -> float:
        """The grasp quality below which another view is worth its time."""
        return DOUBTFUL if self.oRa is None else _DOUBTFUL_TILTED

    def begin(self, point: Array | None = None) -> bool:
        """Start to look at a point (3,) in odometry [m]; whether there is another view.

        None is the target, or the next part of a region in which nothing is seen.
        """
        context = self._leaf.context
        if point is None and context.vision.picture(context.state.stamp) is not None:
            point = self._target.centre()
            if point is None and self._parts:
                point = self._parts.pop(0)
        if point is None or self._left == 0:
            return False
        self._left -= 1
        self._point = point
        self._camera: MoveCamera | None = None
        if not (self._begun and self._has_sides):
            self._ways: Iterator[Direction | None] = iter((self._way,))
        elif self._left == LOOKS - 1:
            robot, fixtures = context.robot.description, context.around.fixtures
            on_map = context.to_map(SE3(np.eye(3), point)).translation
            self._ways = sideways(robot, fixtures, self._way, on_map)
        self._begun = True
        return True

    def begin_if_lost(self, target: Array) -> bool:
        """Start to look at a grasp (3,) that was lost on the way to it; whether that is so.

        It is not locked at its next sight from near. Without a grasp, `target` is infinite.
        """
        is_lost = self.oRa is not None and bool(np.isfinite(target).all())
        return is_lost and self.begin(target)

    def tick(self) -> Status:
        """RUNNING until the camera is as near as it gets; FAILURE if no way leads there."""
        leaf = self._leaf
        if self._camera is None:
            try:
                way = next(self._ways)
            except StopIteration:
                self._left = 0
                return leaf.failure("it is not reached from another side")
            if way is None:
                return leaf.running("looking for another way to it")
            self._turned = leaf.context.direction_now(self._within, way)
            distance = LOOK_HEIGHT if way is self._way else _BESIDE
            like = camera_pose(leaf.context)
            oTc = looking_along(self._turned, self._point, distance, like=like)
            self._camera = MoveCamera(leaf, lambda: oTc, "another view", self._timeout)
        return self._camera.tick()
