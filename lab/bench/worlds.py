"""The bench of worlds: the same task and seeds in both, and what each says of every grasp.

In the physical runs the kinematic world is asked, too. When the fingers begin to close, its rules
get the same hand and the same objects; what physics makes of that grasp is read off once the hand
was lifted.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from operator import attrgetter

import numpy as np
from rich.table import Table

from app.core import Instruments, RunOptions, Setup, Summary, Tick, run_task
from controller import RobotModel
from hw import Robot, RobotWrapper, Truth
from hw.sim import Hand, SimObject, World
from lab.bench.whole_tasks import run_tasks
from lab.shared import machine
from trees.language import TreeNode

KINEMATIC, PHYSICS = "kinematic", "physics"

_CLOSING = 1e-3
"""Fingers that are told to come nearer than this close on something [m]."""
_LIFTED = 2.0
"""So long after the fingers began to close the hand was lifted [s]."""


@dataclass(frozen=True, kw_only=True)
class Decision:
    """What both worlds say of one grasp."""

    seed: int
    stamp_s: float
    """When the fingers began to close."""
    rule: str
    """How it ends by the rules of the kinematic world: `held`, or why not."""
    ruled: str | None
    """The object that it holds by them."""
    touched: str | None
    """The object that the pads press on by them, held or not."""
    held: str | None
    """The object that was in the hand when physics had its way."""

    @property
    def agrees(self) -> bool:
        """Whether both hold something, or neither does."""
        return (self.ruled is None) == (self.held is None)

    @property
    def kind(self) -> str:
        """Of the object, which is its name without its number."""
        name = self.held or self.touched
        return "nothing" if name is None else name.rstrip("0123456789").strip()


@dataclass(frozen=True, kw_only=True)
class WorldRun:
    """One run in one world."""

    summary: Summary
    decisions: tuple[Decision, ...] = ()
    """Of a physical run."""


def run_in_worlds(
    options: RunOptions,
    seeds: Iterable[int],
    done: Callable[[Summary], None],
    *,
    workers: int = 1,
    cluster: str | None = None,
) -> list[WorldRun]:
    """Run a task in both worlds for every seed.

    Args:
        options: of each run, except for world and seed.
        seeds: of objects and camera noise.
        done: called after each run.
        workers: number of processes; 1 is this one.
        cluster: address of a dask.distributed scheduler to use instead.

    Returns:
        The runs: of each seed first the kinematic, then the physical one.

    Raises:
        KeyboardInterrupt: a person has ended a run, and with it the others.
    """
    wanted = [
        replace(options, seed=seed, world=world) for seed in seeds for world in (KINEMATIC, PHYSICS)
    ]
    return run_tasks(_run, wanted, attrgetter("summary"), done, workers=workers, cluster=cluster)


def worlds_table(runs: Sequence[WorldRun]) -> Table:
    """One row for every seed, the worlds side by side."""
    first = runs[0].summary
    table = Table(title=f"{first.task}, {first.robot}, {first.scene}: kinematic / physics")
    for column in ("seed", "placed", "attempts", "time [s]", "contacts", "grasps that agree"):
        table.add_column(column, justify="right")
    for ours, theirs in zip(runs[::2], runs[1::2], strict=True):
        a, b = ours.summary, theirs.summary
        agree = sum(one.agrees for one in theirs.decisions)
        table.add_row(
            str(a.seed),
            f"{a.placed} / {b.placed} of {b.objects}",
            f"{a.attempts} / {b.attempts}",
            f"{a.duration_s:.0f} / {b.duration_s:.0f}",
            f"{a.contacts} / {b.contacts}",
            f"{agree} of {len(theirs.decisions)}",
        )
    return table


def worlds_notes(runs: Sequence[WorldRun]) -> list[str]:
    """What the runs say together, and the kinds and grasps that the worlds disagree on."""
    ours = [run.summary for run in runs[::2]]
    theirs = [run.summary for run in runs[1::2]]
    objects = sum(one.objects for one in ours)
    placed = [100.0 * sum(one.placed for one in some) / max(objects, 1) for some in (ours, theirs)]
    times = [float(np.mean([one.duration_s for one in some])) for some in (ours, theirs)]
    decisions = [one for run in runs for one in run.decisions]
    agree = sum(one.agrees for one in decisions)
    false_holds = sum(not one.agrees and one.held is None for one in decisions)
    share = 100.0 / max(len(decisions), 1)
    notes = [
        f"placed {placed[0]:.1f} and {placed[1]:.1f} %, in {times[0]:.1f} and {times[1]:.1f} s",
        f"grasps: {agree} of {len(decisions)} agree ({share * agree:.1f} %); "
        f"false holds {share * false_holds:.1f} %, "
        f"false drops {share * (len(decisions) - agree - false_holds):.1f} %",
    ]
    for kind, count in Counter(one.kind for one in decisions if not one.agrees).most_common():
        of_kind = sum(one.kind == kind for one in decisions)
        notes.append(f"{kind}: {of_kind - count} of {of_kind} agree")
    for one in decisions:
        if not one.agrees:
            fate = f"holds {one.held}" if one.held else f"does not hold {one.ruled}"
            notes.append(
                f"seed {one.seed}, {one.stamp_s:.1f} s: by rule {one.rule}; physics {fate}"
            )
    return notes


def worlds_json(runs: Sequence[WorldRun]) -> str:
    """The runs and the machine they were made on, as one JSON object."""
    return json.dumps({"about": machine(), "runs": [asdict(run) for run in runs]}, indent=2)


def _run(options: RunOptions) -> WorldRun:
    if options.world == KINEMATIC:
        return WorldRun(summary=run_task(options).summary)
    instruments = _BothSay(options.seed)
    summary = run_task(options, instruments=instruments).summary
    return WorldRun(summary=summary, decisions=tuple(instruments.decisions))


class _BothSay(Instruments):
    """Asks the rules of the kinematic world about each grasp of a physical run."""

    def __init__(self, seed: int) -> None:
        self.decisions: list[Decision] = []
        self._seed = seed
        self._truth: Truth | None = None
        self._asked: Decision | None = None

    def beneath(self, robot: Robot) -> Robot:
        """The robot, with an ear on its gripper."""
        return _Asked(robot, self)

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        """Keep what is known of the world."""
        self._truth = setup.truth

    def after(self, tick: Tick) -> None:
        """Read off what physics made of a grasp, when the hand was lifted."""
        if self._asked is not None and tick.state.stamp > self._asked.stamp_s + _LIFTED:
            self.look()

    def ask(self, hand: Hand, stamp: float, opening: float, width: float, force: float) -> None:
        """The fingers are about to close."""
        assert self._truth is not None
        self.look()
        objects = [replace(one) for one in self._truth.objects if isinstance(one, SimObject)]
        told = World(self._truth.fixtures, objects).close_fingers(hand, opening, force, width)
        self._asked = Decision(
            seed=self._seed,
            stamp_s=stamp,
            rule=told.reason.value,
            ruled=told.holding,
            touched=told.touched,
            held=None,
        )

    def look(self) -> None:
        """See what the hand holds, if a grasp waits for that."""
        if self._asked is not None and self._truth is not None:
            supports = self._truth.supports()
            held = next((name for name, support in supports.items() if support == "hand"), None)
            self.decisions.append(replace(self._asked, held=held))
            self._asked = None


class _Asked(RobotWrapper):
    """Tells of grips before they begin."""

    def __init__(self, robot: Robot, both: _BothSay) -> None:
        super().__init__(robot)
        self._both = both
        self._model = RobotModel(robot.description)

    def grip(self, width: float, force: float) -> None:
        """As the robot does, but asks before."""
        state = self._robot.read()
        if width > state.gripper_width:
            self._both.look()  # before it falls
        elif width < _CLOSING:
            hand = Hand(self.description.gripper, self._model.wTe(state.wTb, state.q))
            self._both.ask(hand, state.stamp, state.gripper_width, width, force)
        self._robot.grip(width, force)
