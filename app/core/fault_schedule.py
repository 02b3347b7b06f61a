"""Schedule of injected faults (`--fault`): at a time or in a phase of the task.

Phases are the keys of running leaves (`navigate`, `grasp`, `place`, ...), the parts of their work
(`approach`, `lock`, `descend`, `close` of `grasp`; `lower`, `release`, `rise` of `place`; `offer`
of `hand_over`), `retreat` for `retreat_check`, and `carry` for a `navigate` with something in the
hand.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf, isfinite

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from behaviours import Leaf
from config import UserError, suggest
from hw import FaultInjection, injectable
from trees.language import known_leaves

PHASES = (
    "recover",
    "navigate",
    "approach",
    "lock",
    "descend",
    "close",
    "retreat",
    "carry",
    "place",
)
"""The phases of moving an object, in order."""

_PARTS = ("lower", "release", "rise", "offer")
_RETREAT = "retreat_check"


@dataclass(frozen=True, kw_only=True)
class ScheduledFault:
    """Which fault, when, and for how long; it is injected once."""

    fault: str  # a name of `INJECTABLE`
    at_s: float | None = None  # when, on the session's clock [s]
    phase: str | None = None  # or in which phase, when that is entered first; see above
    for_s: float | None = None  # duration [s]; None until `recover` clears it


def parse_fault(text: str) -> ScheduledFault:
    """The entry `FAULT@WHEN` or `FAULT@WHEN for SECONDS`; WHEN is a time [s] or a phase.

    Raises UserError: it is invalid.
    """
    name, at, rest = text.partition("@")
    when, _, duration = (part.strip() for part in rest.partition(" for "))
    try:
        if not at:
            raise UserError("when? write it as reflex@12.5 or reflex@descend")
        fault, for_s = injectable(name.strip()).name, _seconds(duration)
        if duration and not (for_s is not None and isfinite(for_s) and for_s > 0.0):
            raise UserError(f"`{duration}` is no time; give seconds, as in `for 2`")
        at_s = _seconds(when)
        if at_s is not None and not (isfinite(at_s) and at_s >= 0.0):
            raise UserError(f"`{when}` is no time; give seconds since the beginning")
        if at_s is None and when not in (known := {*PHASES, *_PARTS, *known_leaves()}):
            raise UserError(f"no phase is called `{when}`; {suggest(when, known)}")
    except UserError as error:
        raise UserError(f"--fault {text}: {error}") from None
    return ScheduledFault(fault=fault, at_s=at_s, phase=when if at_s is None else None, for_s=for_s)


def _seconds(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def phases_of(leaf: Behaviour) -> frozenset[str]:
    """The phases that a running leaf is in."""
    if not isinstance(leaf, Leaf):
        return frozenset()
    if leaf.key == "navigate" and not (leaf.gripper_is_open or leaf.gripper_is_closed):
        return frozenset({"carry"})
    if leaf.key == _RETREAT:
        return frozenset({_RETREAT, "retreat"})
    if leaf.key == "place" and leaf.phase not in _PARTS:
        return frozenset({"place"})  # its own approach is not that of a grasp
    return frozenset({leaf.key, leaf.phase} - {""})


def current_phases(nodes: Iterable[Behaviour]) -> frozenset[str]:
    """The phases of all leaves that run."""
    running = (phases_of(node) for node in nodes if node.status is Status.RUNNING)
    return frozenset().union(*running)


class FaultSchedule:
    """Injects faults as its entries say; asked after every tick of the tree.

    Raises InjectionError: a fault that this robot, in this world, cannot have.
    """

    def __init__(
        self, faults: Sequence[ScheduledFault], robot: FaultInjection, nodes: Sequence[Behaviour]
    ) -> None:
        for one in faults:
            robot.check(one.fault)
        self._waiting, self._robot, self._nodes = list(faults), robot, nodes

    def update(self, now: float) -> None:
        """Inject what is due after a tick, at a time on the session's clock [s]."""
        phases = current_phases(self._nodes) if self._waiting else frozenset()
        for one in tuple(self._waiting):
            if one.phase in phases or (one.at_s is not None and now >= one.at_s - 1e-9):
                self._waiting.remove(one)
                self._robot.inject(one.fault, inf if one.for_s is None else one.for_s)
