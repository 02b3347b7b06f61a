"""Goals of Experiment 2: seeded, reachable, free of contact."""

import numpy as np
import pytest

from controller import robot_model
from lab.bench.contacts import ContactChecker
from lab.bench.goals import DISC, generate_goals


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_goals_are_seeded_in_the_disc_above_the_floor_and_all_around(robot):
    model = robot_model(robot)
    once, longer, other = (
        np.array([goal.homogeneous for goal in generate_goals(model, count, seed)])
        for count, seed in ((20, 3), (300, 3), (20, 4))
    )
    assert (longer[:20] == once).all()
    assert np.abs(once - other).max() > 0.1
    places = longer[:, :3, 3]
    assert (places[:, 2] >= 0.05).all()
    assert (np.linalg.norm(places, axis=1) <= DISC).all()
    bearings = np.arctan2(places[:, 1], places[:, 0])
    assert (np.histogram(bearings, 4, (-np.pi, np.pi))[0] > 40).all()


def test_postures_in_contact_are_rejected(monkeypatch):
    asked = []
    plain = ContactChecker.__call__

    def ask(self, *posture):
        asked.append(plain(self, *posture))
        return asked[-1]

    monkeypatch.setattr(ContactChecker, "__call__", ask)
    assert len(generate_goals(robot_model("frankie"), 100, 0)) == 100
    assert any(asked)
    assert asked.count(False) == 100
