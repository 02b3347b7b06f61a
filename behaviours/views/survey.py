"""Surveys of a region: pictures from one or more viewpoints, as one map."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import ceil

import numpy as np
from pinocchio import SE3
from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.directions import DOWN, Direction
from behaviours.core.leaf import Leaf
from behaviours.core.motion import Approach
from behaviours.core.parameter_types import Region
from behaviours.core.reachable_directions import headings_into, is_high, reached
from behaviours.views.viewpoint import CAMERA_PATIENCE, camera_pose, hand_for, looking_along
from config import counted
from controller import PoseGoal
from hw import DepthFrame
from perception import RegionMap
from perception.registration import Place, place_in_image

VIEW_HEIGHT = 0.45  # of the camera over the floor [m]
LEAST_SEEN = 0.98  # share of a region that must be seen to call it empty
_LEAST_SEEN_AROUND_OBJECTS = 0.9  # the same to count objects, which hide a part
_MOST_OVERLOOKED = 0.01  # a region where higher objects may be overlooked is not empty [m]
_WIDTH_PER_HEIGHT = 0.8  # of the square that one picture shows well, per height of the camera
_MOVED = 0.008  # by which a region moves on what was seen of it, so that it is mapped anew [m]
_CERTAIN = 0.02  # uncertainty of the base beyond which a registration is awaited [m], ...
_AWAITED = 0.5  # ... this long at most [s]
SMALLEST = 1e-4  # an unseen part of a region that covers less does not count [m^2]
_BEHIND = 3  # views of what was hidden from the others
_BEYOND = 0.1  # so far beyond a hidden part, as seen from what stands before it, is looked down [m]
_STILL = 1e-4  # uncertainty of a base that is exact [m, rad]
_CELL, _STRIDE = 0.003, 2  # of a map in which objects are counted [m, pixels]
_PICTURES = 3  # from each viewpoint, which must agree
_GLANCE_CELL, _GLANCE_STRIDE = 0.008, 3  # of a map that is made within every tick [m, pixels]


class Survey:
    """Takes pictures of a region from one viewpoint after the other.

    Args:
        leaf: sets the goals and gets the feedback message.
        region: whose floor is surveyed.
        smallest: an unseen part that covers less than this does not count [m^2].
        from_here: begin with the present viewpoint.
        directions: of the other viewpoints on the map, see `view_directions`.
        height: of the camera over the floor, in the other viewpoints [m].
        timeout: to reach a viewpoint [s].
        patience: without a picture [s].
    """

    def __init__(
        self,
        leaf: Leaf,
        region: Region,
        *,
        smallest: float,
        from_here: bool,
        directions: Sequence[Direction],
        height: float = VIEW_HEIGHT,
        timeout: float = 30.0,
        patience: float = CAMERA_PATIENCE,
    ) -> None:
        self._leaf, self._region, self._directions = leaf, region, directions
        self._height, self._timeout = height, timeout
        self._smallest, self._patience = smallest, patience
        self._like = camera_pose(leaf.context)
        self._next = 0
        self._behind: list[np.ndarray] = []  # (3,) points of the region to look at, too
        self._approach: Approach | None = None
        self._there = from_here
        if not from_here:
            self.another_view()
        self._begin()

    def _begin(self) -> None:
        self._seen: list[tuple[DepthFrame, Place]] = []
        self._since = self._leaf.context.state.stamp
        self._map_anew()
        self._arrive()

    def _map_anew(self) -> None:
        """Where a picture shows the region is told best by then, or by what is known now."""
        context, region = self._leaf.context, self._region
        self._seen = [
            (frame, min(place_of(context, region, frame), then, key=_tolerance))
            for frame, then in self._seen
        ]
        self.map, self._oTr = region_map(context, region), region.oTr
        for frame, place in self._seen:
            self.map.add(frame, place)

    def _arrive(self) -> None:
        context = self._leaf.context
        self._taken, self._waiting_since = 0, context.clock.now()
        self._registrations = context.localisation.registrations

    @property
    def unseen(self) -> str:
        """What was not seen of the region; empty if all that matters was."""
        return unseen(self.map, self._region, self._smallest)

    def tick(self) -> Status:
        """SUCCESS when the pictures of a viewpoint are taken, FAILURE if that is impossible."""
        leaf = self._leaf
        if fault := leaf.fault():
            return leaf.failure(fault)
        moved = np.linalg.norm(self._region.oTr.translation - self._oTr.translation) > _MOVED
        if leaf.context.now.relocalised:
            self._begin()  # what was seen is not where it was
        elif moved:
            self._map_anew()
        if not self._there:
            status = self._go()
            if status is Status.FAILURE and self._behind:  # what is hidden stays so
                return leaf.success(f"looked at {self._region.name}")
            if status is not Status.SUCCESS:
                return status
            self._there = True
            self._arrive()
        return self._take_pictures()

    def another_view(self) -> bool:
        """Go to the next viewpoint, or over what is hidden from all; whether there is one."""
        if self._next == len(self._views()):
            hidden = self.map.hidden(self._smallest)
            if not hidden or len(self._behind) == _BEHIND:
                return False
            part = max(hidden, key=lambda one: one.area).centre
            before = [part - one.centre for one in self.map.segments(self._smallest)]
            away = min(before, key=lambda way: float(way @ way), default=np.zeros(3))
            beyond = part + _BEYOND * away / max(float(np.linalg.norm(away)), _BEYOND)
            self._behind.append(self._region.oTr.actInv(beyond))
        self._next += 1
        self._approach, self._there = None, False
        return True

    def _views(self) -> list[np.ndarray]:
        behind = [self._region.oTr.act(point) for point in self._behind]
        return views(self._region, _WIDTH_PER_HEIGHT * self._height) + behind

    def _go(self) -> Status:
        if self._approach is None:
            every = self._views()
            known = min(self._next, len(self._directions))
            direction = self._directions[known - 1].turned(self._region.oTm)
            point = every[self._next - 1]
            oTc = looking_along(direction, point, self._height, like=self._like)
            target = f"view {self._next} of {len(every)} of {self._region.name}"
            goal = PoseGoal(target=hand_for(self._leaf.context, oTc))
            self._approach = Approach(self._leaf, lambda: goal, target, self._timeout)
        return self._approach.tick()

    def _take_pictures(self) -> Status:
        """One tick at a viewpoint; no goal is set, so the hand comes to rest."""
        leaf, context = self._leaf, self._leaf.context
        vision, now = context.vision, context.clock.now()
        frame = vision.new_frame()
        blindness = vision.blindness(context.state.stamp)
        awaited = self._taken >= _PICTURES
        if not awaited and frame and frame.stamp >= self._since and not blindness:
            with vision.timed():
                place = place_of(context, self._region, frame)
                self.map.add(frame, place)
            self._seen.append((frame, place))
            self._taken, self._waiting_since = self._taken + 1, now
        elif not awaited and now - self._waiting_since > self._patience:
            return leaf.failure(blindness or "no camera frame")
        if self._taken < _PICTURES:
            return leaf.running(f"looking at {self._region.name}, {counted(self._taken, 'image')}")
        here = context.localisation
        vague = here.uncertainty > _CERTAIN and here.registrations == self._registrations
        if (vague or here.pending > _MOVED) and now - self._waiting_since < _AWAITED:
            return leaf.running("waiting to know better where the base is")
        return leaf.success(f"looked at {self._region.name}")


def view_directions(
    context: Context, region: Region, height: float = VIEW_HEIGHT
) -> tuple[Direction, ...]:
    """The direction of each viewpoint of a survey, on the map; it may take seconds.

    Straight down, or with the least tilt for which a stance reaches it.
    """
    context.direction(region)  # in which what is found there is come to
    points = views(replace(region, frame=None), _WIDTH_PER_HEIGHT * height)
    if not is_high(region, context.around.fixtures):
        return (DOWN,) * len(points)
    robot, start = context.robot.description, SE3.Identity()

    def best(point: np.ndarray) -> Direction:
        def hand(direction: Direction) -> SE3:
            return hand_for(context, looking_along(direction, point, height, like=start))

        headings = headings_into(region)
        return next(reached(robot, context.around.fixtures, headings, hand), DOWN)

    return tuple(best(point) for point in points)


def place_of(context: Context, region: Region, frame: DepthFrame) -> Place:
    """Where a frame shows a region, by the furniture that it shows around it."""
    return finding_place(context, region, frame)()


def finding_place(context: Context, region: Region, frame: DepthFrame) -> Callable[[], Place]:
    """What `place_of` returns when it is called, which takes milliseconds and needs no context."""
    here, state = context.localisation, context.state
    covariance = np.diag(np.square([_STILL, _STILL, _STILL]))
    covariance += here.furniture.covariance(region.on)
    if here.estimate is not None:
        covariance = covariance + here.estimate[1] + np.diag([here.pending**2] * 2 + [0.0])
    find = partial(
        place_in_image,
        frame,
        region.oTr,
        region.size,
        furniture=here.furniture.standing(context.around.fixtures),
        oTb=state.oTb,
        mTb=context.to_map(state.oTb),
        covariance=covariance,
        moved=region.on if region.on in here.furniture.names else "",
    )
    return find if here.estimate is not None else lambda: find()._replace(tolerance=np.zeros(2))


def _tolerance(place: Place) -> float:
    return float(np.linalg.norm(place.tolerance))


def region_map(context: Context, region: Region, *frames: DepthFrame) -> RegionMap:
    """A map of a region that is fine enough to count objects."""
    seen = RegionMap(region.oTr, region.size, _CELL, _STRIDE)
    for frame in frames:
        seen.add(frame, place_of(context, region, frame))
    return seen


def note_fallen(context: Context, frame: DepthFrame) -> None:
    """Count again where an object fell back, if a frame shows it."""
    for stock in context.log.stocks.values():
        if stock.fell:
            seen = region_map(context, stock.region, frame)
            if not unseen(seen, stock.region, SMALLEST):
                context.log.note_stock(stock.region, seen.pieces)


def glance(context: Context, region: Region, frame: DepthFrame) -> RegionMap:
    """A coarse map of a region, fast enough for every tick."""
    seen = RegionMap(region.oTr, region.size, _GLANCE_CELL, _GLANCE_STRIDE)
    seen.add(frame, place_of(context, region, frame))
    return seen


def unseen(
    seen: RegionMap, region: Region, smallest: float, *, whole: bool = False, narrowest: float = 0.0
) -> str:
    """What a map does not show of a region; empty if that cannot hide an object.

    Objects hide a part of the floor; without objects, nothing may be hidden.

    Args:
        seen: the map.
        region: of the map.
        smallest: a part that covers less than this does not count [m^2].
        whole: whether what objects hide matters, too.
        narrowest: shorter edge of an object that matters [m].
    """
    if not whole and seen.segments(smallest) and seen.seen >= _LEAST_SEEN_AROUND_OBJECTS:
        return ""
    parts = seen.hidden(smallest, narrowest)
    if parts or (seen.seen < LEAST_SEEN and not narrowest):
        text = f"{100.0 * (1.0 - seen.seen):.0f} % of {region.name} not seen"
        if not parts:
            return text
        part = max(parts, key=lambda one: one.area)
        x, y, _ = region.oTr.actInv(np.asarray(part.centre))
        most = f"most of it ({1e4 * part.area:.0f} cm²) around {x:.2f}, {y:.2f}"
        return f"{text}, {most} from its middle"
    if seen.lowest > _MOST_OVERLOOKED:
        return f"what is lower than {1000 * seen.lowest:.0f} mm is not seen from so far"
    return ""


def views(region: Region, side: float) -> list[np.ndarray]:
    """Points (3,) on the floor of a region, in odometry, to look at one after the other.

    Args:
        region: squares around the points cover it.
        side: of a square [m].
    """
    columns, rows = (max(1, ceil(edge / side - 1e-9)) for edge in region.size[:2])
    x, y = (
        (np.arange(n) + 0.5) * edge / n - edge / 2.0
        for n, edge in ((columns, region.size[0]), (rows, region.size[1]))
    )
    down = -region.size[2] / 2.0
    return [
        region.oTr.act(np.array([x[column], y[row], down]))
        for row in range(rows)
        for column in (range(columns) if row % 2 == 0 else reversed(range(columns)))
    ]
