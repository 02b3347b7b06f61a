"""Control page in the browser: shows the tree of a run, and pauses, steps and stops it.

The page draws the tree itself, independent of the 3-D viewer, and shows the age of its state.
"""

from __future__ import annotations

import secrets
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from py_trees.common import Status

from app.live.nodes import looks, tip
from app.live.operator.control import Control
from app.live.operator.hooks import Hook, HookAction, Side
from app.live.web import viewer_address
from app.task_time import task_time
from hw import INJECTABLE, stopwatch

if TYPE_CHECKING:
    from app.live.nodes import NodeInfo
    from app.live.snapshot import Snapshot


MOST = 200


class NodeHistory:
    """The last changes of every node; written by one thread, read by any."""

    def __init__(self, count: int) -> None:
        self._statuses: list[Status] = [Status.INVALID] * count
        self._changes: list[deque[tuple[float, Status, str]]] = [
            deque(maxlen=MOST) for _ in range(count)
        ]

    def note(self, snapshot: Snapshot) -> None:
        """Record the nodes whose status has changed."""
        statuses = [node.status for node in snapshot.nodes]
        if statuses == self._statuses:
            return
        for index, (was, now) in enumerate(zip(self._statuses, snapshot.nodes, strict=True)):
            if now.status is not was:
                self._changes[index].append((snapshot.time, now.status, now.message))
        self._statuses = statuses

    def of(self, node: int) -> list[dict[str, object]]:
        """The changes of a node for JSON, oldest first."""
        return [
            {"time": time, "status": status.value.lower(), "message": message}
            for time, status, message in self._changes[node].copy()
        ]


_OFFERED = tuple(name for name, fault in INJECTABLE.items() if not fault.of_world)
_FORCED = {"success": Status.SUCCESS, "failure": Status.FAILURE, "nothing": None}


@dataclass(frozen=True, kw_only=True)
class WebViewer:
    """The web viewer that is embedded in the page."""

    data: str
    """What it connects to, for example `rerun+http://127.0.0.1:9876/proxy`."""

    @property
    def data_origin(self) -> str:
        """The only other origin that the viewer may contact."""
        return f"http://{urlsplit(self.data).netloc}"

    @property
    def path(self) -> str:
        """Its path on the page's server."""
        return f"/viewer/{viewer_address(self.data)}"


@dataclass(frozen=True, kw_only=True)
class Ending:
    """What the page shows of a finished run."""

    outcome: str
    explanation: str
    recording: Path | None


class ControlPage:
    """State of one run for the page, and the actions of its buttons; served by a `PageServer`.

    Args:
        control: of the run.
        tree: nodes of the tree, in preorder.
        inject: injects a fault, by its name in `INJECTABLE`.
        clear: clears the injected faults.
        address: of the server, without a path.
        viewer: embedded in the page, if any.
        hooks: of the nodes, in the same order; without them there are no breakpoints.
        may_force: whether people may force the outcome of a node.
        seconds: real time from an arbitrary start [s].
    """

    def __init__(
        self,
        control: Control,
        tree: Sequence[NodeInfo],
        *,
        inject: Callable[[str], None],
        clear: Callable[[], None],
        address: str = "",
        viewer: WebViewer | None = None,
        hooks: Sequence[Hook] = (),
        may_force: bool = False,
        seconds: Callable[[], float] = stopwatch,
    ) -> None:
        self.viewer = viewer
        self.recording: Path | None = None
        self.recording_path = f"/{secrets.token_urlsafe(16)}.rrd"
        self._control = control
        self._tree = tuple(tree)
        self._address = address
        self._hooks = tuple(hooks)
        self._may_force = may_force and bool(hooks)
        self._history = NodeHistory(len(tree))
        self._seconds = seconds
        self._snapshot: Snapshot | None = None
        self._shown_at = seconds()
        self._finished = False
        self._ending: Ending | None = None
        self._actions: Mapping[str, Callable[[], None]] = {
            "/pause": control.pause,
            "/resume": control.resume,
            "/step": control.step,
            "/next": control.run_to_next_change,
            "/acknowledge": control.acknowledge,
            "/clear": clear,
            **{f"/fault/{name}": partial(inject, name) for name in _OFFERED},
            **{
                f"/{word}/{i}": partial(act, hook)
                for i, hook in enumerate(self._hooks)
                for word, act in (
                    ("break", self._break),
                    ("unbreak", self._unbreak),
                    ("approve", self._approve),
                    ("refuse", self._refuse),
                )
            },
        }
        if self._may_force:
            self._actions |= {
                f"/force/{i}/{name}": partial(hook.force, status)
                for i, hook in enumerate(self._hooks)
                for name, status in _FORCED.items()
            }

    @property
    def viewer_hosts(self) -> str:
        """Hosts to which the embedded viewer may connect."""
        return f"'self' {self.viewer.data_origin}" if self.viewer else "'self'"

    def show(self, snapshot: Snapshot) -> None:
        """Set the tick that the page shows."""
        self._snapshot, self._shown_at = snapshot, self._seconds()
        self._history.note(snapshot)

    def finish(self) -> None:
        """Report that the robot is at rest and no tick follows."""
        self._finished = True

    def end(self, ending: Ending) -> None:
        """Show how the run ended, and disable the buttons."""
        self.recording = ending.recording
        self._ending = ending

    def stop(self) -> None:
        """End the run."""
        self._control.stop()

    def action(self, path: str) -> Callable[[], None] | None:
        """The action of a POST to a path; None if there is none."""
        return None if self._ending is not None else self._actions.get(path)

    def tree(self) -> list[dict[str, object]]:
        """The nodes, for JSON."""
        return [
            {"name": n.name, "title": n.title, "kind": n.kind, "depth": n.depth} for n in self._tree
        ]

    def history(self, node: int) -> list[dict[str, object]]:
        """The changes of a node, for JSON; empty for an invalid number."""
        return self._history.of(node) if 0 <= node < len(self._tree) else []

    def state(self) -> dict[str, object]:
        """What the page shows, for JSON; `age` is that of the tick [s]."""
        state, snapshot, ending = self._control.state, self._snapshot, self._ending
        waiting = next((i for i, hook in enumerate(self._hooks) if hook.waiting), None)
        to_approve = waiting is not None and self._hooks[waiting].asks
        shown: dict[str, object] = {
            "phase": self._phase,
            "age": self._seconds() - self._shown_at,
            "paused": state.paused,
            "why": state.why,
            "stopped": state.stopped,
            "ticks": state.ticks,
            "emergency": state.emergency,
            "pressed": state.pressed,
            "injectable": list(_OFFERED),
            "viewer": self.viewer.path if self.viewer else None,
            "can_break": bool(self._hooks),
            "can_force": self._may_force,
            "breaks": [i for i, hook in enumerate(self._hooks) if self._breaks(hook)],
            "forced": {
                i: outcome.value.lower()
                for i, hook in enumerate(self._hooks)
                if (outcome := hook.chosen) is not None
            },
            "waiting": waiting,
            "approve": self._tree[waiting].title if waiting is not None and to_approve else "",
            "over": None,
        }
        if ending is not None:
            source = f"{self._address}{self.recording_path}"
            shown["over"] = {
                "outcome": ending.outcome,
                "explanation": ending.explanation,
                "viewer": f"/viewer/{viewer_address(source)}" if ending.recording else None,
            }
        if snapshot is not None:
            index = tip(snapshot.nodes)
            shown |= {
                "time": task_time(snapshot.time, snapshot.paused_s),
                "tip": index,
                "node": self._tree[index].name,
                "status": snapshot.nodes[index].status.value.lower(),
                "message": snapshot.nodes[index].message,
                "faults": [fault.text for fault in snapshot.state.faults],
                "looks": [look.value for look in looks(self._tree, snapshot.nodes)],
            }
        return shown

    @property
    def _phase(self) -> str:
        if self._ending is not None:
            return "over"
        if self._finished:
            return "finished"
        return "starting" if self._snapshot is None else "running"

    def _breaks(self, hook: Hook) -> bool:
        action = hook.actions.get(Side.BEFORE)
        return action is not None and action.replace_with is None

    def _break(self, hook: Hook) -> None:
        hook.actions[Side.BEFORE] = HookAction()

    def _unbreak(self, hook: Hook) -> None:
        if self._breaks(hook):
            hook.actions.pop(Side.BEFORE, None)

    def _approve(self, hook: Hook) -> None:
        """Let the node begin that waits for approval, unless another one waits by now."""
        if hook.waiting and hook.asks:
            self._control.resume()

    def _refuse(self, hook: Hook) -> None:
        if hook.waiting and hook.asks:
            hook.answer = Status.FAILURE
            self._control.resume()
