"""The tasks that docs/authoring.md goes through, from beginning to end; the world says what came
of them."""

from importlib.util import find_spec
from itertools import pairwise
from math import atan2, pi, radians
from pathlib import Path

import numpy as np
import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel
from recorded_runs import faulty_words
from test_shipped_tasks import run

from frankie_task.testing import Trial, trial
from trees.language import build, load
from trees.site import check

LESSONS = Path(__file__).parents[3] / "trees" / "lessons"
PHYSICS = pytest.mark.skipif(find_spec("mujoco") is None, reason="needs the extra `physics`")
each_world = pytest.mark.parametrize(
    ("world", "seed"), [("kinematic", 1), pytest.param("physics", 2, marks=PHYSICS)]
)


def carries(on: str | list[str], folder: Path, lesson: str, *words: object) -> None:
    """Runs a lesson to its end, and sees what carries its objects: one thing, or each its own."""
    code, summary, _ = run(folder, LESSONS / f"{lesson}.yaml", *words)
    assert code == 0, summary["reason"]
    where = list(summary["lies_on"].values())
    assert where == ([on] * len(where) if isinstance(on, str) else on)


@pytest.mark.parametrize("path", sorted(LESSONS.glob("*.yaml")), ids=lambda path: path.stem)
def test_no_lesson_or_scene_has_a_mistake(path):
    assert check(path) == []


@pytest.mark.slow
def test_what_is_in_the_hand_after_a_fault_is_carried_on(tmp_path):
    words = ("--seed", 1, *faulty_words("reflex@carry"))
    code, summary, _ = run(tmp_path, LESSONS / "carry_on.yaml", *words)
    assert (code, summary["placed"], summary["attempts"]) == (0, 1, 1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lesson", "on", "seed"),
    [
        ("fetch_one", "table", 1),
        ("sort", ["table", "table", "right_table", "right_table"], 2),
        ("collect", "container", 3),
        ("workshop", "table", 1),
    ],
)
def test_things_come_where_they_belong(tmp_path, lesson, on, seed):
    carries(on, tmp_path, lesson, "--seed", seed)


@pytest.mark.slow
def test_a_round_ends_at_home_when_the_battery_gets_low(tmp_path):
    words = ("--seed", 1, "-p", "reserve_percent=99.8")
    code, summary, _ = run(tmp_path, LESSONS / "collect.yaml", *words)
    assert (code, summary["messages"]) == (1, ["I break off, and go home."])
    assert "at home" in summary["reason"]


@pytest.mark.slow
@each_world
def test_one_box_stands_exactly_at_its_pose_and_the_other_one_on_it(world, seed):
    task = load(LESSONS / "stack.yaml")
    with trial(LESSONS / "stack_scene.yaml", seed=seed, world=world) as t:
        root = build(task, t.context)
        assert t.run(root, seconds=400.0) is Status.SUCCESS, root.feedback_message
        below, above = (one.pose for one in t.world.objects)
        heights = [one.parts[0].shape.half[2] for one in t.world.objects]
        assert [name for name, _ in t.context.log.pictures] == ["stack"]
    assert below.translation[:2] == pytest.approx([0.1, 1.6], abs=0.01)
    turn = atan2(below.rotation[1, 0], below.rotation[0, 0]) - radians(30.0)
    assert (turn + pi / 4.0) % (pi / 2.0) - pi / 4.0 == pytest.approx(0.0, abs=radians(6.0))
    assert above.translation[:2] == pytest.approx(below.translation[:2], abs=0.02)
    assert above.translation[2] - below.translation[2] == pytest.approx(sum(heights), abs=0.003)


@pytest.mark.slow
@each_world
@pytest.mark.parametrize(
    ("lesson", "fault", "on"),
    [
        ("hand_over", "object pulled@offer", "floor"),
        ("hand_over", "", "table"),
        ("porter", "object given@offer", "table"),
        ("porter", "", "container"),
    ],
)
def test_a_person_takes_or_gives_it_or_does_not(tmp_path, lesson, fault, on, seed, world):
    scene = tmp_path / "one_box.yaml"
    boxes = (LESSONS / "stack_scene.yaml").read_text()
    scene.write_text(boxes.replace("    - {kind: box, colour: blue}\n", ""))
    faults = faulty_words(*filter(None, [fault]), world=world)
    carries(on, tmp_path, lesson, "--scene", scene, "--seed", seed, *faults)


GIVE = """\
task: give
poses:
  out: {xyz: [0.62, 0.05, 0.75], rpy_deg: [180, -20, 0]}
tree:
  sequence: [receive: {at: out, every_s: 0.5, timeout_s: 4}, hand_over: {at: out, timeout_s: 10}]
"""


@pytest.mark.slow
@pytest.mark.realtime
@pytest.mark.parametrize(
    ("faults", "end", "on"),
    [
        (("object given@offer", "object pulled@12"), "handed over at out", "floor"),
        (("object given@offer",), "nobody took it within 10 s", "hand"),
        ((), "nothing was given within 4 s", "container"),
    ],
)
def test_an_emulated_hand_receives_and_hands_over(tmp_path, faults, end, on):
    (tmp_path / "give.yaml").write_text(GIVE)
    robot = ("--robot", "emulated", "--arm-the-robot", "--scene", "single", "--seed", 1)
    _, summary, _ = run(tmp_path, tmp_path / "give.yaml", *robot, *faulty_words(*faults))
    assert summary["reason"].endswith(end)
    assert list(summary["lies_on"].values()) == [on]


@pytest.mark.slow
@each_world
def test_a_way_that_is_blocked_ends_honestly(tmp_path, world, seed):
    path = tmp_path / "blocked.yaml"
    crate = "{name: crate, centre: [1.6, 0.4], size: [0.6, 0.6], height: 0.5, objects: {count: 0}}"
    at_hall = f"side_tables: [{crate}]\n"
    path.write_text((LESSONS / "stack_scene.yaml").read_text() + at_hall)
    with trial(path, seed=seed, world=world) as t:
        root = build(load(LESSONS / "porter.yaml"), t.context)
        assert t.run(root, seconds=200.0) is Status.FAILURE
        assert "way_2" in root.feedback_message
        assert not t.world.touches
        assert not t.context.log.messages


class Trace(Behaviour):
    """When the hand is where."""

    def __init__(self, t: Trial) -> None:
        super().__init__("trace")
        self._trial, self.rows = t, []

    def update(self) -> Status:
        self.rows.append([self._trial.now(), *self._trial.context.oTe.translation])
        return Status.RUNNING


WAY = np.array([[0.7, -0.25, 0.75], [0.9, 0.0, 0.75], [0.9, 0.5, 0.75], [1.6, 1.1, 0.75]])
ALONG = f"""\
task: along
poses:
  way: [{", ".join(f"{{xyz: {at.tolist()}, rpy_deg: [180, 0, 0]}}" for at in WAY)}]
tree:
  for_each:
    item: to
    in: way
    do: {{navigate: {{to: $to, straight: true, speed_m_s: 0.2, within_m: 0.02}}}}
"""


@pytest.mark.slow
@each_world
def test_the_hand_keeps_to_a_way_at_its_speed(tmp_path, world, seed):
    path = tmp_path / "along.yaml"
    path.write_text(ALONG)
    with trial(LESSONS / "stack_scene.yaml", seed=seed, world=world) as t:
        root, trace = build(load(path), t.context), Trace(t)
        first = ParallelPolicy.SuccessOnSelected([root], synchronise=False)
        end = t.run(Parallel("both", first, [trace, root]), seconds=200.0)
        assert end is Status.SUCCESS, root.feedback_message
    rows = np.array(trace.rows)
    rows = rows[np.linalg.norm(rows[:, 1:] - WAY[0], axis=1).argmin() :]
    hand, steps, off = rows[:, 1:], np.diff(rows, axis=0), []
    for a, b in pairwise(WAY):
        share = np.clip((hand - a) @ (b - a) / np.sum((b - a) ** 2), 0.0, 1.0)
        off.append(np.linalg.norm(hand - a - np.outer(share, b - a), axis=1))
    assert np.min(off, axis=0).max() < 0.02
    speed = np.linalg.norm(steps[:, 1:], axis=1) / steps[:, 0]
    assert np.median(speed) == pytest.approx(0.2, abs=0.02)
    assert np.linalg.norm(hand[-1] - WAY[-1]) < 0.025
