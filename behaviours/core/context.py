"""The context that the leaves of one tree share: what is now, around, and remembered."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple, Protocol

from pinocchio import SE3
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from behaviours.core.around import Around
from behaviours.core.directions import DOWN, ApproachWord, Direction
from behaviours.core.errors import TwoGoalsError
from behaviours.core.fault_memory import FaultMemory
from behaviours.core.held_object import HeldObject, SetDownObjects
from behaviours.core.log import TaskLog
from behaviours.core.parameter_types import MapPlace, Region
from behaviours.core.reachable_directions import region_direction
from behaviours.core.relocalisation import Relocalisation
from behaviours.sensing.localiser import EstimatedLocaliser, ExactLocaliser, Localiser
from behaviours.sensing.map_matching import MapMatching, MapSensors
from behaviours.sensing.vision import Vision
from config.poses import OdometryFromMap, OdometryPose
from controller import MotionGoal, PoseGoal, RobotModel, StepReport, Surroundings
from hw import LaserScan, Robot, RobotState, TaskClock
from perception import DetectedObject
from robots import Geom, RobotDescription


class Intent(NamedTuple):
    """What a leaf wants of the coming period."""

    goal: MotionGoal[OdometryPose]
    owner: Behaviour
    phase: str = ""  # of the owner


@dataclass(kw_only=True, eq=False)
class Now:
    """What is so in one tick; with every reading there is another one, so nothing is outdated."""

    state: RobotState  # the reading, in odometry
    relocalised: str = ""  # how the base has jumped: positions in odometry are outdated then
    lost: bool = False  # whether it jumped too far to be believed; never one with odometry
    intent: Intent | None = None  # what the leaves want; None comes to rest
    last: Intent | None = None  # what they wanted in the last tick
    report: StepReport | None = None  # of the controller about that

    def intend(self, intent: Intent) -> None:
        """Want something; TwoGoalsError: another running leaf does so in this tick."""
        other = self.intent.owner if self.intent else intent.owner
        if other is not intent.owner and other.status is Status.RUNNING:
            raise TwoGoalsError(
                f"`{other.name}` and `{intent.owner.name}` both move the robot at the same time; "
                "let one run after the other"
            )
        self.intent = intent


class Watch(Protocol):
    """What looks in every tick, whichever leaf runs."""

    def look(self, context: "Context") -> None:
        """Take what is so in this tick."""


class Memory:
    """What is remembered from tick to tick."""

    def __init__(self, robot: RobotDescription) -> None:
        self.log, self.faults = TaskLog(), FaultMemory(robot)
        self.set_down, self._held = SetDownObjects(), HeldObject(self.log)
        self.placed_object: Watch | None = None
        """Checks whether the last released object stands at its place."""
        self.letting_go: Behaviour | None = None
        """The leaf that has last opened the fingers to let go of what they hold."""

    @property
    def held(self) -> tuple[Geom, ...]:
        """The shapes of the held object, in e; the same tuple until it changes."""
        return self._held.shape


@dataclass(kw_only=True, eq=False)
class Context:
    """Given to every leaf when the tree is built; the session updates it.

    Leaves say by `Leaf.pursue` what they want; of the robot they use the fingers and the recovery
    from faults, never its motion.
    """

    robot: Robot
    model: RobotModel
    clock: TaskClock  # of the task: it stops while the task is paused
    vision: Vision
    now: Now
    around: Around = field(default_factory=Around)
    map_sensors: MapSensors = field(default_factory=MapSensors)
    """What is registered to the map, where the robot tells a localised pose."""

    def __post_init__(self) -> None:
        self.memory = Memory(self.robot.description)
        self.log.note_width(self.state, self.robot.description.gripper.opening)
        self.localisation: Localiser = ExactLocaliser()
        """Where the map is in odometry."""
        self._relocalisation = Relocalisation()
        self._jump = self._relocalisation.note(self.state)
        self._places: dict[int, tuple[MapPlace, MapPlace]] = {}
        self._regions: list[tuple[Region, Direction]] = []

    @property
    def state(self) -> RobotState:
        """The reading of this tick, in odometry."""
        return self.now.state

    @property
    def log(self) -> TaskLog:
        """The log of the task."""
        return self.memory.log

    @property
    def oTe(self) -> OdometryPose:
        """End effector in odometry, as read this tick."""
        return self.model.end_effector(self.state.oTb, self.state.q)

    @property
    def surroundings(self) -> Surroundings:
        """Obstacles and held object of this tick, on the map."""
        here, memory = self.localisation, self.memory
        return Surroundings(
            fixtures=self.around.standing(here, memory.faults.hit),
            moving=tuple(self.around.obstacles(self.state.stamp)),
            loose=memory.set_down.shapes,
            depth_points=self.around.points(here),
            held=memory.held,
            mTo=here.mTo,
            uncertainty=here.uncertainty,
        )

    def scan(self) -> LaserScan | None:
        """The newest scan; None if there is none to believe, see `around.scans`."""
        return self.around.scans.newest(self.robot.laser)

    def on_map(self, place: MapPlace) -> MapPlace:
        """A pose or region of the task where the map is; the same object for the same one."""
        if id(place) not in self._places:
            self._places[id(place)] = place, replace(place, frame=self)
        return self._places[id(place)][1]

    def oTm_on(self, piece: str) -> OdometryFromMap | None:
        """The map in odometry, see `Localiser`."""
        return self.localisation.oTm_on(piece)

    def to_map(self, oT: SE3) -> SE3:
        """Where a pose in odometry is on the map now."""
        mTo = self.localisation.mTo
        return oT if mTo is None else mTo * oT

    def drift(self) -> Callable[[], SE3] | None:
        """From now on tells where what was in odometry is in it by then; None: in its place."""
        here, mTo = self.localisation, self.localisation.mTo
        if mTo is None:
            return None
        return lambda: SE3.Identity() if here.oTm is None else here.oTm * mTo

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
        found = region_direction(robot, self.around.fixtures, to, word, least_tilt) or DOWN
        self._regions.append((to, found))
        return found

    def direction_now(self, to: Region | DetectedObject, on_map: Direction = DOWN) -> Direction:
        """In odometry: one on the map for a region, or for an object that of its region."""
        if isinstance(to, Region):
            return on_map.turned(to.oTm)
        for region, direction in self._regions:
            if region.contains(to.position[None])[0]:
                return direction.turned(region.oTm)
        return DOWN

    def read(self, state: RobotState) -> None:
        """Take a reading without a tick of the tree, as while the run is paused."""
        self.now = replace(self.now, state=state, relocalised="", lost=False, intent=None)
        log, now, opening = self.log, self.clock.now(), self.robot.description.gripper.opening
        if relocalised := self.localisation.relocalised:
            log.say(now, relocalised)
        if self.localisation.estimate is None and state.localised is not None:
            robot = self.robot.description
            matching = MapMatching(self.map_sensors, robot, self.vision, self.scan)
            self.localisation = EstimatedLocaliser(state, matching)
        else:
            self.localisation.read(state)
        for wrong in state.complaints:
            log.warn(now, f"skipped: {wrong}")
        log.note_width(state, opening)
        self._jump = relocalised or self._relocalisation.note(state) or self._jump
        moving = self.around.moving(state.stamp, self.localisation) if state.faults else ()
        goal = self.now.last.goal if self.now.last else None
        at_work = isinstance(goal, PoseGoal) and goal.hand_may_touch
        mTo = self.vision.tracker.mTo = self.to_map(SE3.Identity())
        self.memory.faults.note(state, self.oTe, now, moving, mTo=mTo, at_work=at_work)

    def begin_tick(self, state: RobotState) -> None:
        """Take a reading; unless a leaf wants something the robot will come to rest."""
        self.read(state)
        here, now, memory = self.localisation, self.now, self.memory
        now.relocalised, self._jump = self._jump, ""
        if now.relocalised:
            now.lost = here.mTo is None and self._relocalisation.was_large
            memory.set_down.forget()
            memory.faults.relocalise()
        self.vision.begin_tick()
        here.look()
        if warning := here.warning or self.around.scans.mistake:
            self.log.warn(self.clock.now(), warning)
        if now.relocalised and self.around.depth_obstacles is not None:
            self.around.depth_obstacles.relocalise(state.stamp)
        self.around.look(state, here, self.vision, self.scan, memory.held)
        if memory.placed_object is not None:
            memory.placed_object.look(self)

    def end_tick(self, report: StepReport) -> None:
        """Take the report of the controller about what was wanted in the tick."""
        self.now.last, self.now.report = self.now.intent, report
