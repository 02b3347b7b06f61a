"""A run tells that its base follows its commands later than its file says."""

from dataclasses import replace

import numpy as np
import pytest

from app.core import Instruments, RunOptions, run_task
from app.core.base_lag import BaseLag

DRIVES = "task: t\nscene: household\ntree:\n  drive: {forward_m: 0.3}\n"


@pytest.mark.parametrize(
    ("told", "words"), [(0.03, "0.10 s late, and the robot's file says 0.03"), (0.10, "")]
)
def test_a_lag_that_is_far_off_is_told_in_the_summary(tmp_path, told, words):
    class Late(Instruments):
        def opened(self, backend):
            described = backend.robot.description
            base = replace(described.base, lag=told)
            backend.robot.description = replace(described, base=base)
            return backend

    (tmp_path / "t.yaml").write_text(DRIVES)
    options = RunOptions(tree=tmp_path / "t.yaml", record=tmp_path / "runs", recording=False)
    warnings = run_task(options, instruments=Late()).summary.warnings
    assert bool(words) == bool(warnings), warnings
    assert words in " ".join(warnings)


@pytest.mark.parametrize(
    ("late", "dead", "told", "words"),
    [
        (0.1, 0.0, 0.03, "0.10 s late"),
        (0.15, 0.1, 0.25, ""),
        (0.06, 0.0, 0.05, ""),
        (0.0, 0.0, 0.03, ""),
    ],
)
def test_noise_old_readings_and_a_base_that_is_held_make_no_lag(late, dead, told, words):
    """Without a lag (0.0) the base does not move at all."""
    rng, lag, twist, sent = np.random.default_rng(0), BaseLag(told), np.zeros(3), [np.zeros(3)] * 30
    for tick in range(2000):
        now = 0.01 * tick
        age = rng.uniform(0.0, 0.04)
        command = np.array([0.4, 0.0, 0.2]) * float(np.clip(np.sin(now) * 3.0, -0.5, 1.0))
        share = 1.0 - np.exp(-0.01 / late) if late else 0.0
        sent.append(command)
        past = twist
        twist = twist + share * (sent[-2 - round(100 * dead)] - twist)
        seen = twist + (past - twist) * age / 0.01
        lag.note(now - age, seen + rng.normal(0.0, 0.01, 3), now, command)
    assert bool(words) == bool(lag.told), lag.told
    assert words in lag.told
