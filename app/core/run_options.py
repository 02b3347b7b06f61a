"""What a person may choose about a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from app.choices import MotionForm, ObstacleSource, VisionForm
from app.core.fault_schedule import ScheduledFault
from app.live import ControlOptions, ViewOptions
from controller import PlanningSettings


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """What a person may choose about a run."""

    tree: Path
    robot: str = "frankie"
    """The body: a shipped robot or a robot file."""
    world: str = "kinematic"
    """What moves it, where it is not real."""
    base_speed: float | None = None
    """Limit of its base [m/s]; None keeps that of its description."""
    reverse_speed: float | None = None
    """The same backwards [m/s]; None keeps its share of the limit forwards."""
    armed: bool = False
    """Whether a person has said that a real robot may move."""
    motion: MotionForm = MotionForm.HOLISTIC
    """How the robot gets to its goals."""
    planning_time: float = PlanningSettings.planning_time
    """Where it plans, it stands for this long each time [s]."""
    vision: VisionForm = VisionForm.STEP
    """How images are searched for grasps."""
    obstacles: ObstacleSource = ObstacleSource.MAP
    """What tells the controller what stands around the robot."""
    map: Path | None = None
    """A scene file that says what stands around; None takes the world's own map."""
    scene: str | None = None
    """A shipped scene or a scene file; None takes the one that the task names, or `household`."""
    seed: int = 0
    parameters: Mapping[str, str] = field(default_factory=dict)
    places: Path | None = None
    """A file of poses and regions, which count instead of the task's own."""
    paced: bool = False
    """In real time instead of as fast as it goes."""
    record: Path = Path("runs")
    """Where the folder of the run is made."""
    replayable: bool = False
    """Keep the camera's images too, so that a run that looks at some can be replayed."""
    weights: Path | None = None
    """A file of a grasp network; None takes a network that comes with the package."""
    network: str | None = None
    """Which of those; None takes the best."""
    view: ViewOptions = field(default_factory=ViewOptions)
    """How it is watched meanwhile."""
    control: ControlOptions = field(default_factory=ControlOptions)
    """What people have in hand meanwhile."""
    faults: tuple[ScheduledFault, ...] = ()
    """What goes wrong by itself meanwhile."""
    shown: bool = False
    """Whether the terminal shows the tree meanwhile."""
    recording: bool = True
    """Whether the motion is recorded for the viewer."""
