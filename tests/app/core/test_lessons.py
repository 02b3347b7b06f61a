"""The tasks that docs/authoring.md goes through, from beginning to end; the world says what came
of them."""

import json
from math import atan2, pi, radians
from pathlib import Path

import pytest
from command_line import call
from py_trees.common import Status

from frankie_task.testing import trial
from trees.language import build, load
from trees.site import check

LESSONS = Path(__file__).parents[3] / "trees" / "lessons"
SEEDS = (1, 2, 3)


def run(record: Path, lesson: str, *arguments: object) -> tuple[int, dict]:
    """Exit code and summary of a run."""
    path = LESSONS / f"{lesson}.yaml"
    code, out, err = call("run", path, *arguments, "--record", record, "--json")
    assert code in (0, 1), err
    return code, json.loads(out)


def do(lesson: str, scene: str, seed: int) -> dict[str, str]:
    """Run a lesson to its end; what carries each object then."""
    task = load(LESSONS / f"{lesson}.yaml")
    beside = LESSONS / scene
    with trial(beside if beside.exists() else scene, seed=seed) as t:
        root = build(task, t.context)
        assert t.run(root, seconds=400.0) is Status.SUCCESS, root.feedback_message
        return dict(t.world.supports())


@pytest.mark.parametrize("path", sorted(LESSONS.glob("*.yaml")), ids=lambda path: path.stem)
def test_no_lesson_or_scene_has_a_mistake(path):
    assert check(path) == []


@pytest.mark.slow
def test_what_is_in_the_hand_after_a_fault_is_carried_on(tmp_path):
    code, summary = run(tmp_path, "carry_on", "--seed", 1, "--fault", "reflex@carry")
    assert code == 0
    assert (summary["placed"], summary["attempts"]) == (1, 1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_one_object_is_fetched(seed):
    assert list(do("fetch_one", "single", seed).values()) == ["table"]


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_red_things_go_to_the_left_table_and_all_others_to_the_right_one(seed):
    where = do("sort", "sort_scene.yaml", seed)
    assert where == {
        "box 1": "table",
        "can 2": "table",
        "ball 3": "right_table",
        "cylinder 4": "right_table",
    }


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_a_round_collects_what_stands_on_both_tables(seed):
    assert set(do("collect", "tidy_two_tables", seed).values()) == {"container"}


@pytest.mark.slow
def test_a_round_ends_at_home_when_the_battery_gets_low(tmp_path):
    code, summary = run(tmp_path, "collect", "--seed", 1, "-p", "reserve_percent=99.8")
    assert code == 1
    assert summary["messages"] == ["I break off, and go home."]
    assert "at home" in summary["reason"]


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_tools_are_brought_from_a_scene_of_ones_own(seed):
    assert set(do("workshop", "workshop_scene.yaml", seed).values()) == {"table"}


@pytest.mark.slow
def test_one_box_stands_exactly_at_its_pose_and_the_other_one_on_it():
    task = load(LESSONS / "stack.yaml")
    with trial(LESSONS / "stack_scene.yaml", seed=1) as t:
        root = build(task, t.context)
        assert t.run(root, seconds=400.0) is Status.SUCCESS, root.feedback_message
        below, above = (one.pose for one in t.world.objects)
        heights = [one.parts[0].shape.half[2] for one in t.world.objects]
    assert below.translation[:2] == pytest.approx([0.1, 1.6], abs=0.005)
    turn = atan2(below.rotation[1, 0], below.rotation[0, 0]) - radians(30.0)
    assert (turn + pi / 2.0) % pi - pi / 2.0 == pytest.approx(0.0, abs=radians(4.0))
    assert above.translation[:2] == pytest.approx(below.translation[:2], abs=0.01)
    assert above.translation[2] - below.translation[2] == pytest.approx(sum(heights), abs=0.002)


@pytest.mark.slow
@pytest.mark.parametrize(("fault", "said"), [((), 2), (("--fault", "object taken@offer"), 1)])
def test_a_person_takes_it_or_it_goes_on_the_table(tmp_path, fault, said):
    code, summary = run(tmp_path, "hand_over", "--seed", 1, *fault)
    assert code == 0, summary["reason"]
    assert (len(summary["messages"]), summary["claimed"]) == (said, said - 1)
