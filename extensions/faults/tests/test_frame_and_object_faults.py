"""Injected faults of camera and objects, and the table of all faults."""

import threading
from pathlib import Path

import numpy as np
import pytest
from faulty_robot import DT, Faulty
from harness import TABLE_TOP, Harness, block, looking_down

from config import UserError
from extensions.faults import INJECTABLE
from extensions.faults.effects import Effect
from extensions.faults.injection import FaultInjection
from perception import FrameChecker


def frames(run: Faulty, count: int) -> list:
    """The frames of successive camera periods."""
    seen = []
    for _ in range(count):
        run.read(0.1)
        seen.append(run.robot.camera.latest(10.0))
    return seen


def test_frames_that_are_lost_frozen_black_empty_or_sparse():
    run = Faulty()
    seen = {}
    whole = [f"frames {how}" for how in ("lost", "frozen", "black", "empty", "sparse")]
    for name in (*whole, "picture frozen"):
        run.robot.clear()
        run.robot.inject(name)
        run.read()
        seen[name] = frames(run, 4)
    assert seen["frames lost"] == [None] * 4
    assert len(set(map(id, seen["frames frozen"]))) == 1
    assert run.robot.camera.latest(1.0) is run.robot.camera.latest(1.0)  # until a new one
    frozen = seen["picture frozen"]
    assert len({frame.stamp for frame in frozen}) == 4
    assert all(np.array_equal(f.depth, frozen[0].depth, equal_nan=True) for f in frozen)
    assert all((frame.depth == 0.0).all() for frame in seen["frames black"])
    assert all(np.isnan(frame.depth).all() for frame in seen["frames empty"])
    assert np.isnan(seen["frames sparse"][0].depth).mean() > 0.45
    assert np.isfinite(seen["frames sparse"][0].depth).mean() > 0.3
    assert seen["frames sparse"][0].depth.dtype == np.float32


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("frames in millimetres", "millimetres given as metres"),
        ("frames transposed", "transposed"),
        ("picture frozen", "not even its noise: the camera hangs"),
    ],
)
def test_frames_that_are_not_what_they_claim_to_be_are_not_believed(name, why):
    run, judge = Faulty(), FrameChecker()
    assert [judge.mistake(frame) for frame in frames(run, 3)] == [""] * 3
    run.robot.inject(name)
    run.read()
    mistakes = [judge.mistake(frame) for frame in frames(run, 4)]
    assert all(why in mistake for mistake in mistakes[1:])  # a frozen picture is good at first
    run.robot.clear()
    run.read()
    assert judge.mistake(frames(run, 1)[0]) == ""


def test_late_frames_are_at_least_03_s_old_and_count_as_old():
    run = Faulty()
    run.robot.inject("frames late")
    run.read()
    late = frames(run, 8)
    ages = [0.1 * (number + 1) - frame.stamp for number, frame in enumerate(late)]
    assert ages[-1] == pytest.approx(0.3, abs=0.02)
    assert run.robot.camera.latest(0.15) is None


def held() -> Faulty:
    """A run with the block in the hand, above the table."""
    run = Faulty()
    harness = run.harness
    harness.reach_over(looking_down(0.7, 0.0, TABLE_TOP + 0.03))
    harness.robot.grip(0.0, 20.0)
    harness.run_for(None, 1.0)
    harness.reach_over(looking_down(0.7, 0.0, TABLE_TOP + 0.2))
    assert harness.world.supports() == {"block": "hand"}
    run.now = harness.clock.now()
    return run


def test_a_held_object_that_is_pushed_falls_and_the_fingers_close():
    run = held()
    assert run.read().gripper_width > 0.03
    run.robot.inject("object moved")
    run.read(2.0)
    assert run.harness.world.supports() == {"block": "table"}
    before = run.harness.world.objects[0].pose.translation.copy()
    run.robot.clear()
    run.read()
    run.robot.inject("object moved")  # now one that lies on the table
    run.read()
    after = run.harness.world.objects[0].pose.translation
    assert np.linalg.norm(after - before) == pytest.approx(0.1, abs=0.01)
    assert run.harness.world.supports() == {"block": "table"}
    assert run.true().gripper_width == pytest.approx(0.0, abs=1e-3)


def test_an_object_that_is_taken_out_of_the_hand_comes_back_to_where_it_was_at_first():
    run = held()
    home = block().pose
    run.robot.inject("object taken")
    run.read(DT)
    assert run.harness.world.supports() == {"block": "floor"}
    run.robot.clear("object taken")
    run.read(DT)
    assert run.harness.world.objects[0].pose.isApprox(home, 1e-2)


def test_a_fault_ends_by_itself_after_its_time():
    run = Faulty()
    run.robot.inject("reflex", 0.5)
    assert run.read(0.45).faults
    assert not run.read(0.1).faults


def test_what_is_done_to_a_world_needs_one():
    robot = FaultInjection(Harness().robot)
    with pytest.raises(UserError, match="no fault is called `object moved` here"):
        robot.inject("object moved")
    with pytest.raises(UserError, match="did you mean `reflex`"):
        robot.inject("reflx")


def test_the_same_seed_does_the_same():
    def pose(seed: int) -> np.ndarray:
        run = Faulty(seed)
        run.robot.inject("localisation jump")
        return run.read().oTb.homogeneous

    assert (pose(3) == pose(3)).all()
    assert not (pose(3) == pose(4)).all()


def test_a_fault_from_another_thread_begins_and_ends_with_a_reading():
    run = Faulty()
    thread = threading.Thread(target=run.robot.inject, args=("object taken",))
    thread.start()
    thread.join()
    assert run.harness.world.supports() == {"block": "table"}
    run.read()
    assert run.harness.world.supports() == {"block": "floor"}
    run.robot.clear()
    assert run.harness.world.supports() == {"block": "floor"}
    run.read()
    assert run.harness.world.supports() == {"block": "table"}


def test_every_fault_is_a_new_effect_and_on_the_page_about_control():
    text = (Path(__file__).parents[3] / "docs" / "control.md").read_text(encoding="utf-8")
    for fault in INJECTABLE.values():
        first, second = fault.make(), fault.make()
        assert isinstance(first, Effect)
        assert first is not second
        assert f"`{fault.name}`" in text
