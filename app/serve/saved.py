"""A finished run as the page shows one: what is constant, its end, and its log."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from py_trees.common import Status

from app.core import RECORDING, how_it_ended
from app.live import (
    Changes,
    LogLine,
    NodeInfo,
    NodeStatus,
    Noted,
    RunInfo,
    Told,
    depth_picture,
    looks,
    tip,
)
from app.review import (
    FaultEvent,
    Log,
    NodeEvent,
    NoDepthError,
    PauseEvent,
    ResumeEvent,
    drawn_plan,
    explain,
    read_log,
    recorded_depth,
    timeline,
)
from app.task_time import in_words, task_time
from config import UserError


def saved(folder: Path, when: str) -> Told:
    """What the page shows of a run that began at the time `when`.

    Raises DamagedRunError: its event log is missing or invalid.
    """
    run, log = explain(folder), read_log(folder)
    summary, tree = run.record.summary, _tree(log)
    changes = Changes(RunInfo(task=run.record.task, where=when), tree)
    lines = _replayed(log, changes, nodes := [NodeStatus(Status.INVALID, "")] * len(tree))
    end = log.events[-1].time
    where = (summary.robot, summary.world, summary.scene, f"seed {summary.seed}", when)
    about: Told = {
        "task": run.record.task,
        "where": " · ".join(filter(None, where)),
        "objects": summary.objects if summary.handled else 0,
        "nodes": [(one.title, one.kind, one.depth, one.does) for one in tree],
        "saved": True,
    }
    values = log.end.values if log.end else {}
    parts = [(*name.rstrip("]").partition(" ["), value) for name, value in values.items()]
    state: Told = {
        "phase": "over",
        "outcome": how_it_ended(run.record.task, run.outcome, task_time(run.time, run.paused_s)),
        "explanation": "\n\n".join("\n".join(lines) for lines in run.sections[1:]),
        "looks": "".join(look[0] for look in looks(tree, nodes)),
        "spent": [round(one, 1) for one in changes.spent(log.task_time(end))],
        "figures": {name: f"{value:g} {unit}" for name, _, unit, value in parts},
        "time": in_words(run.time),
        "paused_s": run.paused_s,
        "seconds": run.time,
        "stamp": end,
        "placed": summary.placed or 0,
        "tip": tip(nodes),
        "run": 0,
        "told_at": 0.0,
        "stopped": True,
    }
    try:
        plan = drawn_plan(folder)
        about["plan"] = plan.fixed
        state |= {"moving": plan.moved, "view_box": plan.view_box}
    except UserError as error:
        about["no_plan"] = str(error)
    return {"about": about, "state": state, "log": lines, "picture": _picture(folder)}


def _tree(log: Log) -> list[NodeInfo]:
    depths: list[int] = []
    for parent in timeline(log).parents:
        depths.append(0 if parent is None else depths[parent] + 1)
    return [
        NodeInfo(name=one.name, kind=one.kind, depth=depth, given=one.given, does=one.does)
        for one, depth in zip(log.nodes, depths, strict=True)
    ]


def _replayed(log: Log, changes: Changes, nodes: list[NodeStatus]) -> list[LogLine]:
    """The lines of the log; `nodes` is left with their last statuses."""
    lines: list[LogLine] = []
    faults: tuple[str, ...] = ()
    paused = ""
    for stamp, events in groupby(log.events, key=lambda event: event.time):
        for event in events:
            match event:
                case NodeEvent():
                    nodes[event.node] = NodeStatus(Status(event.status), event.message)
                case FaultEvent():
                    faults = tuple(event.faults)
                case PauseEvent() | ResumeEvent():
                    paused = getattr(event, "why", "")
        changes.keep(Noted(log.task_time(stamp), stamp, tuple(nodes), faults, paused))
        lines += changes.take()
    return lines


def _picture(folder: Path) -> Told | None:
    """The last depth image of the camera; None if there is none."""
    try:
        return {"url": depth_picture(recorded_depth(folder / RECORDING, None).depth), "stamp": 0.0}
    except NoDepthError:
        return None
