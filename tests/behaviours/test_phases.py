"""Which part of its work a behaviour says that it is in."""

from itertools import groupby

import numpy as np
from harness import ON_TABLE, REFLEX, TABLE_TOP, Harness, block, looking_down, table_world
from py_trees.common import Status

from behaviours import Leaf, Posture
from behaviours.grasp import Grasp
from behaviours.place import Place
from behaviours.recover import Recover
from behaviours.retreat_check import RetreatCheck
from behaviours.wait import Wait
from controller import PoseGoal
from robots import load_robot


def phases(harness: Harness, leaf: Leaf) -> list[str]:
    """The phases that a leaf goes through until it ends, each once."""
    seen = []
    for _ in range(3000):
        harness.tick(leaf)
        if leaf.status is not Status.RUNNING:
            break
        seen.append(leaf.phase)
    return [phase for phase, _ in groupby(seen)]


def test_the_phases_of_grasping_and_placing():
    harness = Harness(table_world(block()))
    harness.reach(PoseGoal(wTe=looking_down(0.7, 0.05, TABLE_TOP + 0.3)))
    grasp = Grasp("grasp", harness.context, within=ON_TABLE)
    assert phases(harness, grasp) == ["approach", "lock", "descend", "close"]
    assert harness.run(RetreatCheck("retreat_check", harness.context)) is Status.SUCCESS
    place = Place("place", harness.context, on=ON_TABLE, pitch_m=0.13)
    assert phases(harness, place) == ["approach", "lower", "release", "rise"]


def test_the_phases_of_recovering():
    harness = Harness(table_world())
    harness.robot.faults = (REFLEX,)
    folded = Posture(name="folded", q=load_robot("frankie").arm.ready + np.full(7, 0.2))
    recover = Recover("recover", harness.context, arm=folded)
    assert phases(harness, recover) == ["clear", "rise", "fold"]


def test_a_behaviour_with_one_part_has_no_phase():
    wait = Wait("wait", Harness(table_world()).context, duration_s=0.1)
    assert wait.phase == ""
