"""How late a robot followed its commands, from the files of a run."""

from __future__ import annotations

import numpy as np
import pytest
from command_line import call

from app.review import DamagedRunError
from lab.calibration import delays


def leave(folder, dead: float, lag: float, scale: float = 1.0) -> None:
    """Files of a run whose base turns and whose joint 6 moves late, at ticks that are not even."""
    rng = np.random.default_rng(0)
    fine = np.arange(0.0, 40.0, 0.001)
    wish = scale * np.repeat(rng.uniform(-0.5, 0.5, 50), 800)
    late = np.concatenate([np.zeros(round(dead / 0.001)), wish])[: len(wish)]
    followed = np.empty_like(late)
    v, share = 0.0, 1.0 - np.exp(-0.001 / lag)
    for k, one in enumerate(late):
        v += share * (one - v)
        followed[k] = v
    stamps = np.cumsum(rng.uniform(0.009, 0.012, 3500))
    commands, states = np.zeros((len(stamps), 11)), np.zeros((len(stamps), 22))
    commands[:, 0] = states[:, 0] = stamps
    at = np.minimum((stamps / 0.001).astype(int), len(fine) - 1)
    for column, measured in ((3, 6), (9, 19)):
        commands[:, column] = wish[at]
        states[:, measured] = followed[at]
    np.save(folder / "commands.npy", commands)
    np.save(folder / "states.npy", states)


def test_dead_time_and_lag_are_found_of_what_moved(tmp_path):
    leave(tmp_path, 0.1, 0.15)
    turning, joint = delays(tmp_path)
    assert (turning.axis, joint.axis) == ("base, turning", "joint 6")
    for one in (turning, joint):
        assert one.total == pytest.approx(0.25, abs=0.02)
        assert one.dead == pytest.approx(0.1, abs=0.03)
        assert one.error < 0.1


def test_the_command_tells_what_to_write_into_the_robot_file(tmp_path):
    leave(tmp_path, 0.02, 0.03)
    for name in ("options.json", "summary.json", "task.yaml", "events.jsonl"):
        (tmp_path / name).write_text("{}")
    assert "arm_lag: 0.05" in call("calibrate", "delays", tmp_path)[1]


def test_a_run_in_which_nothing_moved_is_refused_in_a_line(tmp_path):
    leave(tmp_path, 0.1, 0.1, scale=0.0)
    with pytest.raises(DamagedRunError, match="nothing moved"):
        delays(tmp_path)
    (tmp_path / "states.npy").write_bytes(b"")
    with pytest.raises(DamagedRunError, match="cannot be read"):
        delays(tmp_path)
