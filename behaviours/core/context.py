"""The context that the leaves of one tree share: inputs of the tick, and its motion goal."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import degrees, hypot, radians
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from py_trees.behaviour import Behaviour

from behaviours.core.directions import DOWN, ApproachWord, Direction
from behaviours.core.fault_memory import FaultMemory
from behaviours.core.held_object import HeldObject, SetDownObjects
from behaviours.core.log import TaskLog
from behaviours.core.parameter_types import Key, MapPlace, Region, ToolPose
from behaviours.core.placed_object import PlacedObjectWatch
from behaviours.core.reachable_directions import region_direction, sideways, tilted_if_needed
from behaviours.sensing.depth_obstacles import NO_POINTS, DepthObstacles
from behaviours.sensing.laser_obstacles import LaserObstacles
from behaviours.sensing.localisation import Localiser
from behaviours.sensing.on_map import CloudOnMap
from behaviours.sensing.vision import Vision
from controller import (
    Array,
    MotionGoal,
    Obstacle,
    PointCloud,
    PoseGoal,
    RobotModel,
    StepReport,
    Surroundings,
)
from hw import Robot, RobotState, TaskClock
from perception import DetectedObject
from robots import Geom

_DISTANCE, _TURN = 0.03, radians(2.0)  # a larger difference is a jump [m, rad] ...
_WINDOW = 0.25  # ... within this time [s]
_CORRECTION, _CORRECTION_TURN = 0.1, radians(8.0)  # a larger jump may be an error [m, rad]
_SCAN_AGE = 0.3  # of a scan whose points are obstacles [s]


class _Reading(NamedTuple):
    stamp: float
    wTb: SE3
    oTb: SE3
    """Dead reckoning: the integral of the measured twists."""


class Relocalisation:
    """Compares the localised base pose with dead reckoning over a short window.

    A jump of the localisation may be spread over several readings. A gap between two readings
    starts a new window.
    """

    def __init__(self) -> None:
        self._readings: deque[_Reading] = deque()
        self._twist = np.zeros(3)
        self.was_large = False
        """Whether the last jump was too large for a correction: it may be an error."""

    def note(self, state: RobotState) -> str:
        """Take a reading.

        Returns:
            A message if the base was relocalised, else empty.
        """
        oTb = SE3.Identity()
        if self._readings:
            last = self._readings[-1]
            passed = state.stamp - last.stamp
            if not 0.0 <= passed <= _WINDOW:
                self._readings.clear()
            else:
                vx, vy, w = passed * (self._twist + state.base_twist) / 2.0
                oTb = last.oTb * pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, w]))
        self._twist = state.base_twist
        self._readings.append(_Reading(state.stamp, state.wTb, oTb))
        while state.stamp - self._readings[0].stamp > _WINDOW:
            self._readings.popleft()
        first = self._readings[0]
        jump = (first.wTb * first.oTb.actInv(oTb)).actInv(state.wTb)
        distance = hypot(*jump.translation.tolist())
        turn = hypot(*pin.log3(jump.rotation).tolist())
        if distance <= _DISTANCE and turn <= _TURN:
            return ""
        self._readings.clear()
        self.was_large = distance > _CORRECTION or turn > _CORRECTION_TURN
        return f"the base was relocalised by {distance:.2f} m and {degrees(turn):.0f}°"


@dataclass(kw_only=True, eq=False)
class Context:
    """Given to every leaf when the tree is built; the session updates it.

    The session writes `state` and `report` before a tick and takes `goal` after it. Leaves write
    `goal`; of the robot they use the fingers and the recovery from faults, never its motion.
    """

    robot: Robot
    model: RobotModel
    clock: TaskClock
    """Of the task: it stops while the task is paused."""
    vision: Vision
    state: RobotState
    """Reading of this tick, in the world of the odometry."""
    localisation: Localiser = field(default_factory=Localiser)
    """Where the map is in that world."""
    began_at: float = 0.0
    """Time of day at the beginning of the session's clock, since midnight [s]."""
    relocalised: str = ""
    """A message if the localised base pose has jumped since the last tick, so that world positions
    are outdated; else empty."""
    lost: bool = False
    """Whether the jump was too large to trust the pose of the base; never of one with odometry."""
    goal: MotionGoal | None = None
    """For the coming period; None comes to rest."""
    goal_of: tuple[object, str] | None = None
    """The leaf that set the goal, and its phase."""
    letting_go: Behaviour | None = None
    """The leaf that has last opened the fingers to let go of what they hold."""
    report: StepReport | None = None
    """Of the controller about the last goal."""
    report_of: tuple[object, str] | None = None
    """The leaf that set the last goal, and its phase."""
    fixtures: tuple[Geom, ...] = ()
    """Static obstacles, on the map."""
    obstacles: Callable[[float], Sequence[Obstacle]] = lambda stamp: ()
    """Moving obstacles on the map, at a time of the session's clock [s]."""
    depth_obstacles: DepthObstacles | None = None
    """Obstacles seen by the camera; None where that is switched off."""
    follows_goals: bool = True
    """Whether a moving goal is followed; else the first grasp that is seen is kept."""
    set_down: SetDownObjects = field(default_factory=SetDownObjects)
    placed_object: PlacedObjectWatch | None = None
    """Checks whether the last released object stands at its place."""
    log: TaskLog = field(default_factory=TaskLog)
    keys: dict[str, Key[object]] = field(default_factory=dict)
    """Every key of the tree, by its path: those of a subtree after the name of its node."""

    def __post_init__(self) -> None:
        self.log.note_width(self.state, self.robot.description.gripper.opening)
        self._held = HeldObject(self.log)
        self._relocalisation = Relocalisation()
        self._jump = self._relocalisation.note(self.state)
        self.fault_memory = FaultMemory(self.robot.description)
        self._joined = self.fixtures, self.fault_memory.hit, self.fixtures
        self._cloud = CloudOnMap()
        self._laser_obstacles = LaserObstacles()
        self._seen: tuple[PointCloud, Array, PointCloud] = NO_POINTS, np.zeros((0, 3)), NO_POINTS
        self._places: dict[int, tuple[MapPlace, MapPlace]] = {}
        self._regions: list[tuple[Region, Direction]] = []

    def on_map(self, place: MapPlace) -> MapPlace:
        """A pose or region of the task where the map is; the same object for the same one."""
        if id(place) not in self._places:
            self._places[id(place)] = place, replace(place, frame=self.localisation)
        return self._places[id(place)][1]

    def direction(
        self, to: Region | DetectedObject, word: ApproachWord = "auto", least_tilt: float = 0.0
    ) -> Direction:
        """On the map, see `region_direction`; straight down if the hand gets there in none.

        It may take seconds: leaves ask when they are made. To an object the hand comes as into its
        region, which is known during the run; see `direction_now`.
        """
        if not isinstance(to, Region):
            return DOWN
        robot = self.robot.description
        found = region_direction(robot, self.fixtures, to, word, least_tilt) or DOWN
        self._regions.append((to, found))
        return found

    def sideways(self, direction: Direction, point: Array) -> Iterator[Direction | None]:
        """See `reachable_directions.sideways`; the point is in the world."""
        on_map = self.to_map(SE3(np.eye(3), point)).translation
        return sideways(self.robot.description, self.fixtures, direction, on_map)

    def direction_now(self, to: Region | DetectedObject, on_map: Direction = DOWN) -> Direction:
        """In the world: one on the map for a region, or for an object that of its region."""
        if isinstance(to, Region):
            return on_map.turned(to.wTm)
        for region, direction in self._regions:
            if region.contains(to.position[None])[0]:
                return direction.turned(region.wTm)
        return DOWN

    def reached(self, pose: ToolPose, within: float) -> ToolPose:
        """The pose, tilted where no stance reaches it as it is; see `tilted_if_needed`."""
        return tilted_if_needed(self.robot.description, self.fixtures, pose, within)

    @property
    def surroundings(self) -> Surroundings:
        """Obstacles and held object of this tick, on the map."""
        return Surroundings(
            fixtures=self._around(),
            moving=tuple(self.obstacles(self.state.stamp)),
            loose=self.set_down.shapes,
            depth_points=self.depth_points,
            held=self.held,
            wTo=self.localisation.mTw,
            uncertainty=self.localisation.uncertainty,
        )

    @property
    def depth_points(self) -> PointCloud | None:
        """What camera and laser have seen, on the map; None where neither is used.

        The laser's points count where the map may be wrong about its furniture or the base.
        """
        camera = self.depth_obstacles
        if camera is None and self.localisation.mTw is None:
            return None
        both = NO_POINTS if camera is None else camera.cloud, self._laser_obstacles.points
        if self._seen[0] is not both[0] or self._seen[1] is not both[1]:
            points = np.concatenate([both[0].points, both[1]])
            self._seen = *both, PointCloud(points) if len(both[1]) else both[0]
        return self._cloud(self._seen[2], self.localisation)

    def _around(self) -> tuple[Geom, ...]:
        """Fixtures and contacts on the map; the same tuple until one of them changes."""
        fixtures = self.localisation.furniture.standing(self.fixtures)
        hit = self.fault_memory.hit
        if self._joined[0] is not fixtures or self._joined[1] is not hit:
            self._joined = fixtures, hit, (fixtures + hit if hit else fixtures)
        return self._joined[2]

    def _moving(self) -> list[Obstacle]:
        """Moving obstacles, in the world."""
        moving, wTm = self.obstacles(self.state.stamp), self.localisation.wTm
        if wTm is None:
            return list(moving)
        return [Obstacle(one.geom.moved(wTm), wTm.rotation @ one.velocity) for one in moving]

    @property
    def held(self) -> tuple[Geom, ...]:
        """The shapes of the held object, in e; the same tuple until it changes."""
        return self._held.shape(self.log.fingers.width)

    @property
    def wTe(self) -> SE3:
        """End effector in the world, as read this tick."""
        return self.model.wTe(self.state.wTb, self.state.q)

    def to_map(self, wT: SE3) -> SE3:
        """Where a pose of the world is on the map now."""
        mTw = self.localisation.mTw
        return wT if mTw is None else mTw * wT

    def drift(self) -> Callable[[], SE3] | None:
        """From now on tells where what was in the world is in it by then; None: in its place."""
        here, mTw = self.localisation, self.localisation.mTw
        if mTw is None:
            return None
        return lambda: SE3.Identity() if here.wTm is None else here.wTm * mTw

    def read(self, state: RobotState) -> None:
        """Take a reading without a tick of the tree, as while the run is paused."""
        self.state = state
        if relocalised := self.localisation.relocalised:
            self.log.say(self.clock.now(), relocalised)
        self.localisation.read(state)
        for wrong in state.complaints:
            self.log.warn(self.clock.now(), f"skipped: {wrong}")
        self.log.note_width(state, self.robot.description.gripper.opening)
        self._jump = relocalised or self._relocalisation.note(state) or self._jump
        moving = self._moving() if state.faults else ()
        at_work = isinstance(self.goal, PoseGoal) and self.goal.hand_may_touch
        mTw = self.vision.tracker.mTw = self.to_map(SE3.Identity())
        self.fault_memory.note(state, self.wTe, self.clock.now(), moving, mTw=mTw, at_work=at_work)

    def begin_tick(self, state: RobotState) -> None:
        """Take a reading; without a new goal the robot will come to rest."""
        self.read(state)
        self.relocalised, self._jump = self._jump, ""
        is_localised = self.localisation.mTw is None
        self.lost = bool(self.relocalised) and is_localised and self._relocalisation.was_large
        if self.relocalised:
            self.set_down.forget()
            self.fault_memory.relocalise()
        self.goal, self.goal_of = None, None
        self.vision.begin_tick()
        self.localisation.look(self.robot, self.vision)
        if wrong := self.localisation.wrong:
            self.log.warn(self.clock.now(), wrong)
        if self.localisation.mTw is not None:
            walkers = [one.geom for one in self._moving()]
            self._laser_obstacles.look(self.robot.laser.latest(_SCAN_AGE), walkers)
        if self.depth_obstacles is not None:
            if self.relocalised:
                self.depth_obstacles.relocalise(state.stamp)
            moving = [one.geom for one in self._moving()]
            self.depth_obstacles.look(self.vision, state, self.held, moving)
        if self.placed_object is not None:
            self.placed_object.look(self)

    def end_tick(self, report: StepReport) -> None:
        """Take the report of the controller about the goal of the tick."""
        self.report, self.report_of = report, self.goal_of
