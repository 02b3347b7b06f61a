"""Toy leaves and a world to tick them in, for the tests of the tree language."""

from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from behaviours import LEAVES, BasePose, Condition, Key, Posture, Region, TaskLog, ToolPose
from config import Diagnostic
from hw import SimClock
from robots import load_robot
from trees.language import build, examine, load, ticked

STATUS = {"S": Status.SUCCESS, "F": Status.FAILURE, "R": Status.RUNNING, "I": Status.INVALID}
LETTER = {status: letter for letter, status in STATUS.items()}


@dataclass
class ToyContext:
    clock: SimClock = field(default_factory=SimClock)
    events: list[str] = field(default_factory=list)
    counted: int = 0
    keys: dict[str, object] = field(default_factory=dict)
    log: TaskLog = field(default_factory=TaskLog)
    robot: object = field(
        default_factory=lambda: SimpleNamespace(description=load_robot("frankie"))
    )

    def on_map(self, place: object) -> object:
        """The map does not move here."""
        return place


class Toy(Behaviour):
    """Succeeds at once."""

    def __init__(self, name: str, context: ToyContext) -> None:
        super().__init__(name)
        self.context = context

    def update(self) -> Status:
        return Status.SUCCESS


def said(leaf: Behaviour, script: list[str]) -> Status:
    """The status of the next letter, of which the last one is for ever."""
    letter = script.pop(0) if len(script) > 1 else script[0]
    if letter == "X":
        raise RuntimeError(f"{leaf.name} broke")
    leaf.feedback_message = f"said {letter}"
    return STATUS[letter]


class Play(Toy):
    """Returns the statuses that it is told, the last one for ever.

    Args:
        script: a letter a tick: S, F, R, I(nvalid), X raises.
    """

    key = "play"

    def __init__(self, name: str, context: ToyContext, *, script: str) -> None:
        super().__init__(name, context)
        self.script = list(script)

    def initialise(self) -> None:
        self.context.events.append(f"{self.name} begins")

    def update(self) -> Status:
        return said(self, self.script)

    def terminate(self, new_status: Status) -> None:
        self.context.events.append(f"{self.name} ends {LETTER[new_status]}")


class Recover(Toy):
    def __init__(self, name: str, context: ToyContext, *, arm: Posture) -> None:
        super().__init__(name, context)
        self.arm = arm


class Navigate(Toy):
    """Drive there.

    Args:
        to: where the hand
            or the base goes.
        timeout_s: give up after this [s].
    """

    def __init__(
        self, name: str, context: ToyContext, *, to: ToolPose | BasePose, timeout_s: float = 60.0
    ) -> None:
        super().__init__(name, context)
        self.to, self.timeout_s = to, timeout_s


class Grasp(Toy):
    """Pick up something.

    Args:
        within: where to look.
        lock_distance_m: hold the choice from here on [m].
    """

    def __init__(
        self,
        name: str,
        context: ToyContext,
        *,
        within: Region,
        lock_distance_m: float = 0.25,
        side: Literal["left", "right"] = "left",
        tries: int | None = None,
        careful: bool = False,
    ) -> None:
        super().__init__(name, context)
        if lock_distance_m > 1.0:
            raise ValueError("the lock distance is longer than the arm")
        self.within, self.lock_distance_m = within, lock_distance_m
        self.side, self.tries, self.careful = side, tries, careful


class Ask(Condition):
    """Answers as it is told.

    Args:
        answers: a letter a tick: S, F, R, X raises; the last one for ever.
    """

    def __init__(self, name: str, context: ToyContext, *, answers: str) -> None:
        super().__init__(name, context)
        self.answers = list(answers)

    def update(self) -> Status:
        return said(self, self.answers)


class Count(Toy):
    """Counts how often it was started.

    Args:
        times: how often [times].
        where: where it was, if anybody wants to know.
    """

    def __init__(
        self,
        name: str,
        context: ToyContext,
        *,
        times: Key[int],
        where: Key[ToolPose | BasePose] | None = None,
    ) -> None:
        super().__init__(name, context)
        self.times = times

    def update(self) -> Status:
        self.context.counted += 1
        self.times.write(self.context.counted)
        return Status.SUCCESS


class Note(Toy):
    """Notes a value, and takes a tick for it.

    Args:
        value: what is noted; a negative number is refused.
    """

    def __init__(self, name: str, context: ToyContext, *, value: float | str) -> None:
        super().__init__(name, context)
        if isinstance(value, float) and value < 0.0:
            raise ValueError("the value is negative")
        self.value = value

    def initialise(self) -> None:
        self.context.events.append(f"{self.name} begins with {self.value!r}")
        self.waited = False

    def update(self) -> Status:
        self.feedback_message = f"noting {self.value}"
        if self.waited:
            return Status.SUCCESS
        self.waited = True
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        self.context.events.append(f"{self.name} ends {LETTER[new_status]}")


TOYS = {
    "ask": Ask,
    "count": Count,
    "note": Note,
    "play": Play,
    "recover": Recover,
    "navigate": Navigate,
    "grasp": Grasp,
    "open_gripper": Toy,
    "retreat_check": Toy,
    "wait": LEAVES["wait"],
}


def check(path: Path | str, **more: Any) -> list[Diagnostic]:
    """What is wrong with a task file, without a robot; arguments as for `examine`."""
    return examine(path, **more)[1]


class Run:
    """A tree built from the text of its `tree:` section, ticked at 100 Hz of simulated time."""

    def __init__(self, folder: Path, tree: str) -> None:
        indented = "\n".join(f"  {line}" for line in tree.strip().splitlines())
        path = folder / "task.yaml"
        path.write_text(f"task: toy\ntree:\n{indented}\n")
        self.context = ToyContext()
        self.root = build(load(path, leaves=TOYS), self.context)

    def ticks(self, count: int) -> str:
        """The status of the root after each tick, as letters."""
        letters = ""
        for _ in range(count):
            for _ in ticked(self.root):
                pass
            letters += LETTER[self.root.status]
            self.context.clock.sleep_until(self.context.clock.now() + 0.01)
        return letters

    def to_the_end(self) -> str:
        """The status in which the root ends, as a letter."""
        while (letter := self.ticks(1)) == "R":
            pass
        return letter

    @property
    def events(self) -> list[str]:
        return self.context.events

    def begun(self, name: str) -> int:
        return self.events.count(f"{name} begins")
