"""Untruth: staged disturbances of whole tasks, and whether what the robot says then is true.

The world is the judge: it knows where base, hand and objects are. The robot is asked only for what
it says. Nothing here is shared with what the robot judges by.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import redirect_stderr
from dataclasses import asdict, dataclass, field, replace
from itertools import product
from math import radians
from pathlib import Path
from tempfile import TemporaryDirectory
from textwrap import indent
from traceback import format_exc
from typing import Any

import numpy as np
import pinocchio as pin
import yaml
from pinocchio import SE3
from rich.table import Table

from app.core import End, Instruments, RunOptions, Setup, Tick, current_phases, run_task
from config.arrays import Array
from extensions.faults import with_faults
from hw import (
    Backend,
    Camera,
    DepthFrame,
    DisturbableWorld,
    Laser,
    LaserScan,
    Robot,
    RobotState,
    RobotWrapper,
    stopwatch,
)
from hw.sim import LEVELS
from robots import half_extents
from trees.language import TreeNode

VERDICTS = ("right", "wrong failure", "wrong success", "wrong count", "hang", "crash", "void")
LONGEST = 180.0  # a run that takes longer hangs [s]; the loop's watchdog sees to real time

_AWAY = (-8.0, -8.0, 0.5)  # where people take things [m]
_INSIDE = 0.005  # by which an object reaches into a region at least [m]
_ACKNOWLEDGED_AFTER = 0.5  # a simulated person acknowledges what only a person may clear [s]
_COUNTED = re.compile(r"counted (at least )?(\d+)$")
_FACES = "1 2 4 3,5 7 8 6,1 5 6 2,3 4 8 7,1 3 7 5,2 6 8 4"  # of a box, by its corners

Do = Callable[["Staged"], Any]
"""Changes the world, or what the sensors tell; where it takes time, a generator that yields once a
tick."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """A task, a scene, and what happens meanwhile."""

    name: str
    task: str  # the nodes of its sequence, in YAML
    scene: Mapping[str, Any]
    at: str = ""  # the phase in which something happens, as `carry`, or `carry+0.5` [s]
    do: Do | None = None  # what happens then
    true: Callable[[Staged], bool] = lambda run: True  # what its success says, by the world
    count: Callable[[Staged], int] | None = None  # how many things it should have counted
    moved: Mapping[str, Sequence[float]] = field(default_factory=dict)
    """Furniture that is not where the map has it: by x, y [m] and a turn [deg]."""
    beyond: str = ""  # why no sensor of the robot can tell what is false, if so


class Staged(Instruments):
    """One run of a case."""

    def __init__(self, case: Case, seed: int) -> None:
        self.case, self.rng, self._seed = case, np.random.default_rng(seed), seed
        self.reading: Callable[[RobotState], RobotState] = lambda state: state
        self.picture: Callable[[DepthFrame], DepthFrame] = lambda frame: frame
        self.scan: Callable[[LaserScan], LaserScan] = lambda scan: scan
        self.now, self.hang = 0.0, False
        self.over = case.do is None  # whether all has happened

    def opened(self, backend: Backend) -> Backend:
        """The robot with the sensors of the script, beneath the faults on request."""
        self._body = vars(backend.robot)["_base"].body
        return with_faults(replace(backend, robot=_Sensors(backend.robot, self)), self._seed)

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        """Begin the script."""
        assert isinstance(setup.truth, DisturbableWorld)
        self.world, self.setup = setup.truth, setup
        self._nodes = [place.node for place in nodes]
        self._script = self._happens()

    def after(self, tick: Tick) -> None:
        """Go on with the script."""
        self.now = tick.state.stamp
        if not self.over:
            self.phases = current_phases(self._nodes)
            self.over = next(self._script, self) is self

    def _happens(self) -> Iterator[None]:
        yield from self.enter(self.case.at)
        if self.case.do is not None and isinstance(done := self.case.do(self), Iterator):
            yield from done

    def is_over(self) -> bool:
        """Whether the run takes too long."""
        self.hang |= self.now > LONGEST
        return self.hang

    def wait(self, seconds: float) -> Iterator[None]:
        """Let simulated time pass [s]."""
        until = self.now + seconds
        while self.now < until:
            yield

    def enter(self, phase: str) -> Iterator[None]:
        """Wait for a phase, and so long in it: `carry+0.5` [s]."""
        name, _, into = phase.partition("+")
        while name not in self.phases:
            yield
        yield from self.wait(float(into or 0.0))

    def inject(self, fault: str) -> None:
        """One of the faults on request."""
        assert self.setup.injector is not None
        self.setup.injector.inject(fault)

    def find(self, name: str) -> Any:
        """The first object whose name begins so."""
        return next(one for one in self.world.objects if one.name.startswith(name))

    def place(self, name: str) -> Array:
        """(3,) where an object is [m]."""
        return np.array(self.find(name).pose.translation)

    @property
    def held(self) -> str | None:
        """Name of the object in the hand."""
        return next((name for name, by in self.world.supports().items() if by == "hand"), None)

    def put(self, name: str, *xyz: float) -> None:
        """Move an object from outside to a place, from where it falls [m]."""
        one = self.find(name)
        self.world.put(one.name, SE3(one.pose.rotation, np.array(xyz or _AWAY)))

    def slip(self) -> None:
        """Let what is held slip out of the hand."""
        if (name := self.held) is not None:
            self.put(name, *self.place(name))

    def shove(self, x: float, y: float, deg: float, *, lifted: bool) -> None:
        """Move the base in its own frame, and turn it; of a lifted one the wheels do not turn."""
        body, wheels = self._body, self._body.wheels
        before = body.wTb
        after = before * SE3(pin.utils.rotate("z", radians(deg)), np.array([x, y, 0.0]))
        if (engine := getattr(body, "engine", None)) is not None:
            pose = [*after.translation[:2], np.arctan2(after.rotation[1, 0], after.rotation[0, 0])]
            vars(engine)["_data"].qpos[vars(engine)["_base_q"]] = pose
        body.wTb = after
        if body.world.held is not None:
            body.world.carry(body.wTe)
        for name in ("_wTb", "_grid_wTb") if lifted else ():
            setattr(wheels, name, after * before.actInv(vars(wheels)[name]))

    @property
    def hand(self) -> Array:
        """(3,) where the hand truly is [m]."""
        return np.array(self._body.wTe.translation)

    @property
    def camera(self) -> SE3:
        """Where the camera truly is."""
        return self._body.wTe * self._body.description.camera.eTc

    @property
    def base(self) -> Array:
        """(3,) where the base truly is [m]."""
        return np.array(self._body.wTb.translation)

    def on(self, furniture: str, name: str = "") -> bool:
        """Whether all objects whose name begins so rest on a piece of furniture."""
        supports = self.world.supports().items()
        return all(by == furniture for one, by in supports if one.startswith(name))

    def inside(self, centre: Sequence[float], size: Sequence[float]) -> int:
        """How many objects reach into an upright box [m]."""
        low, high = (np.array(centre) + sign * np.array(size) / 2.0 for sign in (-1.0, 1.0))
        bodies = (np.array(_corners(one)) for one in self.world.objects)
        within = (
            (one.max(axis=0) > low + _INSIDE) & (one.min(axis=0) < high - _INSIDE) for one in bodies
        )
        return sum(bool(one.all()) for one in within)


class _Sensors(RobotWrapper):
    """A robot whose readings a script changes; the same frame stays the same."""

    def __init__(self, robot: Robot, run: Staged) -> None:
        super().__init__(robot)
        self._run, self._changed = run, dict[str, tuple[Any, Any]]()

    @property
    def camera(self) -> Camera:
        return Camera(lambda age: self._told("picture", self._robot.camera.latest(age)))

    @property
    def laser(self) -> Laser:
        return Laser(lambda age: self._told("scan", self._robot.laser.latest(age)))

    def read(self) -> RobotState:
        return self._run.reading(self._robot.read())

    def _told(self, kind: str, new: Any) -> Any:
        if new is not None and new is not self._changed.get(kind, (None,))[0]:
            self._changed[kind] = new, getattr(self._run, kind)(new)
        return new and self._changed[kind][1]


def _corners(one: Any) -> list[Array]:
    """Of the boxes around the shapes of an object, in the world [m]."""
    return [
        one.pose.act(part.pose.act(np.array(half_extents(part.shape)) * corner))
        for part in one.parts
        for corner in product((-1.0, 1.0), repeat=3)
    ]


@dataclass(frozen=True, kw_only=True)
class Staging:
    """A case in a world."""

    case: str
    world: str
    localisation: str
    seed: int


@dataclass(frozen=True, kw_only=True)
class Verdict(Staging):
    """What became of it."""

    verdict: str  # one of `VERDICTS`; `void` if nothing happened in it
    said: str  # by the robot: outcome, reason, messages
    duration_s: float
    real_s: float
    beyond: str  # why no sensor could tell, if it is wrong and none could

    @property
    def is_wrong(self) -> bool:
        """Whether the robot should have done better."""
        return self.verdict not in VERDICTS[:2] and not self.beyond


def run_staging(staging: Staging) -> Verdict:
    """Run one case, and judge it."""
    from lab.bench.untruth_cases import CASES

    case = next(one for one in CASES if one.name == staging.case)
    run, begun, messages = Staged(case, staging.seed), stopwatch(), list[str]()
    with (
        TemporaryDirectory() as folder,
        open(os.devnull, "w", encoding="utf-8") as nothing,
        redirect_stderr(nothing),
    ):
        task, scene, level = _written(Path(folder), case, staging.localisation)
        options = RunOptions(
            tree=task,
            scene=str(scene),
            localisation=str(level),
            world=staging.world,
            seed=staging.seed,
            record=Path(folder),
            recording=False,
            acknowledge_after=_ACKNOWLEDGED_AFTER,
        )
        try:
            result = run_task(options, interrupted=run.is_over, instruments=run)
            end, reason = result.outcome.end, result.outcome.reason
            messages = result.summary.messages
            staged = run.over and not any("instruments" in it for it in result.summary.warnings)
            verdict = _verdict(run, end, messages) if staged or run.hang else "void"
        except Exception:
            end, reason, verdict = End.CRASH, format_exc().strip().splitlines()[-1], "crash"
    return Verdict(
        **asdict(staging),
        verdict=verdict,
        said="; ".join([f"{end.value}: {reason}", *messages]),
        duration_s=round(run.now, 1),
        real_s=round(stopwatch() - begun, 1),
        beyond=case.beyond if verdict in ("wrong success", "wrong count") else "",
    )


def _verdict(run: Staged, end: End, messages: Sequence[str]) -> str:
    if run.hang or end is End.CRASH:
        return "hang" if run.hang else "crash"
    counts = [found.groups() for text in messages if (found := _COUNTED.search(text))]
    if counts and run.case.count is not None:
        number = run.case.count(run)
        if any(int(n) > number or (int(n) < number and not least) for least, n in counts):
            return "wrong count"
    says, is_true = end is End.SUCCESS, run.case.true(run)
    return "right" if says == is_true else "wrong success" if says else "wrong failure"


def _written(folder: Path, case: Case, localisation: str) -> Iterator[Path]:
    """The files of task, scene and level."""
    from lab.bench.untruth_cases import PLACES

    level = LEVELS[localisation].model_dump(exclude_none=True) | {"moved": dict(case.moved)}
    tree = indent(case.task, "    ")
    yield _file(folder, "task.yaml", f"task: staged\n{PLACES}tree:\n  sequence:\n{tree}")
    yield _file(folder, "scene.yaml", yaml.safe_dump(_with_meshes(folder, case.scene)))
    yield _file(folder, "level.yaml", yaml.safe_dump(_with_meshes(folder, level)))


def _with_meshes(folder: Path, value: Any) -> Any:
    """A value for YAML, in which the edges of a `box` [mm] become the file of a mesh."""
    if isinstance(value, list | tuple):
        return [_with_meshes(folder, one) for one in value]
    if not isinstance(value, Mapping):
        return value
    plain = {key: _with_meshes(folder, one) for key, one in value.items()}
    if "box" not in plain:
        return plain
    name, edges = f"{plain.pop('name')}.obj", np.array(plain.pop("box"))
    corners = [edges * corner for corner in product((0, 1), repeat=3)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {face}" for face in _FACES.split(",")]
    _file(folder, name, "\n".join(lines))
    return plain | {"mesh": name, "units": "mm"}


def _file(folder: Path, name: str, text: str) -> Path:
    (folder / name).write_text(text + "\n", encoding="utf-8")
    return folder / name


def untruth_table(results: Sequence[Verdict]) -> Table:
    """One row for each world and level."""
    table = Table(title="what the robot said after staged disturbances")
    for name in ("world", "localisation", "runs", *VERDICTS, "beyond its sensors"):
        table.add_column(name, justify="right")
    for world, level in dict.fromkeys((one.world, one.localisation) for one in results):
        counts = Counter(
            "beyond" if one.beyond else one.verdict
            for one in results
            if (one.world, one.localisation) == (world, level)
        )
        numbers = [counts.total(), *(counts[name] for name in (*VERDICTS, "beyond"))]
        table.add_row(world, level, *map(str, numbers))
    return table


def untruth_notes(results: Sequence[Verdict]) -> list[str]:
    """A line for each that is not right."""
    return [
        f"{one.case}, seed {one.seed}: {one.beyond and 'beyond its sensors, '}{one.verdict} "
        f"({one.beyond or one.said})"
        for one in results
        if one.verdict != "right"
    ]
