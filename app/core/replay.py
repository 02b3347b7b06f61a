"""Replay of a recorded run: same readings and frames, same tree and controller."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from os.path import isfile
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from app.choices import ObstacleSource, RegistrationForm
from app.core.decisions import ReplayedDecisions
from app.core.files.folder import FRAMES, NOTES, OPTIONS, PLACES, READINGS, TASK, recorded_robot
from app.core.files.frames import RecordedFrames
from app.core.files.notes import NOTED, RunNotes, read_notes
from app.core.files.whole import whole_rows
from app.core.outcome import Outcome
from app.core.session import Session
from app.core.setup import recorded_world_model, set_up
from app.run_options import RunOptions
from config import UserError
from hw import Backend, Difference, ReplayRobot, turn_type
from perception import GraspDetector
from robots import at_pace, load_robot, with_base_speeds
from trees.language import build, load, nodes_in_order

Turns: TypeAlias = npt.NDArray[Any]


@dataclass(frozen=True, kw_only=True)
class Replay:
    """Result of a replay."""

    commands: int  # number of commands equal to the recorded ones, before the first difference
    recorded: int  # number of recorded commands
    difference: Difference | None  # the first command that differs
    ran_out: bool  # whether the replay continued after the end of a complete recording
    complete: bool  # whether the recording is complete
    outcome: Outcome  # how the replay ended

    @property
    def identical(self) -> bool:
        """Whether commands and end are those of the recording, bit for bit."""
        return self.commands == self.recorded and self.difference is None and not self.ran_out

    def __str__(self) -> str:
        if self.difference is not None:
            return str(self.difference)
        if self.commands < self.recorded:
            ends = f"after {self.commands} of {self.recorded} commands"
            return f"the replay ends {ends}: {self.outcome.reason}"
        if self.ran_out:
            return f"the replay goes on after the last of {self.recorded} recorded commands"
        cut = "" if self.complete else "; the recording was cut off there"
        return f"all {self.recorded} commands are identical, bit for bit{cut}"


def replay_run(folder: Path) -> Replay:
    """Run what was recorded through tree and controller again.

    Raises UserError: it cannot be replayed, or its task, robot or weights cannot be
    loaded any more.
    """
    options, pace, is_real = _options(folder)
    description = load_robot(options.robot)
    turns, lost = _turns(folder / READINGS, len(description.arm.joints))
    sensors = options.registration.sensors
    searches = (turns["frame"] >= 0).any() or ("laser" in sensors and (turns["scan"] >= 0).any())
    if is_real and searches:
        raise UserError(
            f"{folder}: in real time the commands depend on when a search ended; on a robot, a run "
            "that looks at images, or matches scans to the map, cannot be replayed"
        )
    notes, turns = _notes(folder / NOTES, turns, cut=lost)
    if notes.end not in ("", "complete"):
        raise UserError(f"{folder}: cannot be replayed: {notes.end}")
    description = with_base_speeds(description, options.base_speed, options.reverse_speed)
    description = at_pace(description, pace)
    frames = None
    if (turns["frame"] > 0).any():
        if not isfile(folder / FRAMES):
            raise UserError(
                f"{folder}: the run looked at images, and they were not kept; "
                "run it with --replayable to keep them"
            )
        frames = RecordedFrames(folder / FRAMES, description.camera.intrinsics)

    def recall(field: str, number: int) -> object:
        return frames(number) if field == "frame" and frames else notes.noted[field, number]

    robot = ReplayRobot(description, turns, recall)
    detector = GraspDetector.shipped(description.gripper, options.weights)
    task = load(options.tree, overrides=options.parameters, places=options.places)
    backend = Backend(robot=robot, clock=robot.clock, truth=None)
    around = recorded_world_model(options.scene, options.seed, options.map)
    with set_up(backend, detector, options, world_model=around) as setup:
        nodes = nodes_in_order(build(task, setup.context))
        robot.begin()
        decisions = ReplayedDecisions(robot, attended=notes.attended)
        outcome = Session(setup, nodes[0].node, decisions).run()
    return Replay(
        commands=robot.sent,
        recorded=int(turns["sent"].sum()),
        difference=robot.difference,
        ran_out=robot.ran_out and bool(notes.end),
        complete=bool(notes.end),
        outcome=outcome,
    )


def _options(folder: Path) -> tuple[RunOptions, float, bool]:
    """The options of a run, its pace, and whether its clock was real.

    UserError: such a run cannot be replayed.
    """
    path = folder / OPTIONS
    with _reading(path):
        options = json.loads(_file(path).read_text(encoding="utf-8"))
        control, usual = options.get("control", options), RunOptions(tree=folder / TASK)
        site, weights = options.get("map"), options["weights"]
        kept = replace(
            usual,
            robot=recorded_robot(folder, options),
            base_speed=options.get("base_speed"),
            reverse_speed=options.get("reverse_speed"),
            parameters={str(k): str(v) for k, v in options["parameters"].items()},
            places=folder / PLACES if isfile(folder / PLACES) else None,
            weights=None if weights is None else Path(weights),
            scene=None if options["scene"] is None else str(options["scene"]),
            seed=int(options["seed"]),
            map=None if site is None else Path(site),
            world=str(options["world"]),
            obstacles=ObstacleSource(options.get("obstacles", usual.obstacles)),
            registration=RegistrationForm(options.get("registration", usual.registration)),
        )
        held = any(control.get(one) for one in ("breaks", "groot", "approve", "force"))
        is_real = options.get("real_time", options["world"] in ("hardware", "emulated"))
        planned = options.get("motion") == "planning"
    if planned:
        raise UserError(f"{folder}: with --motion planning, which is gone; it cannot be replayed")
    if held:
        raise UserError(
            f"{folder}: with --break or --approve a person may hold or answer for a node; such a "
            "run cannot be replayed"
        )
    return kept, float(options.get("pace", 1.0)), bool(is_real)


def _turns(path: Path, j: int) -> tuple[Turns, bool]:
    """The whole turns, and whether others were cut off."""
    with _reading(path):
        turns, lost = whole_rows(_file(path))
    if turns.dtype != turn_type(j) or turns.ndim != 1:
        raise UserError(f"{path}: of another version of frankie-task, or of another arm")
    if not turns.size:
        raise UserError(f"{path}: there is no reading in it")
    if (turns["number"] != np.arange(len(turns))).any():
        raise UserError(f"{path}: readings are missing, because the disk was too slow")
    return turns, bool(lost)


def _notes(path: Path, turns: Turns, *, cut: bool) -> tuple[RunNotes, Turns]:
    """The notes, and the turns until the first one that refers to a note which is lost."""
    with _reading(path):
        notes = read_notes(_file(path).read_text(encoding="utf-8"))
    whole, lost = len(turns), ""
    for field in NOTED:
        for number in np.unique(turns[field][turns[field] > 0]).tolist():
            first = int((turns[field] == number).argmax())
            if (field, number) not in notes.noted and first < whole:
                whole, lost = first, f"{field} {number}"
    if not whole:
        raise UserError(f"{path}: {lost} is missing, and nothing before it; replay another run")
    cut = cut or whole < len(turns)
    return replace(notes, end="") if cut else notes, turns[:whole]


@contextmanager
def _reading(path: Path) -> Iterator[None]:
    """Raise UserError for errors of reading a file."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or error
        raise UserError(f"{path}: cannot be read ({reason}); replay another run") from error
    except Exception as error:
        what = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise UserError(f"{path}: damaged ({what}); replay another run") from error


def _file(path: Path) -> Path:
    """The path, if it is a regular file."""
    if not isfile(path):
        raise OSError(None, "there is no such file")
    return path
