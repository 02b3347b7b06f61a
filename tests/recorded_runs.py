"""Runs that are recorded with everything that a replay needs."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from app.choices import Speed
from app.core import Instruments, ObstacleSource, RunOptions, run_task
from trees import find


@dataclass(frozen=True, kw_only=True)
class Recorded:
    """One run to record."""

    tree: str
    robot: str = "frankie"
    scene: str | None = None
    seed: int = 0
    faults: tuple[str, ...] = ()  # as `reflex@3`
    frames: bool = True
    speed: Speed = Speed.MAX
    obstacles: ObstacleSource = ObstacleSource.MAP
    localisation: str = "exact"
    seconds: float | None = None
    """When a person ends it [s]; None lets it end by itself."""

    def __str__(self) -> str:
        scene = [self.scene] if self.scene else []
        scene += [] if self.localisation == "exact" else [f"localisation {self.localisation}"]
        until = [f"stopped at {self.seconds:g} s"] if self.seconds else []
        parts = [Path(self.tree).stem, self.robot, f"seed {self.seed}", *scene, *until]
        return ", ".join([*parts, *self.faults])


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
        replayable=run.frames,
        speed=run.speed,
        obstacles=run.obstacles,
        localisation=run.localisation,
        record=root,
        recording=False,
        acknowledge_after=0.5,
        **faulty(*run.faults),
    )
    return run_task(options, interrupted=is_over, instruments=instruments).folder


def faulty(*faults: str, world: str = "kinematic") -> dict[str, object]:
    """Options of a run with faults; without the extension that gives them the test is skipped."""
    if not faults:
        return {"world": world}
    pytest.importorskip("extensions.faults")
    return {"world": f"faulty:{world}", "observers": [f"faults:{','.join(faults)}"]}


def faulty_words(*faults: str, world: str = "kinematic") -> list[str]:
    """The same on the command line."""
    options = faulty(*faults, world=world)
    return [
        f"--world={options['world']}",
        *(f"--with={one}" for one in options.get("observers", ())),
    ]


RECORDED = (
    Recorded(tree="pick_one", scene="single", faults=("reflex@3",), seconds=9.0),
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
        faults=("emergency stop@4 for 1",),
    ),
    Recorded(
        tree="pick_one",
        scene="household",
        faults=("frames lost@approach for 0.4", "localisation drift@1"),
    ),
    Recorded(tree="pick_one", scene="single", faults=("state nan@3",)),
    Recorded(tree="pick_one", scene="single", faults=("reading fails@5",)),
)
