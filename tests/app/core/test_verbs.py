"""Verbs that no lesson shows, in both worlds: the world says what came of them."""

from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel

from frankie_task.testing import Trial, trial
from hw.sim.contact import separation
from robots import Box, Geom, Plane
from trees.language import build, load

SCENE = Path(__file__).parents[3] / "trees/lessons/stack_scene.yaml"
WAY = np.array([[0.7, -0.25, 0.75], [0.9, 0.0, 0.75], [0.9, 0.5, 0.75], [1.6, 1.1, 0.75]])
POSES = ", ".join(f"{{xyz: {at.tolist()}, rpy_deg: [180, 0, 0]}}" for at in WAY)
PLACES = f"""\
task: verbs
poses:
  above: {{xyz: [2.935, 0.0, 0.85], rpy_deg: [180, 0, 0]}}
  at_table: {{xyz: [0.0, 1.40, 0.85], rpy_deg: [180, 0, 90]}}
  way: [{POSES}]
regions:
  container: {{centre: [3.0, 0.0, 0.556], size: [0.44, 0.36, 0.20]}}
  table: {{centre: [0.0, 1.6, 0.60], size: [1.0, 0.4, 0.2]}}
tree:
"""


class Trace(Behaviour):
    """When the hand is where."""

    def __init__(self, t: Trial) -> None:
        super().__init__("trace")
        self._trial, self.rows = t, []

    def update(self) -> Status:
        self.rows.append([self._trial.now(), *self._trial.context.wTe.translation])
        return Status.RUNNING


def the_hand_keeps_to_the_way_at_its_speed(t: Trial, rows: np.ndarray) -> None:
    rows = rows[np.linalg.norm(rows[:, 1:] - WAY[0], axis=1).argmin() :]
    hand, steps, off = rows[:, 1:], np.diff(rows, axis=0), []
    for a, b in pairwise(WAY):
        share = np.clip((hand - a) @ (b - a) / np.sum((b - a) ** 2), 0.0, 1.0)
        off.append(np.linalg.norm(hand - a - np.outer(share, b - a), axis=1))
    assert np.min(off, axis=0).max() < 0.02
    speed = np.linalg.norm(steps[:, 1:], axis=1) / steps[:, 0]
    assert np.median(speed) == pytest.approx(0.2, abs=0.02)
    assert np.linalg.norm(hand[-1] - WAY[-1]) < 0.025


def they_stand_on_the_first_places(t: Trial, rows: np.ndarray) -> None:
    at = np.array(sorted(tuple(one.pose.translation[:2]) for one in t.world.objects))
    np.testing.assert_allclose(at, [[-1 / 3, 1.6], [0.0, 1.6]], atol=0.03)
    assert set(t.world.supports().values()) == {"table"}


def the_base_keeps_off(t: Trial, rows: np.ndarray) -> None:
    half = (*np.array(t.context.robot.description.base.size[:2]) / 2.0, 0.5)
    things = [one for one in t.world.fixtures if not isinstance(one.shape, Plane)]
    assert 0.3 < min(separation(Geom(Box(half), t.world.base), one)[0] for one in things) < 0.5


TASKS = [
    (
        "for_each: {item: to, in: way, do: {navigate: "
        "{to: $to, straight: true, speed_m_s: 0.2, within_m: 0.02}}}",
        the_hand_keeps_to_the_way_at_its_speed,
    ),
    (
        "for_each: {item: colour, in: [red, blue], do: {sequence: [navigate: {to: above}, "
        "{timeout_s: 3, wait_until: {object_visible: {within: container, least: 1}}}, "
        "open_gripper, grasp: {within: container, colour: $colour}, retreat_check, "
        "navigate: {to: at_table}, place: {on: table, pitch_m: 0.3}]}}",
        they_stand_on_the_first_places,
    ),
    (
        "{force_success: true, drive: {forward_m: 5}, "
        "while: {not: {obstacle_within: {distance_m: 0.5, sector_deg: 240}}}}",
        the_base_keeps_off,
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize(
    "world", ("kinematic", "physics") if find_spec("mujoco") else ("kinematic",)
)
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(("tree", "judge"), TASKS, ids=lambda one: getattr(one, "__name__", ""))
def test_what_is_seen_in_the_world(tmp_path, tree, judge, seed, world):
    path = tmp_path / "verbs.yaml"
    path.write_text(f"{PLACES}  {tree}\n")
    with trial(SCENE, seed=seed, world=world) as t:
        root, trace = build(load(path), t.context), Trace(t)
        first = ParallelPolicy.SuccessOnSelected([root], synchronise=False)
        end = t.run(Parallel("both", first, [trace, root]), seconds=200.0)
        assert end is Status.SUCCESS, root.feedback_message
        judge(t, np.array(trace.rows))
