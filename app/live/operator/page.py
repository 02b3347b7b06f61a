"""A page in the browser that shows the tree of a run, and pauses, steps and stops it.

It draws the tree itself, so it is up to date however far the 3-D viewer beside it lags. It is
served on the loopback address only. When the run is over the page stays, until its process ends.
"""

from __future__ import annotations

import secrets
import threading
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
from app.live.operator.node_history import NodeHistory
from app.live.operator.page_server import HOST, listen
from app.live.web import viewer_address
from hw import INJECTABLE

if TYPE_CHECKING:
    from app.live.nodes import NodeInfo
    from app.live.snapshot import Snapshot

_OFFERED = tuple(name for name, fault in INJECTABLE.items() if not fault.of_world)
"""The faults that every robot can be given."""
_SHUTDOWN_POLL = 0.1
"""How often the server checks whether it is to end [s]."""
_FORCED = {"success": Status.SUCCESS, "failure": Status.FAILURE}


@dataclass(frozen=True, kw_only=True)
class WebViewer:
    """The web viewer that the page embeds."""

    data: str
    """What it connects to, for example `rerun+http://127.0.0.1:9876/proxy`."""

    @property
    def data_origin(self) -> str:
        """The only other origin that the viewer may contact."""
        return f"http://{urlsplit(self.data).netloc}"

    @property
    def path(self) -> str:
        """Its path on the page's own server."""
        return f"/viewer/{viewer_address(self.data)}"


@dataclass(frozen=True, kw_only=True)
class Ending:
    """What the page shows of a run that is over."""

    outcome: str
    """In one line."""
    explanation: str
    recording: Path | None


class ControlPage:
    """Serves the page on threads of its own, from construction to the end of the `with` statement.

    Args:
        control: what the buttons control.
        tree: the nodes of the tree, in preorder.
        inject: injects a fault, by its name in `INJECTABLE`.
        clear: clears the injected faults.
        viewer: embedded in the page, if there is one.
        port: to listen on; None takes the usual one, or any free one if that is taken.
        hooks: of the nodes, in the same order; without them there are no breakpoints.
        may_force: whether people may answer for a node.

    Raises:
        PageError: the port is not available.
    """

    def __init__(
        self,
        control: Control,
        tree: Sequence[NodeInfo],
        *,
        inject: Callable[[str], None],
        clear: Callable[[], None],
        viewer: WebViewer | None = None,
        port: int | None = None,
        hooks: Sequence[Hook] = (),
        may_force: bool = False,
    ) -> None:
        self.viewer = viewer
        self.token = secrets.token_urlsafe(16)
        self.recording: Path | None = None
        self.recording_path = f"/{secrets.token_urlsafe(16)}.rrd"
        self._control = control
        self._tree = tuple(tree)
        self._hooks = tuple(hooks)
        self._may_force = may_force and bool(hooks)
        self._history = NodeHistory(len(tree))
        self._snapshot: Snapshot | None = None
        self._ending: Ending | None = None
        self._actions: Mapping[str, Callable[[], None]] = {
            "/pause": control.pause,
            "/resume": control.resume,
            "/step": control.step,
            "/next": control.run_to_next_change,
            "/stop": control.stop,
            "/acknowledge": control.acknowledge,
            "/approve": control.resume,
            "/refuse": self._refuse,
            "/clear": clear,
            **{f"/fault/{name}": partial(inject, name) for name in _OFFERED},
            **{f"/break/{i}": partial(self._toggle, hook) for i, hook in enumerate(self._hooks)},
        }
        if self._may_force:
            self._actions |= {
                f"/force/{i}/{name}": partial(hook.force, status)
                for i, hook in enumerate(self._hooks)
                for name, status in _FORCED.items()
            }
        self._server = listen(self, port)
        self._thread = threading.Thread(
            target=self._server.serve_forever, args=(_SHUTDOWN_POLL,), name="page", daemon=True
        )
        self._thread.start()

    @property
    def port(self) -> int:
        """The port that it listens on."""
        return int(self._server.server_port)

    @property
    def url(self) -> str:
        """The page with its token, in the part of the address that browsers do not send."""
        return f"http://{HOST}:{self.port}/#{self.token}"

    @property
    def hosts(self) -> tuple[str, ...]:
        """Host names under which a browser may address this server."""
        return (f"{HOST}:{self.port}", f"localhost:{self.port}")

    @property
    def viewer_hosts(self) -> str:
        """To whom the embedded viewer may connect."""
        return f"'self' {self.viewer.data_origin}" if self.viewer else "'self'"

    def show(self, snapshot: Snapshot) -> None:
        """Set the tick that the page shows."""
        self._snapshot = snapshot
        self._history.note(snapshot)

    def end(self, ending: Ending) -> None:
        """Show that the run is over, and how it ended; no button works any more."""
        self.recording = ending.recording
        self._ending = ending

    def action(self, path: str) -> Callable[[], None] | None:
        """What a POST to a path does; None if nothing does."""
        return None if self._ending is not None else self._actions.get(path)

    def tree(self) -> list[dict[str, object]]:
        """The nodes, for JSON."""
        return [
            {"name": n.name, "title": n.title, "kind": n.kind, "depth": n.depth} for n in self._tree
        ]

    def history(self, node: int) -> list[dict[str, object]]:
        """What a node has done, for JSON; empty for a number that none has."""
        return self._history.of(node) if 0 <= node < len(self._tree) else []

    def state(self) -> dict[str, object]:
        """What the page shows, for JSON."""
        state, snapshot, ending = self._control.state, self._snapshot, self._ending
        waiting = next((i for i, hook in enumerate(self._hooks) if hook.waiting), None)
        to_approve = waiting is not None and self._hooks[waiting].asks
        shown: dict[str, object] = {
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
            "waiting": waiting,
            "approve": self._tree[waiting].title if waiting is not None and to_approve else "",
            "over": None,
        }
        if ending is not None:
            source = f"http://{HOST}:{self.port}{self.recording_path}"
            shown["over"] = {
                "outcome": ending.outcome,
                "explanation": ending.explanation,
                "viewer": f"/viewer/{viewer_address(source)}" if ending.recording else None,
            }
        if snapshot is not None:
            index = tip(snapshot.nodes)
            shown |= {
                "time": snapshot.stamp,
                "tip": index,
                "node": self._tree[index].name,
                "status": snapshot.nodes[index].status.value.lower(),
                "message": snapshot.nodes[index].message,
                "faults": [fault.text for fault in snapshot.state.faults],
                "looks": [look.value for look in looks(self._tree, snapshot.nodes)],
            }
        return shown

    def _breaks(self, hook: Hook) -> bool:
        action = hook.actions.get(Side.BEFORE)
        return action is not None and action.replace_with is None

    def _toggle(self, hook: Hook) -> None:
        """Set or remove a breakpoint before a node."""
        if self._breaks(hook):
            hook.actions.pop(Side.BEFORE, None)
        else:
            hook.actions[Side.BEFORE] = HookAction()

    def _refuse(self) -> None:
        """Let the node fail that waits for approval."""
        for hook in self._hooks:
            if hook.waiting and hook.asks:
                hook.answer = Status.FAILURE
                self._control.resume()

    def __enter__(self) -> ControlPage:
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()
