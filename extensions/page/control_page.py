"""What the control page shows of one run, and the actions of its buttons.

The loop only leaves its newest tick; everything else is made on the thread of whoever asks.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import Any
from urllib.parse import urlsplit

from py_trees.common import Status

from app.live import (
    Changes,
    Control,
    Hook,
    NodeInfo,
    RunInfo,
    Snapshot,
    looks,
    tip,
)
from app.task_time import in_words
from app.web import viewer_address
from extensions.page.log_book import LogBook
from extensions.page.outlook import outlook, purpose
from extensions.page.plan import Plan
from extensions.page.small_picture import picture
from hw import DepthFrame, Injector, stopwatch
from perception import Detection

Told = dict[str, Any]
"""Something for the browser, as JSON."""

_LOST = 0.5  # two standard deviations of the position from which the robot is not localised [m]
_FORCED = {"success": Status.SUCCESS, "failure": Status.FAILURE, "nothing": None}
_PICTURE_PERIOD = 0.4  # shortest time between two pictures [s]


class ControlPage:
    """The page of a run in this process.

    `tree` has the nodes in preorder and `hooks` their hooks; faults are offered by an `injector`.
    `viewer` is live data for a viewer on the page, as `rerun+http://127.0.0.1:9876/proxy`, and
    `may_force` whether people may force the outcome of a node. `seconds` is real time [s].
    """

    def __init__(
        self,
        control: Control,
        tree: Sequence[NodeInfo],
        *,
        injector: Injector | None = None,
        info: RunInfo | None = None,
        plan: Plan | None = None,
        viewer: str | None = None,
        hooks: Sequence[Hook] = (),
        may_force: bool = False,
        seconds: Callable[[], float] = stopwatch,
    ) -> None:
        self.viewer_hosts = "'self'" + (f" http://{urlsplit(viewer).netloc}" if viewer else "")
        self._control, self._tree, self._hooks = control, tuple(tree), tuple(hooks)
        self._plan, self._seconds = plan, seconds
        info = info or RunInfo(task="", where="")
        offered = () if injector is None else injector.names
        self._about = {
            "task": info.task,
            "description": info.description,
            "where": info.where,
            "real": info.real,
            "objects": info.objects,
            "nodes": [(one.title, one.kind, one.depth, one.does) for one in self._tree],
            "plan": plan.fixed if plan else "",
            "injectable": offered,
            "can_force": may_force,
            "viewer_hosts": self.viewer_hosts,
            "viewer": f"/viewer/{viewer_address(viewer)}" if viewer else None,
        }
        self._seen: Snapshot | None = None
        self._shown_at = seconds()
        self._finished = False
        self._outcome = self._explanation = ""
        self._changes = Changes(self._tree, info.objects)
        self.log = LogBook()
        self._lock = threading.Lock()
        self._frame: tuple[DepthFrame, Detection | None] | None = None
        self._pictured: tuple[DepthFrame, Detection | None] | None = None
        self._pictured_at = float("-inf")
        self._picture: Told | None = None
        self._actions: dict[str, Callable[[], None]] = {
            "/stop": control.stop,
            "/pause": control.pause,
            "/resume": control.resume,
            "/step": control.step,
            "/next": control.run_to_next_change,
            "/acknowledge": control.acknowledge,
        }
        if injector is not None:
            self._actions |= {f"/fault/{name}": partial(injector.inject, name) for name in offered}
            self._actions["/clear"] = injector.clear
        for i, hook in enumerate(hooks):
            self._actions |= {
                f"/break/{i}": partial(setattr, hook, "stops", True),
                f"/unbreak/{i}": partial(setattr, hook, "stops", False),
                f"/approve/{i}": partial(self._answer, hook, None),
                f"/refuse/{i}": partial(self._answer, hook, Status.FAILURE),
            }
            if may_force:
                for name, status in _FORCED.items():
                    self._actions[f"/force/{i}/{name}"] = partial(setattr, hook, "forced", status)

    def show(self, snapshot: Snapshot) -> None:
        """Set the tick that the page shows."""
        self._seen, self._shown_at = snapshot, self._seconds()
        self._changes.note(snapshot)
        if snapshot.frame is not None:
            self._frame = snapshot.frame, snapshot.detection

    def finish(self) -> None:
        """Report that the robot is at rest and no tick follows."""
        self._finished = True

    def end(self, outcome: str, explanation: str) -> None:
        """Show how the run ended, and disable the buttons."""
        self._outcome, self._explanation = outcome, explanation

    def stop(self) -> None:
        """End the run."""
        self._control.stop()

    def act(self, path: str) -> bool:
        """Do what a button asks for by its path; whether there is such a button."""
        action = None if self._outcome else self._actions.get(path)
        if action is not None:
            action()
        return action is not None

    def about(self) -> Told:
        """What does not change."""
        return self._about

    def catch_up(self) -> None:
        """Put what has happened into the log."""
        with self._lock:
            self.log.add(self._changes.take())

    def picture(self) -> Told | None:
        """The last picture of the camera, made at most a few times a second."""
        with self._lock:
            newest, now = self._frame, self._seconds()
            is_new = newest is not self._pictured and now - self._pictured_at > _PICTURE_PERIOD
            if newest is not None and is_new:
                self._pictured, self._pictured_at = newest, now
                with suppress(Exception):  # a picture that cannot be drawn is none
                    self._picture = {"url": picture(*newest), "stamp": newest[0].stamp}
            return self._picture

    def state(self) -> Told:
        """What the page shows, for JSON; `age` is that of the tick [s]."""
        state, seen = self._control.state, self._seen
        waiting = next((i for i, hook in enumerate(self._hooks) if hook.waiting), None)
        to_approve = waiting is not None and self._hooks[waiting].asks
        shown: Told = {
            "phase": self._phase,
            "age": self._seconds() - self._shown_at,
            "paused": state.paused,
            "why": state.why,
            "stopped": self._control.stopped,
            "ticks": state.ticks,
            "emergency": state.emergency,
            "pressed": state.pressed,
            "breaks": [i for i, hook in enumerate(self._hooks) if hook.stops],
            "forced": {
                i: outcome.value.lower()
                for i, hook in enumerate(self._hooks)
                if (outcome := hook.forced) is not None
            },
            "waiting": waiting,
            "approve": self._tree[waiting].title if waiting is not None and to_approve else "",
            "outcome": self._outcome,
            "explanation": self._explanation,
        }
        return shown if seen is None else shown | self._of_tick(seen, waiting)

    def _of_tick(self, seen: Snapshot, waiting: int | None) -> Told:
        index = tip(seen.nodes) if waiting is None else waiting
        then, otherwise = outlook(self._tree, index)
        with self._lock:
            spent = [round(seconds, 1) for seconds in self._changes.spent(seen.time)]
        told: Told = {
            "time": in_words(seen.time),
            "seconds": seen.time,
            "paused_s": seen.paused_s,
            "stamp": seen.stamp,
            "placed": seen.placed,
            "holds": seen.holds,
            "tip": index,
            "purpose": purpose(self._tree, seen.nodes, index),
            "message": seen.nodes[index].message,
            "then": then,
            "otherwise": otherwise.title,
            "figures": _figures(seen),
            "faults": [fault.text for fault in seen.state.faults],
            "looks": "".join(look[0] for look in looks(self._tree, seen.nodes)),
            "spent": spent,
        }
        if self._plan is not None:
            box = self._plan.view_box(seen.mTb.translation[None, :2])
            told |= {"moving": self._plan.now(seen), "view_box": box}
        return told

    @property
    def _phase(self) -> str:
        if self._outcome:
            return "over"
        if self._finished:
            return "finished"
        return "starting" if self._seen is None else "running"

    def _answer(self, hook: Hook, answer: Status | None) -> None:
        """Let the node begin, or end, that waits for approval, unless another waits by now."""
        if hook.waiting and hook.asks:
            hook.answer = answer
            self._control.resume()


def _figures(seen: Snapshot) -> dict[str, str]:
    """Figures with their units."""
    state, report = seen.state, seen.report
    vx, vy, w = state.base_twist
    turning = f", {abs(w):.1f} rad/s" if abs(w) > 0.05 else ""
    figures = {
        "base": f"{(vx * vx + vy * vy) ** 0.5:.2f} m/s{turning}",
        "fastest joint": f"{max(abs(state.qd)):.2f} rad/s",
        "fingers": f"{1000.0 * state.gripper_width:.0f} mm"
        + (" apart, holding" if seen.holds else " apart"),
    }
    if seen.goal is not None and report.position_error < float("inf"):
        figures["to the goal"] = f"{report.position_error:.2f} m"
    if 0.0 <= report.clearance < 1.0:
        figures["nearest obstacle"] = f"{report.clearance:.2f} m"
    if state.battery is not None:
        figures["battery"] = f"{100.0 * state.battery:.0f} %"
    if seen.grasp is not None:
        figures["grasp"] = f"{seen.grasp.quality:.2f}" + (" locked" if seen.locked else "")
    if located := _localised(seen):
        figures["on the map"] = located
    return figures


def _localised(snapshot: Snapshot) -> str:
    """How well the robot knows where it is; empty where that is exact."""
    if snapshot.estimate is None:
        return ""
    two_sigma, _ = snapshot.estimate.two_sigma
    return f"±{1000.0 * two_sigma:.0f} mm" if two_sigma < _LOST else "not localised"
