"""Options of a run."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from app.choices import MotionForm, ObstacleSource, RegistrationForm
from app.core.fault_schedule import ScheduledFault
from app.live import ControlOptions, ViewOptions
from controller import PlanningSettings

DEFAULT_SCENE = "household"


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Options of a run, as given on the command line."""

    tree: Path
    robot: str = "frankie"  # a shipped robot or a robot file
    world: str = "kinematic"  # what simulates the robot, unless it is real
    base_speed: float | None = None  # speed limit [m/s]; None for that of its description
    reverse_speed: float | None = None  # the same backwards [m/s]; None for the same share
    armed: bool = False  # whether a real robot may move
    motion: MotionForm = MotionForm.HOLISTIC
    planning_time: float = PlanningSettings.planning_time  # standstill for each plan [s]
    obstacles: ObstacleSource = ObstacleSource.MAP
    map: Path | None = None  # scene file with the map; None for the map of the simulated world
    scene: str | None = None
    """A shipped scene or a scene file; None for the one that the task names, or `household`."""
    localisation: str | None = None
    """How wrong a simulated robot is about where it is: a level, or the file of one; None for
    `good`."""
    registration: RegistrationForm = RegistrationForm.BOTH
    """What is matched to the map where the localisation may be wrong."""
    seed: int = 0
    time_of_day: float | None = None
    """When it begins, since midnight [s]; None for now, or noon in a simulated world."""
    parameters: Mapping[str, str] = field(default_factory=dict)
    places: Path | None = None  # a file of poses and regions, used instead of the task's own
    paced: bool = False  # not faster than real time
    real_clock: bool = False  # a simulated robot that does not wait for its loop, as a real one
    record: Path = Path("runs")  # parent of the run's folder
    replayable: bool = False  # keep the camera's images, so that it can be replayed
    weights: Path | None = None  # of GG-CNN; None for the shipped ones
    view: ViewOptions = field(default_factory=ViewOptions)
    ros2: bool = False  # publish it in ROS 2
    control: ControlOptions = field(default_factory=ControlOptions)
    faults: tuple[ScheduledFault, ...] = ()  # faults to inject
    shown: bool = False  # whether the terminal shows the tree
    recording: bool = True  # whether the motion is recorded for the viewer
