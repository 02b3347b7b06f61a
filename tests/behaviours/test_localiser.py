"""Corrections of where the map is: no command jumps, and what is locked stays where it is."""

from dataclasses import replace

import numpy as np
from harness import Harness, looking_down, table_world
from pinocchio import SE3, utils

from behaviours import ToolPose
from controller import PoseGoal
from hw.state import LocalisedPose


class Corrected:
    """The harness with a base that is localised wrongly, and differently all the time."""

    def __init__(self, size: float, every: int = 1, seed: int = 0) -> None:
        self.harness = harness = Harness(table_world())
        self._every, self._rng = every, np.random.default_rng(seed)
        self._sigma = np.array([size / 2.0, size / 2.0, 0.4 * size]) + 1e-6
        self.corrections = self._ticks = 0
        self._newest: LocalisedPose | None = None
        self._read, harness.robot.read = harness.robot.read, self._wrong

    def _wrong(self):
        state = self._read()
        if self._ticks % self._every == 0:
            x, y, turn = self._sigma * self._rng.normal(size=3)
            self._newest = LocalisedPose(
                stamp=state.stamp,
                mTb=state.oTb * SE3(utils.rotate("z", turn), np.array([x, y, 0.0])),
                covariance=np.diag(self._sigma) ** 2,
            )
            self.corrections += 1
        self._ticks += 1
        return replace(state, localised=self._newest)


def test_no_correction_makes_a_command_jump():
    """To goals of both kinds in turn; the gate refuses what no limit allows."""
    run = Corrected(0.1)
    harness, context = run.harness, run.harness.context
    places = [
        ToolPose(name="there", mTe=looking_down(0.6, 0.3, 0.8), frame=context),
        ToolPose(name="far", mTe=looking_down(-1.5, 1.0, 0.8), frame=context),
    ]
    moved = 0.0
    while run.corrections < 400:
        before = context.localisation.mTb
        place = places[(run.corrections // 200) % 2]
        state = harness.robot.read()
        context.begin_tick(state)
        step = context.localisation.mTb.translation - before.translation
        moved = max(moved, float(np.linalg.norm(step)))
        harness.step(state, PoseGoal(target=place.oTe))
    assert not any(harness.gate.refusals.values())
    assert moved > 0.001


def test_a_locked_pose_is_reached_as_if_nothing_had_been_corrected():
    ends = []
    for size in (0.0, 0.1):
        run = Corrected(size, every=20)
        harness = run.harness
        goal = PoseGoal(target=looking_down(0.7, 0.1, 0.7), straight=True)
        for _ in range(400):
            harness.pursue(goal)
        ends.append(harness.context.oTe)
    assert np.linalg.norm(ends[0].translation - ends[1].translation) < 0.003
    assert np.linalg.norm(ends[1].translation - goal.target.translation) < 0.003


def test_where_nothing_is_localised_the_map_is_the_world():
    harness = Harness(table_world())
    harness.tick(None)
    here = harness.context.localisation
    assert here.mTo is None
    assert here.estimate is None
    place = ToolPose(name="there", mTe=looking_down(1.0, 0.0, 0.8), frame=here)
    assert place.oTe is place.mTe
