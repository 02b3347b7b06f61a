"""Goals of Experiment 2: seeded, reachable, free of contact; files are checked before use."""

import numpy as np
import pytest

from controller import robot_model
from lab.bench.contacts import ContactChecker
from lab.bench.goals import DISC, GoalFileError, generate_goals, load_goals


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_the_same_seed_gives_the_same_goals_and_another_gives_others(robot):
    model = robot_model(robot)
    once, again, other = (
        np.array([goal.homogeneous for goal in generate_goals(model, 20, seed)])
        for seed in (3, 3, 4)
    )
    assert (once == again).all()
    assert np.abs(once - other).max() > 0.1
    longer = generate_goals(model, 25, 3)
    assert (np.array([goal.homogeneous for goal in longer[:20]]) == once).all()


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_goals_are_in_the_disc_above_the_floor_and_all_around(robot):
    places = np.array([goal.translation for goal in generate_goals(robot_model(robot), 300, 0)])
    assert (places[:, 2] >= 0.05).all()
    assert (np.linalg.norm(places, axis=1) <= DISC).all()
    bearings = np.arctan2(places[:, 1], places[:, 0])
    assert (np.histogram(bearings, 4, (-np.pi, np.pi))[0] > 40).all()


def test_postures_in_contact_do_not_count(monkeypatch):
    """Every posture is checked, and those in contact are left out."""
    model = robot_model("frankie")
    asked = []
    plain = ContactChecker.__call__

    def ask(self, q):
        asked.append(plain(self, q).any)
        return plain(self, q)

    monkeypatch.setattr(ContactChecker, "__call__", ask)
    assert len(generate_goals(model, 100, 0)) == 100
    assert any(asked)
    assert asked.count(False) == 100


def save(path, **arrays):
    np.savez(path, **arrays)
    return path


def test_a_file_of_goals_is_read_back(tmp_path):
    goals = generate_goals(robot_model("frankie"), 5, 0)
    T = np.array([goal.homogeneous for goal in goals])
    for dtype in (np.float64, np.float32):
        read = load_goals(save(tmp_path / "goals.npz", T=T.astype(dtype), other=np.ones(3)))
        for goal, expected in zip(read, goals, strict=True):
            assert np.abs(goal.homogeneous - expected.homogeneous).max() < 1e-6
            assert goal.rotation @ goal.rotation.T == pytest.approx(np.eye(3), abs=1e-12)


EYE = np.eye(4)[None]


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"poses": EYE}, "no array T"),
        ({"T": np.eye(4)}, "(N, 4, 4)"),
        ({"T": np.zeros((0, 4, 4))}, "(N, 4, 4)"),
        ({"T": np.full((1, 4, 4), np.nan)}, "T[0]"),
        ({"T": np.concatenate([EYE, 2.0 * EYE])}, "T[1] is not a pose"),
        ({"T": EYE * [1, 1, -1, 1]}, "T[0] is not a pose"),
        ({"T": EYE.astype(str)}, "numbers"),
        ({"T": EYE.astype(object)}, "not a readable"),
    ],
)
def test_a_bad_file_is_refused_with_its_name_and_what_is_wrong(tmp_path, arrays, message):
    path = save(tmp_path / "goals.npz", **arrays)
    with pytest.raises(GoalFileError) as refused:
        load_goals(path)
    assert message in str(refused.value)
    assert str(path) in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_file_that_is_not_an_archive_is_refused(tmp_path):
    with pytest.raises(GoalFileError, match="no such file"):
        load_goals(tmp_path / "none.npz")
    (tmp_path / "text.npz").write_text("hello")
    with pytest.raises(GoalFileError, match="not a readable"):
        load_goals(tmp_path / "text.npz")
    np.save(tmp_path / "bare.npy", EYE)
    with pytest.raises(GoalFileError, match="bare array"):
        load_goals(tmp_path / "bare.npy")
