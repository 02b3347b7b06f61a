"""The observer `faults`: gives faults at a time or in a phase, as `--with "faults:reflex@descend"`.

Phases are those of a `Snapshot`: the keys of running leaves (`navigate`, `grasp`, `place`, ...),
the parts of their work (`approach`, `lock`, `descend`, `close` of `grasp`; `lower`, `release`,
`rise` of `place`; `offer` of `hand_over`), `retreat` for `retreat_check`, and `carry` for a
`navigate` with something in the hand.
"""

from collections.abc import Collection
from dataclasses import dataclass
from math import inf, isfinite

from app.live import LiveRun, Observer, Snapshot
from config import UserError, suggest
from hw import Injector
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


@dataclass(frozen=True, kw_only=True)
class ScheduledFault:
    """Which fault, when, and for how long; it is injected once."""

    fault: str
    at_s: float | None = None  # when, since the first tick, pauses included [s]
    phase: str | None = None  # or in which phase, when that is entered first; see above
    for_s: float = inf  # duration [s]; infinite until `recover` clears it

    def is_due(self, seen: Snapshot) -> bool:
        """Whether it begins after a tick."""
        if self.at_s is None:
            return self.phase in seen.phases
        return seen.time + seen.paused_s >= self.at_s - 1e-6


def parse_fault(text: str, names: Collection[str]) -> ScheduledFault:
    """The entry `FAULT@WHEN` or `FAULT@WHEN for SECONDS`; WHEN is a time [s] or a phase.

    Raises UserError: it is invalid, or names none of the faults.
    """
    fault, at, rest = text.partition("@")
    when, _, duration = (part.strip() for part in rest.partition(" for "))
    if not at:
        raise UserError("when? write it as reflex@12.5 or reflex@descend")
    if fault not in names:
        raise UserError(f"no fault is called `{fault}` here; {suggest(fault, names)}")
    at_s, for_s = _seconds(when), _seconds(duration)
    if duration and not (for_s is not None and isfinite(for_s) and for_s > 0.0):
        raise UserError(f"`{duration}` is no time; give seconds, as in `for 2`")
    for_s = inf if for_s is None else for_s
    if at_s is None:
        if when not in (known := {*PHASES, *_PARTS, *known_leaves()}):
            raise UserError(f"no phase is called `{when}`; {suggest(when, known)}")
        return ScheduledFault(fault=fault, phase=when, for_s=for_s)
    if not (isfinite(at_s) and at_s >= 0.0):
        raise UserError(f"`{when}` is no time; give seconds since the beginning")
    return ScheduledFault(fault=fault, at_s=at_s, for_s=for_s)


def _seconds(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


class FaultSchedule(Observer):
    """Injects each of its faults once.

    Raises UserError: an entry is invalid, or the robot cannot have that fault.
    """

    def __init__(self, text: str, injector: Injector) -> None:
        self._injector, self._waiting = injector, list[ScheduledFault]()
        for entry in map(str.strip, text.split(",")):
            try:
                self._waiting.append(parse_fault(entry, injector.names))
            except UserError as error:
                raise UserError(f"--with faults:{entry}: {error}") from None

    def show(self, snapshot: Snapshot) -> None:
        """Inject what is due after a tick."""
        for one in [one for one in self._waiting if one.is_due(snapshot)]:
            self._waiting.remove(one)
            self._injector.inject(one.fault, one.for_s)


def faults(argument: str, run: LiveRun) -> Observer:
    """Faults by a schedule, entries with commas between; see `FaultSchedule`."""
    if run.injector is None:
        raise UserError("--with faults: add --world faulty, or as faulty:physics another world")
    return FaultSchedule(argument, run.injector)
