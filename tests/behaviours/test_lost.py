"""A robot that is not where it takes itself to be says so, and one that is does not."""

from dataclasses import replace

import numpy as np
import pytest
from pinocchio import SE3, utils

from app.core import Instruments, RegistrationForm, RunOptions, run_task
from app.core.outcome import End
from app.review import explain
from hw import RobotWrapper

WAITS = "task: waits\ntree:\n  sequence:\n    - wait: {duration_s: 3.2}\n    - arm_healthy\n"
LOST = "should be in sight, and nothing is where the map has it"


class Displaced(RobotWrapper):
    """The base's own localisation is wrong from a time on [s]."""

    def __init__(self, robot, by: SE3, since: float) -> None:
        super().__init__(robot)
        self._by, self._since, self._told = by, since, (None, None)

    def read(self):
        state = self._robot.read()
        here = state.localised
        if here is None or here.stamp < self._since:
            return state
        if self._told[0] is not here:
            self._told = here, replace(here, mTb=self._by * here.mTb, source="/amcl_pose")
        return replace(state, localised=self._told[1])


def run(folder, by: SE3 | None = None, since: float = 0.0, tree: str = WAITS, **options):
    task = folder / "waits.yaml"
    task.write_text(tree)

    class Wrong(Instruments):
        def opened(self, backend):
            if by is None:
                return backend
            return replace(backend, robot=Displaced(backend.robot, by, since))

    options = {"scene": "household", "registration": RegistrationForm.LASER} | options
    quiet = {"recording": False, "record": folder / "runs"}
    return run_task(RunOptions(tree=task, **quiet, **options), instruments=Wrong())


def shift(metres: float, degrees: float, turn: float = 0.0) -> SE3:
    angle = np.radians(degrees)
    by = metres * np.array([np.cos(angle), np.sin(angle), 0.0])
    return SE3(utils.rotate("z", np.radians(turn)), by)


@pytest.mark.parametrize("by", [shift(0.8, 0.0), shift(0.8, 135.0), shift(0.0, 0.0, 40.0)])
def test_a_start_pose_that_is_wrong_is_a_fault_within_three_seconds(tmp_path, by):
    result = run(tmp_path, by)
    assert result.outcome.end is End.FAILURE
    assert LOST in result.outcome.reason
    assert any("pedestal" in text and LOST in text for text in result.summary.warnings)
    assert LOST in str(explain(result.folder))


def test_no_way_ends_well_where_nothing_is_where_the_map_has_it(tmp_path):
    there = "poses: {there: {base: [0.4, 0.0], heading_deg: 0}}"
    tree = f"task: way\n{there}\ntree: {{drive: {{to: there}}}}\n"
    result = run(tmp_path, shift(0.8, 90.0), tree=tree)
    assert result.outcome.end is End.FAILURE
    assert LOST in result.outcome.reason


@pytest.mark.parametrize("scene", ["household", "kitchen", "corridor", "crossing", "shelf"])
def test_a_robot_that_is_where_it_takes_itself_to_be_is_not_lost(tmp_path, scene):
    result = run(tmp_path, scene=scene, localisation="poor", seed=1)
    assert (result.outcome.end, result.summary.warnings) == (End.SUCCESS, [])


def test_a_localisation_that_laser_and_map_contradict_is_told_with_its_topic(tmp_path):
    result = run(tmp_path, shift(0.8, 30.0), since=0.5, tree=WAITS.replace("3.2", "4.0"))
    assert result.outcome.end is End.SUCCESS  # as laser and map agree about where it is
    [told] = result.summary.warnings
    assert told == "/amcl_pose has the base where laser and camera do not see it"


def test_a_tree_can_ask_whether_the_robot_is_localised(tmp_path):
    asks = WAITS.replace("arm_healthy", "localised: {within_m: 0.1}")
    good, wrong = run(tmp_path, tree=asks), run(tmp_path, shift(0.8, 0.0), tree=asks)
    exact = run(tmp_path, tree=asks, localisation="exact")
    assert [one.outcome.end for one in (good, exact)] == [End.SUCCESS] * 2
    assert (wrong.outcome.end, LOST in wrong.outcome.reason) == (End.FAILURE, True)


def test_what_the_base_tells_is_no_evidence_of_where_it_is(tmp_path):
    asks, blind = WAITS.replace("arm_healthy", "localised"), RegistrationForm.NONE
    result = run(tmp_path, shift(0.8, 0.0), tree=asks, registration=blind)
    assert result.outcome.end is End.FAILURE
    assert result.outcome.reason == "not known: nothing in sight was found on the map yet"


BENCHES = """
container: {centre: [-2.5, 0.0]}
table: {centre: [-2.5, 2.6], size: [1.2, 0.6], height: 0.5}
objects: {count: 0}
side_tables:
  - {name: one bench, centre: [1.3, 0.0], size: [0.5, 0.6], height: 0.5, objects: {count: 1}}
  - {name: other bench, centre: [1.3, 1.1], size: [0.5, 0.6], height: 0.5, objects: {count: 1}}
"""


@pytest.mark.parametrize("metres", [0.0, 1.1])
def test_a_base_before_the_other_of_two_equal_benches_does_not_know_where_it_is(tmp_path, metres):
    scene = tmp_path / "benches.yaml"
    scene.write_text(BENCHES)
    asks = WAITS.replace("arm_healthy", "localised")
    result = run(tmp_path, shift(metres, 90.0), tree=asks, scene=str(scene))
    if not metres:
        assert (result.outcome.end, result.summary.warnings) == (End.SUCCESS, [])
        return
    elsewhere = "it may as well be 1.1 m away: what is in sight is the same there"
    assert result.outcome.end is End.FAILURE
    assert result.outcome.reason == f"not known: {elsewhere}"
    assert elsewhere in result.summary.warnings
