"""What the leaves of one tree share: what they read, and the one motion goal that they leave."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from pinocchio import SE3

from behaviours.fault_memory import FaultMemory
from behaviours.held import Held
from behaviours.key import Key
from behaviours.log import TaskLog
from behaviours.relocalisation import Relocalisation
from behaviours.seen import SeenObstacles
from behaviours.set_down import SetDown
from behaviours.settings import BehaviourSettings
from behaviours.standing import StandingWatch
from behaviours.vision import Vision
from controller import MotionGoal, Obstacle, PoseGoal, RobotModel, StepReport, Surroundings
from hw import Robot, RobotState, TaskClock
from robots import Geom


@dataclass(kw_only=True, eq=False)
class Context:
    """Handed to every leaf when the tree is built; the session keeps it up to date.

    The session writes `state` and `report` before a tick and takes `goal` after it. Leaves write
    `goal`; of the robot they use the fingers and the recovery from faults, never its motion.
    """

    robot: Robot
    model: RobotModel
    clock: TaskClock
    """Of the task: it stands still while the task is paused."""
    vision: Vision
    state: RobotState
    """This tick's reading."""
    relocalised: str = ""
    """That the localised pose of the base has jumped since the last tick of the tree, in words;
    empty if it has not. What was known in the world before is not where it was."""
    lost: bool = False
    """Whether it has jumped by so much that it is not certain where the base is."""
    goal: MotionGoal | None = None
    """Where to go in the coming period; None comes to rest."""
    goal_of: tuple[object, str] | None = None
    """The leaf that left the goal, and its phase."""
    report: StepReport | None = None
    """The report of the controller about the last goal."""
    report_of: tuple[object, str] | None = None
    """The leaf whose goal the report is about, and its phase."""
    fixtures: tuple[Geom, ...] = ()
    """What is known to stand around the robot and never moves, in the world."""
    obstacles: Callable[[float], Sequence[Obstacle]] = lambda stamp: ()
    """What moves by itself at a time on the session's clock [s]."""
    seen: SeenObstacles | None = None
    """What the camera has seen around the robot; None where that is not looked for."""
    follows_goals: bool = True
    """Whether a goal that moves is followed; else the first grasp that is seen is gone for."""
    set_down: SetDown = field(default_factory=SetDown)
    """What the robot itself has put somewhere."""
    standing: StandingWatch | None = None
    """Looks whether what was let go last stands at its place."""
    settings: BehaviourSettings = field(default_factory=BehaviourSettings)
    log: TaskLog = field(default_factory=TaskLog)
    keys: dict[str, Key[object]] = field(default_factory=dict)
    """Every key of the tree, by its path: those of a subtree after the name of its node."""

    def __post_init__(self) -> None:
        self._held = Held(self.log)
        self._relocalisation = Relocalisation(self.settings.relocalisation)
        self._jump = self._relocalisation.note(self.state)
        self.fault_memory = FaultMemory(self.robot.description, self.settings.recover)
        """What has stopped the robot so far, and when that may be cleared."""
        self._joined = self.fixtures, self.fault_memory.hit, self.fixtures

    @property
    def surroundings(self) -> Surroundings:
        """What the robot must not hit, as it is known this tick."""
        return Surroundings(
            fixtures=self._around(),
            moving=tuple(self.obstacles(self.state.stamp)),
            loose=self.set_down.shapes,
            seen=None if self.seen is None else self.seen.cloud,
            held=self.held,
        )

    def _around(self) -> tuple[Geom, ...]:
        """What is known to stand around, and what was hit; the same object as long as both are."""
        known, hit = self.fixtures, self.fault_memory.hit
        if self._joined[0] is not known or self._joined[1] is not hit:
            self._joined = known, hit, (known + hit if hit else known)
        return self._joined[2]

    @property
    def held(self) -> tuple[Geom, ...]:
        """The shapes of what the hand holds, in e; the same object as long as they are the same."""
        return self._held.shape(self.state.gripper_width)

    @property
    def wTe(self) -> SE3:
        """End effector in the world, as read this tick."""
        return self.model.wTe(self.state.wTb, self.state.q)

    def read(self, state: RobotState) -> None:
        """Take a reading without a tick of the tree, as while the run is paused."""
        self.state = state
        self.log.note_width(state.gripper_width)
        self._jump = self._relocalisation.note(state) or self._jump
        moving = self.obstacles(state.stamp) if state.faults else ()
        at_work = isinstance(self.goal, PoseGoal) and self.goal.hand_may_touch
        self.fault_memory.note(state, self.wTe, self.clock.now(), moving, at_work=at_work)

    def begin_tick(self, state: RobotState) -> None:
        """Take a reading; without a new goal the robot will come to rest."""
        self.read(state)
        self.relocalised, self._jump = self._jump, ""
        self.lost = bool(self.relocalised) and self._relocalisation.was_large
        if self.relocalised:
            self.set_down.forget()
            self.fault_memory.relocalise()
        self.goal, self.goal_of = None, None
        self.vision.begin_tick()
        if self.seen is not None:
            if self.relocalised:
                self.seen.relocalise(state.stamp)
            moving = [one.geom for one in self.obstacles(state.stamp)]
            self.seen.look(self.vision, state, self.held, moving)
        if self.standing is not None:
            self.standing.look(self)

    def end_tick(self, report: StepReport) -> None:
        """Take the report of the controller about the goal that the tick left."""
        self.report, self.report_of = report, self.goal_of
