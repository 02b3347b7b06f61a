"""Schedule of injected faults (`--faults`, `--fault`): at a time or in a phase of the task.

Phases are the keys of running leaves (`navigate`, `grasp`, `place`, ...), the parts of their work
(`approach`, `lock`, `descend`, `close` of `grasp`; `lower`, `release`, `rise` of
`place`), `retreat` for `retreat_check`, and `carry` for a `navigate` with something in the hand.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Annotated

import numpy as np
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from pydantic import Field, field_validator, model_validator

from behaviours import Leaf
from config import StrictModel, UserError, read_config, suggest
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

_PARTS = ("lower", "release", "rise")
_RETREAT = "retreat_check"

Seconds = Annotated[float, Field(ge=0.0, le=1e6)]


class ScheduleError(UserError):
    """An invalid `--fault`."""


class ScheduledFault(StrictModel):
    """One entry: which fault, when, and for how long."""

    fault: str
    """A name of `INJECTABLE`."""
    at_s: Seconds | None = None
    """When, on the session's clock [s]."""
    phase: str | None = None
    """Or in which phase, see the module docstring."""
    after_s: Seconds = 0.0
    """Delay after the phase was entered; not injected if the phase ends before [s]."""
    occurrence: Annotated[int, Field(ge=1)] = 1
    """First entry of the phase that counts."""
    times: Annotated[int, Field(ge=1)] = 1
    """Most injections."""
    probability: Annotated[float, Field(gt=0.0, le=1.0)] = 1.0
    """Probability of each injection."""
    for_s: Annotated[float, Field(gt=0.0, le=1e6)] | None = None
    """Duration [s]; None until `recover` clears it."""

    @field_validator("fault")
    @classmethod
    def _is_known(cls, name: str) -> str:
        try:
            return injectable(name).name
        except UserError as error:
            raise ValueError(str(error)) from None

    @field_validator("phase")
    @classmethod
    def _is_phase(cls, phase: str | None) -> str | None:
        known = {*PHASES, *_PARTS, *known_leaves()}
        if phase is not None and phase not in known:
            raise ValueError(f"no phase is called `{phase}`; {suggest(phase, known)}")
        return phase

    @model_validator(mode="after")
    def _says_when(self) -> ScheduledFault:
        if (self.at_s is None) == (self.phase is None):
            raise ValueError("a fault needs one moment; give either `at_s` or `phase`")
        if self.at_s is not None and {"after_s", "occurrence", "times"} & self.model_fields_set:
            raise ValueError("`after_s`, `occurrence` and `times` are about a phase; leave them")
        return self


class FaultFile(StrictModel):
    """A file of faults."""

    faults: tuple[ScheduledFault, ...]


def read_faults(path: Path) -> tuple[ScheduledFault, ...]:
    """The entries of a file; raises ConfigError with every mistake in it."""
    return read_config(path, FaultFile).faults


def parse_fault(text: str) -> ScheduledFault:
    """The entry `FAULT@WHEN` or `FAULT@WHEN for SECONDS`; WHEN is a time [s] or a phase.

    Raises:
        ScheduleError: it is invalid.
    """
    fault, at, rest = text.partition("@")
    if not at:
        raise ScheduleError(f"--fault {text}: when? write it as reflex@12.5 or reflex@descend")
    when, _, duration = rest.partition(" for ")
    entry: dict[str, object] = {"fault": fault.strip()}
    entry |= (
        {"at_s": seconds} if (seconds := _number(when)) is not None else {"phase": when.strip()}
    )
    if duration:
        entry["for_s"] = _number(duration) if _number(duration) is not None else duration
    try:
        return ScheduledFault.model_validate(entry)
    except ValueError as error:
        raise ScheduleError(f"--fault {text}: {_first(error)}") from None


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


@dataclass(eq=False)
class _Entry:
    """An entry and its state."""

    fault: ScheduledFault
    entered: int = 0
    injected: int = 0
    due: float | None = None
    """When to inject it, if its phase has not ended by then [s]."""


@dataclass(eq=False)
class FaultSchedule:
    """Injects faults as its entries say; asked after every tick of the tree.

    Raises:
        InjectionError: a fault that this robot, in this world, cannot have.
    """

    faults: Sequence[ScheduledFault]
    robot: FaultInjection
    nodes: Sequence[Behaviour]
    seed: int = 0

    def __post_init__(self) -> None:
        for fault in self.faults:
            self.robot.check(fault.fault)
        self._entries = [_Entry(fault) for fault in self.faults]
        self._rngs = [np.random.default_rng((self.seed, n)) for n in range(len(self.faults))]
        self._phases: frozenset[str] = frozenset()

    def update(self, now: float) -> None:
        """Inject what is due after a tick, at a time on the session's clock [s]."""
        before, self._phases = self._phases, current_phases(self.nodes)
        for entry, rng in zip(self._entries, self._rngs, strict=True):
            if self._is_due(entry, before, now, rng):
                entry.injected += 1
                duration = inf if entry.fault.for_s is None else entry.fault.for_s
                self.robot.inject(entry.fault.fault, duration)

    def _is_due(
        self, entry: _Entry, before: frozenset[str], now: float, rng: np.random.Generator
    ) -> bool:
        fault = entry.fault
        if entry.injected >= fault.times:
            return False
        if fault.phase is None:
            entered = fault.at_s is not None and now >= fault.at_s - 1e-9 and not entry.entered
        else:
            entered = fault.phase in self._phases and fault.phase not in before
        if entered:
            entry.entered += 1
            if entry.entered >= fault.occurrence and rng.random() < fault.probability:
                entry.due = now + fault.after_s
        elif fault.phase is not None and fault.phase not in self._phases:
            entry.due = None
        if entry.due is None or now < entry.due - 1e-9:
            return False
        entry.due = None
        return True


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _first(error: ValueError) -> str:
    errors = getattr(error, "errors", None)
    message = str(errors()[0]["msg"]) if errors is not None else str(error)
    return message.removeprefix("Value error, ")
