"""Observers: what is told of every tick of a run, and how packages offer more of them.

An entry point of the group `frankie_task.observers` is a function of an argument, a text that may
be empty, and of a `LiveRun`; it returns an `Observer`. `run --with NAME:ARGUMENT` asks for it.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from app.live.changes import RunInfo
from app.live.control import Control
from app.live.hooks import Hook
from app.live.run_snapshot import ShownRun, Snapshot
from config import DoorError, find
from hw import Injector

GROUP = "frankie_task.observers"


class Observer:
    """Is told of a run, on the thread of its loop; one that raises is not called again."""

    resumes = False
    """Whether a person there can pause and resume the run ..."""
    acknowledges = False
    """... and acknowledge an emergency stop."""

    def show(self, snapshot: Snapshot) -> None:
        """Take a tick; the loop waits meanwhile, so leave it to a thread."""

    def finish(self) -> None:
        """Hear that the robot is at rest, and that no tick follows."""

    def end(self, outcome: str, explanation: str, *, stay: bool) -> None:
        """Hear how the run ended; where people may `stay`, return when they have gone."""

    def close(self) -> None:
        """End."""


@dataclass(frozen=True, kw_only=True)
class LiveRun:
    """What an observer knows of a run, and what its people may do."""

    shown: ShownRun
    info: RunInfo
    control: Control
    hooks: Sequence[Hook]  # one for each node of the tree, in preorder
    injector: Injector | None  # of a robot that can be given faults
    may_force: bool  # whether people may force the outcome of a node
    drivers: frozenset[str]  # of the parts of a real robot
    viewer: str | None  # live data for a Rerun viewer, as `rerun+http://127.0.0.1:9876/proxy`
    say: Callable[[str], None]  # prints a line


@contextmanager
def observers(names: Sequence[str], run: LiveRun) -> Iterator[dict[str, Observer]]:
    """The observers of a run by their names, as `foxglove` or `foxglove:8765`, closed at the end.

    Raises DoorError: there is no such one; UserError: one cannot do what its argument says.
    """
    opened: dict[str, Observer] = {}
    with ExitStack() as closing:
        for one in names:
            name, _, argument = one.partition(":")
            if name in opened:
                raise DoorError(f"--with {one}: there is another `{name}`; name it once")
            make = find(GROUP, name, "observer")
            if not callable(make):
                raise DoorError(f"the observer `{name}` is no function; fix its package")
            opened[name] = make(argument, run)
            closing.callback(opened[name].close)
        yield opened
