"""Summary of a run, as a table and as JSON, and the result of `run_task`."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

from app.core.measurements import Measurements
from app.core.outcome import End, Outcome
from app.task_time import task_time
from behaviours import Carried, Localiser, TaskLog
from config import counted
from hw import MAY_TOUCH, Refusal, Touch

_MARKS = {
    End.SUCCESS.value: ("✔", "succeeded"),
    End.FAILURE.value: ("✗", "failed"),
    End.CRASH.value: ("✗", "crashed"),
    End.HARDWARE.value: ("✗", "ended with a fault of the robot"),
    End.INTERRUPTED.value: ("■", "was interrupted"),
}
"""Mark and words for each outcome."""


def how_it_ended(task: str, outcome: str, time: str) -> str:
    """The outcome of a task after a time, in a few words."""
    mark, ended = _MARKS.get(outcome, ("✗", f"ended as {outcome}"))
    return f"{mark} {task} {ended} after {time}"


@dataclass(frozen=True, kw_only=True)
class Summary:
    """Figures of a finished run; SI units unless the name says otherwise."""

    task: str
    robot: str
    world: str
    scene: str  # on hardware the file of its map; empty without one
    seed: int | None  # as the next two, None on hardware
    outcome: str  # one of the values of `End`
    reason: str
    node: str  # the node that failed; empty if none did
    objects: int | None  # number of objects at the beginning
    placed: int | None  # number of objects that were delivered, by the contacts of the simulator
    lies_on: dict[str, str]  # what each object lies on in the end, by the simulator
    claimed: int  # number of objects that the tree claims to have placed
    attempts: int  # how often the fingers closed to grasp
    duration_s: float  # from the first tick, without pauses
    paused_s: float
    grasp_time_mean_s: float | None
    """From the first image to closed fingers, mean over the attempts that succeeded."""
    pick_place_time_mean_s: float | None
    """Mean time per object, from the release of the one before, or the first attempt."""
    contacts: int  # contacts in simulation, without those of the fingers and of what they hold
    contacts_by_name: dict[str, int]  # the same by pair, as `link3 hit table/top`
    limit_violations: int
    """Ticks with a measured joint position over its limit, or a speed by more than 1 %."""
    highest_speed_percent: float  # largest measured share of a speed limit
    smallest_joint_margin_deg: float  # smallest distance of a joint to a position limit
    refused_commands: dict[str, int]  # commands that the gate refused, by reason
    ticks: int
    tick_median_ms: float
    tick_p99_ms: float
    late_ticks: int  # ticks that took longer than the control period
    missed_ticks: int  # ticks that were skipped because the one before took too long
    stalls: int  # how often the watchdog stopped the robot because a tick took too long
    perception_s: float  # real time of image processing within ticks
    real_time_factor: float  # simulated seconds per real second
    too_slow: str  # that the computer did not keep real time, in one line; empty if it did
    localisation: str  # how the base was localised, in one line; empty if it was exact
    messages: list[str]  # messages of the task to people, in order
    warnings: list[str]  # what was wrong around the robot, or could not be recorded or shown
    carried: list[dict[str, Any]]  # times and attempts of each object

    def kept(self, path: Path) -> Summary:
        """Write it as JSON; returns it, with a warning if that fails."""
        try:
            path.write_text(self.to_json() + "\n", encoding="utf-8")
        except OSError as error:
            with suppress(OSError):
                path.unlink(missing_ok=True)  # half a summary is none
            missing = f"{path.name} cannot be written ({error.strerror})"
            return replace(self, warnings=[*self.warnings, missing])
        return self

    def to_json(self) -> str:
        """As a JSON object."""
        return json.dumps(asdict(self), indent=2)

    @property
    def achieved(self) -> str:
        """The outcome in one line."""
        objects = ""
        if self._handled:
            objects = f"{self._delivered} placed, "
        failed_in = f"{self.node}: " if self.node and not self.succeeded else ""
        time = task_time(self.duration_s, self.paused_s)
        ended = how_it_ended(self.task, self.outcome, time)
        return f"{ended}: {objects}{failed_in}{self.reason}"

    @property
    def _delivered(self) -> str:
        """How many objects the simulator found in their places; else what the task claims."""
        if self.placed is None:
            return f"{counted(self.claimed, 'object')} (as the task says)"
        return f"{self.placed} of {self.objects} objects"

    @property
    def _handled(self) -> bool:
        return bool(self.placed or self.claimed or self.attempts)

    @property
    def succeeded(self) -> bool:
        """Whether the task succeeded."""
        return self.outcome == End.SUCCESS.value

    def show(self, console: Console) -> None:
        """Print the outcome, then the figures."""
        style = "bold green" if self.succeeded else "bold red"
        console.print(self.achieved, style=style, soft_wrap=True)
        differs = self.placed is not None and self.claimed != self.placed
        claim = f"; the task claims {self.claimed}" if differs else ""
        hits = ", ".join(f"{n} x {text}" for text, n in self.contacts_by_name.items())
        rows = {
            "placed": f"{self._delivered} in {counted(self.attempts, 'attempt')}{claim}",
            "grasp": _seconds(self.grasp_time_mean_s),
            "pick and place": _seconds(self.pick_place_time_mean_s),
            "time": f"{task_time(self.duration_s, self.paused_s)}, "
            f"{self.real_time_factor:.2f} times real time",
            "limits": f"{counted(self.limit_violations, 'violation')} in {self.ticks} ticks; "
            f"at most {self.highest_speed_percent:.0f} % of a speed limit, "
            f"joints at least {self.smallest_joint_margin_deg:.1f}° inside their range",
            "control tick": f"median {self.tick_median_ms:.2f} ms, p99 {self.tick_p99_ms:.2f} ms; "
            f"{self.late_ticks} longer than its period, {self.missed_ticks} left out",
            "localisation": self.localisation,
            "contacts": f"{self.contacts}: {hits}" if self.contacts else "",
            "computer": self.too_slow,
            "stalls": f"{self.stalls}: the watchdog stopped the robot" if self.stalls else "",
            "messages": "\n".join(self.messages),
            "refused": ", ".join(f"{n} {why}" for why, n in self.refused_commands.items()),
            "warnings": "\n".join(self.warnings),
        }
        table = Table("", "", show_header=False, box=None, pad_edge=False)
        table.columns[0].style = "bright_black"
        for name, value in rows.items():
            if value and (self._handled or name not in ("placed", "grasp", "pick and place")):
                table.add_row(name, value)
        console.print(table)


def summarise(
    outcome: Outcome,
    measured: Measurements,
    log: TaskLog,
    touches: Sequence[Touch],
    *,
    refusals: Mapping[Refusal, int],
    duration: float,
    real_seconds: float,
    **given: Any,
) -> Summary:
    """The summary of a run of a duration without pauses [s], in real time `real_seconds` [s].

    `given` are the other fields of `Summary`.
    """
    carried = [_times(one) for one in log.carried]
    placed = [one for one in carried if one["placed"] is not None]
    contacts = Counter(one.text for one in touches if one.part not in MAY_TOUCH)
    ticks = measured.ticks_s
    return Summary(
        **given,
        outcome=outcome.end.value,
        reason=outcome.reason,
        node=outcome.node,
        claimed=log.placed,
        attempts=log.attempts,
        duration_s=round(duration, 3),
        grasp_time_mean_s=_mean([one["grasp_time"] for one in placed]),
        pick_place_time_mean_s=_mean(pick_place_times(carried)),
        contacts=contacts.total(),
        contacts_by_name=dict(contacts.most_common()),
        limit_violations=measured.limit_violations,
        highest_speed_percent=round(100.0 * measured.highest_speed, 2),
        smallest_joint_margin_deg=round(float(np.degrees(measured.smallest_margin)), 2),
        refused_commands={reason.value: n for reason, n in refusals.items() if n},
        ticks=len(ticks),
        tick_median_ms=round(1000.0 * ticks.quantile(0.5), 3),
        tick_p99_ms=round(1000.0 * ticks.quantile(0.99), 3),
        late_ticks=measured.late_ticks,
        missed_ticks=measured.missed_ticks,
        stalls=measured.stalls,
        too_slow=measured.too_slow_on_the_whole,
        real_time_factor=round(duration / real_seconds, 3) if real_seconds > 0.0 else 0.0,
        messages=[text for _, text in log.messages],
        carried=carried,
    )


def localised_by(here: Localiser, level: str, registration: str) -> str:
    """How the base was localised, in one line; empty if that was exact.

    The level is that of a simulated robot, else empty.
    """
    if here.estimate is None:
        return ""
    level = "as the base says" if level in ("", "exact") else level
    if registration == "none":
        return f"{level}, not registered to the map"
    how = {"both": "laser and camera"}.get(registration, registration)
    off, turn = here.largest
    return (
        f"{level}, registered to the map by {how} {counted(here.registrations, 'time')}, "
        f"corrected by at most {1000.0 * off:.0f} mm and {np.degrees(turn):.1f}°"
    )


def _times(one: Carried) -> dict[str, Any]:
    """One object's times [s] and attempts."""
    placed = None if one.placed is None else one.placed.seconds
    return asdict(one) | {"begun": one.begun.seconds, "placed": placed}


def pick_place_times(carried: Sequence[Mapping[str, Any]]) -> list[float]:
    """From the first attempt at an object, or the release of the one before, to its release [s]."""
    done = [one for one in carried if one["placed"] is not None]
    ends = [one["placed"] for one in done]
    return [end - begin for begin, end in pairwise([done[0]["begun"], *ends])] if done else []


def _mean(values: list[float]) -> float | None:
    return round(float(np.mean(values)), 3) if values else None


def _seconds(value: float | None) -> str:
    return "none" if value is None else f"{value:.1f} s on average"


class Result(NamedTuple):
    """Result of `run_task`."""

    outcome: Outcome
    summary: Summary
    folder: Path
