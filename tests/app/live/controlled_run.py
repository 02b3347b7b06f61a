"""A session in simulation that a test pauses, steps, stops and hooks into."""

import time

import numpy as np
from harness import Harness, looking_down
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from app.core.measurements import Measurements
from app.core.session import Session
from app.live import Control
from app.live.operator import insert_hooks, matching
from behaviours import Context, Leaf
from controller import PoseGoal
from trees.language import nodes_in_order

AWAY = looking_down(3.0, 0.5, 0.8)


def session_of(
    harness: Harness, root: Behaviour, control: Control, watch
) -> tuple[Session, Measurements]:
    """A session on a harness, and what it measures."""
    measurements = Measurements(limits=harness.controller.model.limits)
    session = Session(
        root=root,
        context=harness.context,
        controller=harness.controller,
        gate=harness.gate,
        measurements=measurements,
        clock=harness.task_clock,
        control=control,
        watch=watch,
    )
    return session, measurements


class Going(Leaf):
    """Moves towards a far goal for some ticks, then ends with a chosen status."""

    key = "going"

    def __init__(self, name: str, context: Context, *, ticks: int, end=Status.SUCCESS) -> None:
        super().__init__(name, context)
        self._ticks, self._end = ticks, end
        self.begun = self.halted = 0
        self.updates: list[float] = []
        self.reports: list[bool] = []

    def initialise(self) -> None:
        self.begun += 1
        self._left = self._ticks

    def update(self) -> Status:
        self.reports.append(self.pursue(PoseGoal(wTe=AWAY)) is not None)
        self.updates.append(self.context.clock.now())
        self._left -= 1
        if self._left > 0:
            return self.running("going")
        self.feedback_message = "told to end"
        return self._end

    def terminate(self, new_status: Status) -> None:
        self.halted += self.status is Status.RUNNING


class ControlledRun:
    """A session with a tree of such leaves, and actions after chosen ticks."""

    def __init__(self, make_root, at=None, hooked=(), real_seconds=60.0) -> None:
        self.harness = Harness()
        self.control = Control()
        self.clock = self.harness.task_clock
        self.ticks = []
        self._at = at or {}
        root = make_root(self.harness.context)
        self.nodes = nodes_in_order(root)
        self.reached = []
        self.root, self.hooks = insert_hooks(
            root, [n for name in hooked for n in matching(self.nodes, name)], self._reached
        )
        self._deadline = time.monotonic() + real_seconds

    def _reached(self, hook) -> None:
        self.reached.append(hook.name)
        self.control.pause(f"before {hook.name}")

    def _watch(self, tick) -> None:
        self.ticks.append(tick)
        if action := self._at.get(len(self.ticks)):
            action()
        assert time.monotonic() < self._deadline, "the run never ends"

    def run(self):
        session, self.measurements = session_of(self.harness, self.root, self.control, self._watch)
        return session.run()

    def speed_after(self, ticks: int) -> float:
        state = self.ticks[ticks].state
        return float(max(np.abs(state.base_twist).max(), np.abs(state.qd).max()))

    @property
    def commands(self) -> np.ndarray:
        """(ticks, 10) as they were applied."""
        return np.array([[*tick.applied.base_twist, *tick.applied.qd] for tick in self.ticks])

    def assert_kept_limits(self, emergency: bool = False) -> None:
        commands = self.commands
        limits = self.harness.controller.model.limits
        base = limits.base_emergency if emergency else limits.base_acceleration
        allowed = np.concatenate([base, limits.qdd]) * 0.01
        assert (np.abs(np.diff(commands, axis=0)) <= allowed + 1e-9).all()
        assert self.measurements.limit_violations == 0


def leaf(name="going", ticks=200, end=Status.SUCCESS):
    return lambda context: Going(name, context, ticks=ticks, end=end)
