"""The tasks that docs/authoring.md goes through, from beginning to end; the world says what came
of them."""

import json
from importlib.util import find_spec
from math import atan2, pi, radians
from pathlib import Path

import numpy as np
import pytest
from command_line import call
from pinocchio import SE3
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel

from frankie_task.testing import Trial, trial
from trees.language import build, load
from trees.site import check

LESSONS = Path(__file__).parents[3] / "trees" / "lessons"
SEEDS = (1, 2, 3)
PHYSICS = pytest.mark.skipif(find_spec("mujoco") is None, reason="needs the extra `physics`")
each_world = pytest.mark.parametrize("world", ["kinematic", pytest.param("physics", marks=PHYSICS)])


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
@each_world
@pytest.mark.parametrize("seed", SEEDS)
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
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("fault", "on"), [((), "table"), (("--fault", "object taken@offer"), "floor")]
)
def test_a_person_takes_it_or_it_goes_on_the_table(tmp_path, world, seed, fault, on):
    scene = tmp_path / "one_box.yaml"
    boxes = (LESSONS / "stack_scene.yaml").read_text()
    scene.write_text(boxes.replace("    - {kind: box, colour: blue}\n", ""))
    where = ("--scene", scene, "--seed", seed, "--world", world)
    code, summary = run(tmp_path, "hand_over", *where, *fault)
    assert code == 0, summary["reason"]
    assert list(summary["lies_on"].values()) == [on]
    assert len(summary["messages"]) == (1 if fault else 2)


@pytest.mark.slow
@pytest.mark.flaky(reruns=2)  # in real time
def test_an_emulated_robot_hands_over(tmp_path):
    robot = ("--robot", "emulated", "--arm-the-robot", "--fault", "object taken@offer")
    code, summary = run(tmp_path, "hand_over", "--seed", 1, *robot)
    assert code == 0, summary["reason"]
    assert list(summary["lies_on"].values()) == ["floor"]


class Person(Behaviour):
    """Holds the first object between the fingers that feel for it, until they have it."""

    def __init__(self, t: Trial, root: Behaviour) -> None:
        super().__init__("person")
        [self._receive] = [one for one in root.iterate() if getattr(one, "key", "") == "receive"]
        self._trial, self._gift = t, t.world.objects[0]

    def update(self) -> Status:
        is_taken = self._trial.world.supports()[self._gift.name] == "hand"
        if self._receive.status is Status.RUNNING and self._receive.phase and not is_taken:
            self._gift.pose = self._trial.context.wTe * SE3(np.eye(3), np.array([0.0, 0.0, 0.02]))
        return Status.RUNNING


@pytest.mark.slow
@each_world
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("gives", [True, False])
def test_what_a_person_gives_goes_on_the_table_and_without_it_the_robot_goes_home(
    world, seed, gives
):
    task = load(LESSONS / "porter.yaml")
    with trial(LESSONS / "stack_scene.yaml", seed=seed, world=world) as t:
        root = build(task, t.context)
        first = ParallelPolicy.SuccessOnSelected([root], synchronise=False)
        together = Parallel("both", first, [Person(t, root), root]) if gives else root
        assert t.run(together, seconds=200.0) is Status.SUCCESS, root.feedback_message
        on, home = t.world.supports()["box 1"], t.context.state.wTb.translation[:2]
    assert on == ("table" if gives else "container")
    assert gives or np.linalg.norm(home) < 0.05


@pytest.mark.slow
@each_world
def test_a_way_that_is_blocked_ends_honestly(tmp_path, world):
    path = tmp_path / "blocked.yaml"
    crate = "{name: crate, centre: [1.6, 0.4], size: [0.6, 0.6], height: 0.5, objects: {count: 0}}"
    at_hall = f"side_tables: [{crate}]\n"
    path.write_text((LESSONS / "stack_scene.yaml").read_text() + at_hall)
    with trial(path, seed=1, world=world) as t:
        root = build(load(LESSONS / "porter.yaml"), t.context)
        assert t.run(root, seconds=200.0) is Status.FAILURE
        assert "hall" in root.feedback_message
        assert not t.world.touches
        assert not t.context.log.messages
