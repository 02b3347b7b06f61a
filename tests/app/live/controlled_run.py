"""A session in simulation that a test pauses, steps, stops, hooks into, or troubles."""

from __future__ import annotations

import time
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
from harness import Harness, looking_down
from py_trees.common import Status

from app.core.measurements import Measurements
from app.core.session import Session
from app.live import Control
from app.live.hooks import insert_hooks, matching
from behaviours import Context, Leaf
from controller import PoseGoal
from trees.language import nodes_in_order
from trees.words.composites import Sequence


class Going(Leaf):
    """Moves towards a far goal for some ticks, looking for grasps; then ends as it is told."""

    key = "going"

    def __init__(self, name: str, context: Context, *, ticks: int, end=Status.SUCCESS) -> None:
        super().__init__(name, context)
        self._ticks, self._end = ticks, end
        self.begun = self.halted = 0
        self.updates: list[float] = []

    def initialise(self) -> None:
        self.begun += 1
        self._left = self._ticks

    def update(self) -> Status:
        self.pursue(PoseGoal(target=looking_down(8.0, 0.5, 0.8)))
        self.context.vision.new_frame()
        self.updates.append(self.context.clock.now())
        self._left -= 1
        if self._left > 0:
            return self.running("going")
        self.feedback_message = "told to end"
        return self._end

    def terminate(self, new_status: Status) -> None:
        self.halted += self.status is Status.RUNNING


def leaf(name="going", ticks=200, end=Status.SUCCESS):
    return lambda context: Going(name, context, ticks=ticks, end=end)


def two_leaves(context: Context) -> Sequence:
    return Sequence("sequence", [leaf("first", 20)(context), leaf("second", 20)(context)])


class ControlledRun:
    """A session with a tree of such leaves, and actions after chosen ticks."""

    def __init__(self, make_root, at=None, hooked=(), real_clock=False) -> None:
        self.harness = Harness(real_clock=real_clock)
        self.control = Control()
        self.measurements = Measurements(limits=self.harness.controller.model.limits)
        self.ticks = []
        self._at = at or {}
        root = make_root(self.harness.context)
        self.nodes = nodes_in_order(root)
        self.reached = []
        self.root, self.hooks = insert_hooks(
            root, [n for name in hooked for n in matching(self.nodes, name)], self._reached
        )
        self._deadline = time.monotonic() + 60.0

    def _reached(self, hook) -> None:
        self.reached.append(hook.name)
        self.control.pause(f"before {hook.name}")

    def _watch(self, tick) -> None:
        self.ticks.append(tick)
        if action := self._at.get(len(self.ticks)):
            action()
        assert time.monotonic() < self._deadline, "the run never ends"

    def run(self):
        setup = SimpleNamespace(
            context=self.harness.context,
            controller=self.harness.controller,
            gate=self.harness.gate,
            clock=self.harness.task_clock,
        )
        session = Session(
            setup, self.root, self.control, self._watch, measurements=self.measurements
        )
        self.outcome = session.run()
        return self.outcome

    def speed_after(self, ticks: int) -> float:
        state = self.ticks[ticks].state
        return float(max(np.abs(state.base_twist).max(), np.abs(state.qd).max()))

    @property
    def true_speed(self) -> float:
        """Of the simulated robot itself, whatever a test does to its calls [m/s or rad/s]."""
        state = self.harness.robot._robot.read()
        return float(np.abs((*state.base_twist, *state.qd)).max())

    @property
    def commands(self) -> np.ndarray:
        """(ticks, 10) as they were applied."""
        return np.array([[*tick.applied.base_twist, *tick.applied.qd] for tick in self.ticks])

    def assert_kept_limits(self, emergency: bool = False) -> None:
        limits = self.harness.controller.model.limits
        base = limits.base_emergency if emergency else limits.base_acceleration
        allowed = np.concatenate([base, limits.qdd]) * 0.01
        assert (np.abs(np.diff(self.commands, axis=0)) <= allowed + 1e-9).all()
        assert self.measurements.limit_violations == 0

    def assert_came_smoothly_to_rest(self, emergency: bool = False) -> None:
        assert self.harness.speed < 1e-3
        assert np.abs(self.commands).max() > 0.5  # it was really moving
        assert np.abs(self.commands[-1]).max() < 1e-3
        self.assert_kept_limits(emergency)


class TroubledRun(ControlledRun):
    """The robot drives off; from some tick on, one call gets into trouble before it is made."""

    def __init__(
        self, place: str, trouble: Callable[[], None], *, since: int, until: int, real_clock=False
    ) -> None:
        super().__init__(
            lambda context: Sequence("sequence", [leaf("driver", 10**6)(context)]),
            at={until: lambda: self.control.stop()},
            real_clock=real_clock,
        )
        harness, driver = self.harness, self.nodes[1].node
        owner, name = {
            "read": (harness.robot, "read"),
            "send": (harness.robot, "send"),
            "leaf": (driver, "update"),
            "halt": (driver, "terminate"),
            "tree": (self.root, "advance"),
            "camera": (harness.context.vision._camera, "latest"),
            "controller": (harness.controller, "step"),
            "gate": (harness.gate, "judge"),
            "context": (harness.context, "end_tick"),
        }[place]
        call, stop = getattr(owner, name), harness.robot.stop
        self.stops: list[float] = []

        def troubled(*args, **kwargs):
            if len(self.ticks) >= since:
                trouble()
            return call(*args, **kwargs)

        def noted_stop() -> None:
            self.stops.append(time.monotonic())
            stop()

        setattr(owner, name, troubled)
        harness.robot.stop = noted_stop
