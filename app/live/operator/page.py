"""Control page in the browser: shows the tree of a run, and pauses, steps and stops it.

The page draws the tree itself, independent of the 3-D viewer, and shows the age of its state.
"""

from collections.abc import Callable, Sequence
from functools import partial
from urllib.parse import urlsplit

from py_trees.common import Status

from app.live.nodes import NodeInfo, looks, tip
from app.live.operator.control import Control
from app.live.operator.hooks import Hook
from app.live.snapshot import Snapshot
from app.live.web import viewer_address
from app.task_time import task_time
from hw import INJECTABLE, stopwatch

_OFFERED = tuple(name for name, fault in INJECTABLE.items() if not fault.of_world)
_LOST = 0.5  # two standard deviations of the position from which the robot is not localised [m]
_FORCED = {"success": Status.SUCCESS, "failure": Status.FAILURE, "nothing": None}


class ControlPage:
    """State of one run for the page, and the actions of its buttons; served by a `PageServer`.

    `tree` has the nodes in preorder and `hooks` their hooks; `inject` takes a name in `INJECTABLE`.
    `viewer` is live data for a viewer on the page, as `rerun+http://127.0.0.1:9876/proxy`, and
    `may_force` whether people may force the outcome of a node. `seconds` is real time [s].
    """

    def __init__(
        self,
        control: Control,
        tree: Sequence[NodeInfo],
        *,
        inject: Callable[[str], None],
        clear: Callable[[], None],
        viewer: str | None = None,
        hooks: Sequence[Hook] = (),
        may_force: bool = False,
        seconds: Callable[[], float] = stopwatch,
    ) -> None:
        self.viewer_hosts = "'self'" + (f" http://{urlsplit(viewer).netloc}" if viewer else "")
        """To which the viewer on the page may connect."""
        self._control = control
        self._tree = tuple(tree)
        self._viewer = viewer
        self._hooks = tuple(hooks)
        self._may_force = may_force
        self._seconds = seconds
        self._snapshot: Snapshot | None = None
        self._shown_at = seconds()
        self._finished = False
        self._outcome = self._explanation = ""
        self._actions: dict[str, Callable[[], None]] = {
            "/pause": control.pause,
            "/resume": control.resume,
            "/step": control.step,
            "/next": control.run_to_next_change,
            "/acknowledge": control.acknowledge,
            "/clear": clear,
        }
        self._actions |= {f"/fault/{name}": partial(inject, name) for name in _OFFERED}
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
        self._snapshot, self._shown_at = snapshot, self._seconds()

    def finish(self) -> None:
        """Report that the robot is at rest and no tick follows."""
        self._finished = True

    def end(self, outcome: str, explanation: str) -> None:
        """Show how the run ended, and disable the buttons."""
        self._outcome, self._explanation = outcome, explanation

    def stop(self) -> None:
        """End the run."""
        self._control.stop()

    def action(self, path: str) -> Callable[[], None] | None:
        """The action of a POST to a path; None if there is none."""
        return None if self._outcome else self._actions.get(path)

    def tree(self) -> list[dict[str, object]]:
        """The nodes, for JSON."""
        return [{"title": n.title, "kind": n.kind, "depth": n.depth} for n in self._tree]

    def state(self) -> dict[str, object]:
        """What the page shows, for JSON; `age` is that of the tick [s]."""
        state, snapshot = self._control.state, self._snapshot
        waiting = next((i for i, hook in enumerate(self._hooks) if hook.waiting), None)
        to_approve = waiting is not None and self._hooks[waiting].asks
        shown: dict[str, object] = {
            "phase": self._phase,
            "age": self._seconds() - self._shown_at,
            "paused": state.paused,
            "why": state.why,
            "stopped": self._control.stopped,
            "ticks": state.ticks,
            "emergency": state.emergency,
            "pressed": state.pressed,
            "injectable": _OFFERED,
            "viewer": f"/viewer/{viewer_address(self._viewer)}" if self._viewer else None,
            "can_force": self._may_force,
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
        if snapshot is not None:
            index = tip(snapshot.nodes)
            shown |= {
                "time": task_time(snapshot.time, snapshot.paused_s),
                "tip": index,
                "node": self._tree[index].name,
                "message": snapshot.nodes[index].message,
                "localised": _localised(snapshot),
                "faults": [fault.text for fault in snapshot.state.faults],
                "looks": looks(self._tree, snapshot.nodes),
            }
        return shown

    @property
    def _phase(self) -> str:
        if self._outcome:
            return "over"
        if self._finished:
            return "finished"
        return "starting" if self._snapshot is None else "running"

    def _answer(self, hook: Hook, answer: Status | None) -> None:
        """Let the node begin, or end, that waits for approval, unless another waits by now."""
        if hook.waiting and hook.asks:
            hook.answer = answer
            self._control.resume()


def _localised(snapshot: Snapshot) -> str:
    """How well the robot knows where it is; empty where that is exact."""
    if snapshot.estimate is None:
        return ""
    two_sigma, _ = snapshot.estimate.two_sigma
    return f"localised to ±{1000.0 * two_sigma:.0f} mm" if two_sigma < _LOST else "not localised"
