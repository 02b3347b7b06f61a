"""Runs that are recorded with everything that a replay needs."""

from dataclasses import dataclass
from pathlib import Path

from app.core import Instruments, ObstacleSource, RunOptions, ScheduledFault, run_task
from app.live import ControlOptions
from trees import find


@dataclass(frozen=True, kw_only=True)
class Recorded:
    """One run to record."""

    tree: str
    robot: str = "frankie"
    scene: str | None = None
    seed: int = 0
    faults: tuple[ScheduledFault, ...] = ()
    frames: bool = True
    paced: bool = False
    obstacles: ObstacleSource = ObstacleSource.MAP
    localisation: str = "exact"
    seconds: float | None = None
    """When a person ends it [s]; None lets it end by itself."""

    def __str__(self) -> str:
        faults = [f"{one.fault} at {one.at_s or one.phase}" for one in self.faults]
        scene = [self.scene] if self.scene else []
        scene += [] if self.localisation == "exact" else [f"localisation {self.localisation}"]
        until = [f"stopped at {self.seconds:g} s"] if self.seconds else []
        parts = [Path(self.tree).stem, self.robot, f"seed {self.seed}", *scene, *until, *faults]
        return ", ".join(parts)


def record(run: Recorded, root: Path, instruments: Instruments | None = None) -> Path:
    """Do a run; returns its folder."""
    ticks = 0

    def is_over() -> bool:
        nonlocal ticks
        ticks += 1
        return run.seconds is not None and ticks > 100 * run.seconds

    options = RunOptions(
        tree=find(run.tree),
        robot=run.robot,
        scene=run.scene,
        seed=run.seed,
        faults=run.faults,
        replayable=run.frames,
        paced=run.paced,
        obstacles=run.obstacles,
        localisation=run.localisation,
        record=root,
        recording=False,
        control=ControlOptions(acknowledge_after=0.5),
    )
    return run_task(options, interrupted=is_over, instruments=instruments).folder


def fault(name: str, **when) -> ScheduledFault:
    return ScheduledFault(fault=name, **when)


RECORDED = (
    Recorded(tree="pick_one", scene="single", faults=(fault("reflex", at_s=3.0),), seconds=9.0),
    Recorded(tree="pick_one", scene="single"),
    Recorded(tree="pick_one", scene="single", robot="omni", seed=2),
    Recorded(tree="pick_one", localisation="good", seed=1),
    Recorded(tree="patrol"),
    Recorded(tree="inspect"),
    Recorded(tree="follow_moving_object", seconds=20.0),
    Recorded(tree="pick_place", scene="single", seed=1),
    Recorded(tree="tidy_two_tables", seed=1),
    Recorded(
        tree="pick_one",
        scene="single",
        faults=(fault("emergency stop", at_s=4.0, for_s=1.0),),
    ),
    Recorded(
        tree="pick_one",
        scene="household",
        faults=(
            fault("frames lost", phase="approach", for_s=0.4),
            fault("localisation drift", at_s=1.0),
        ),
    ),
    Recorded(tree="pick_one", scene="single", faults=(fault("state nan", at_s=3.0),)),
    Recorded(tree="pick_one", scene="single", faults=(fault("reading fails", at_s=5.0),)),
)
