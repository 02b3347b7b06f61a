"""The tasks that docs/authoring.md goes through, from beginning to end; the world says what came
of them."""

import json
from importlib.util import find_spec
from math import atan2, pi, radians
from pathlib import Path

import pytest
from command_line import call
from py_trees.common import Status

from frankie_task.testing import trial
from trees.language import build, load
from trees.site import check

LESSONS = Path(__file__).parents[3] / "trees" / "lessons"
PHYSICS = pytest.mark.skipif(find_spec("mujoco") is None, reason="needs the extra `physics`")
each_world = pytest.mark.parametrize(
    ("world", "seed"), [("kinematic", 1), pytest.param("physics", 2, marks=PHYSICS)]
)


def run(record: Path, lesson: str, *arguments: object) -> tuple[int, dict]:
    """Exit code and summary of a run."""
    path = LESSONS / f"{lesson}.yaml"
    code, out, err = call("run", path, *arguments, "--record", record, "--json")
    assert code in (0, 1), err
    return code, json.loads(out)


def carries(on: str | list[str], *lesson: object) -> None:
    """Runs a lesson to its end, and sees what carries its objects: one thing, or each its own."""
    code, summary = run(*lesson)
    assert code == 0, summary["reason"]
    where = list(summary["lies_on"].values())
    assert where == ([on] * len(where) if isinstance(on, str) else on)


@pytest.mark.parametrize("path", sorted(LESSONS.glob("*.yaml")), ids=lambda path: path.stem)
def test_no_lesson_or_scene_has_a_mistake(path):
    assert check(path) == []


@pytest.mark.slow
def test_what_is_in_the_hand_after_a_fault_is_carried_on(tmp_path):
    code, summary = run(tmp_path, "carry_on", "--seed", 1, "--fault", "reflex@carry")
    assert code == 0
    assert (summary["placed"], summary["attempts"]) == (1, 1)


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
    code, summary = run(tmp_path, "collect", "--seed", 1, "-p", "reserve_percent=99.8")
    assert code == 1
    assert summary["messages"] == ["I break off, and go home."]
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


PEOPLE = [
    ("hand_over", "object pulled@offer", "floor"),
    ("hand_over", "", "table"),
    ("porter", "object given@offer", "table"),
    ("porter", "", "container"),
]
"""What a person does in a lesson, and what carries the object in the end."""


@pytest.mark.slow
@each_world
@pytest.mark.parametrize(("lesson", "fault", "on"), PEOPLE)
def test_a_person_takes_or_gives_it_or_does_not(tmp_path, lesson, fault, on, seed, world):
    scene = tmp_path / "one_box.yaml"
    boxes = (LESSONS / "stack_scene.yaml").read_text()
    scene.write_text(boxes.replace("    - {kind: box, colour: blue}\n", ""))
    where = ("--scene", scene, "--seed", seed, "--world", world)
    carries(on, tmp_path, lesson, *where, *(("--fault", fault) if fault else ()))


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
    chosen = [word for fault in faults for word in ("--fault", fault)]
    _, summary = run(tmp_path, tmp_path / "give", *robot, *chosen)
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
