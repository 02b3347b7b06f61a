"""A finished run as the page shows one: what is constant, its end, and its log."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from app.core import RECORDING, how_it_ended
from app.live import looks
from app.review import NoDepthError, explain, read_log, recorded_depth, retold
from app.task_time import task_time
from extensions.page.control_page import Told
from extensions.page.explanation_page import drawn_plan
from extensions.page.small_picture import depth_picture


def saved(folder: Path, when: str) -> Told:
    """What the page shows of a run that began at the time `when`.

    Raises DamagedRunError: its event log is missing or invalid.
    """
    run, log = explain(folder), read_log(folder)
    task, summary, stamp = run.record.task, run.record.summary, log.events[-1].time
    tree, nodes, changes, lines = retold(log)
    where = (summary.robot, summary.world, summary.scene, f"seed {summary.seed}", when)
    about: Told = {"task": task, "where": " · ".join(filter(None, where))}
    about["nodes"] = [(one.title, one.kind, one.depth, one.does) for one in tree]
    about["objects"] = summary.objects if summary.handled else 0
    state: Told = {"phase": "over", "stamp": stamp, "placed": summary.placed}
    state["outcome"] = how_it_ended(task, run.outcome, task_time(run.time, run.paused_s))
    state["explanation"] = "\n\n".join("\n".join(part) for part in run.sections[1:])
    state["looks"] = "".join(look[0] for look in looks(tree, nodes))
    state["spent"] = [round(seconds, 1) for seconds in changes.spent(log.task_time(stamp))]
    state["figures"] = log.end.values if log.end else {}
    if plan := drawn_plan(folder):
        about["plan"], state["moving"], state["view_box"] = plan
    picture = None
    with suppress(NoDepthError):
        image = depth_picture(recorded_depth(folder / RECORDING, None).depth)
        picture = {"url": image, "stamp": stamp}
    return {"about": about, "state": state, "log": lines, "picture": picture}
