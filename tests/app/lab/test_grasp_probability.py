"""The probability that a grasp holds: its outcomes, its fit and its figures."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from app.commands import app
from app.lab.grasps.outcomes import read_outcomes
from app.lab.grasps.probability import auc, calibration_error
from app.lab.logistic import fit_logistic

RUN = CliRunner()


def collect(file: Path, scenes: int, kinds: str = "trained") -> None:
    arguments = ["grasp", "outcomes", str(file), "--scenes", str(scenes), "--grasps", "2"]
    told = RUN.invoke(app, [*arguments, "--kinds", kinds])
    assert told.exit_code == 0, told.output


def test_a_collection_is_the_same_again_and_goes_on_where_it_was(tmp_path: Path) -> None:
    pytest.importorskip("mujoco", reason="needs the extra `physics`")
    once, interrupted = tmp_path / "once.jsonl", tmp_path / "interrupted.jsonl"
    collect(once, 2)
    collect(interrupted, 1)
    collect(interrupted, 2)
    assert once.read_bytes() == interrupted.read_bytes()
    alone, many = read_outcomes(once)
    assert (alone.count, many.count) == (1, 6)
    assert alone.outcomes
    assert many.outcomes


def test_the_fit_recovers_a_known_model_and_is_calibrated() -> None:
    rng = np.random.default_rng(0)
    features = rng.normal((3.0, -1.0), (2.0, 0.1), (20_000, 2))
    true = 1.0 / (1.0 + np.exp(-(2.0 - 0.8 * features[:, 0] + 5.0 * (features[:, 1] + 1.0))))
    good = (rng.random(len(true)) < true).astype(float)
    model = fit_logistic(features, good)
    assert model.weights[:2] / model.spread == pytest.approx((-0.8, 5.0), rel=0.1)
    assert np.abs(model(features) - true).max() < 0.03
    assert calibration_error(model(features), good) < 0.02


def test_auc_and_calibration_error_of_known_cases() -> None:
    good = np.array([0.0, 1.0] * 50)
    assert auc(good, good) == 1.0
    assert auc(1.0 - good, good) == 0.0
    assert auc(np.ones(100), good) == 0.5
    assert calibration_error(np.full(100, 0.5), good) == pytest.approx(0.0)
    assert calibration_error(np.full(100, 0.9), good) == pytest.approx(0.4)


@pytest.mark.parametrize("line", ["{", "[]", '{"seed": 1}', '{"outcomes": [{"features": [1]}]}'])
def test_a_damaged_file_gets_one_clear_line(tmp_path: Path, line: str) -> None:
    file = tmp_path / "damaged.jsonl"
    file.write_text(line + "\n", encoding="utf-8")
    told = RUN.invoke(app, ["grasp", "probability", str(file), str(file)])
    assert told.exit_code != 0
    assert f"{file}:1: not a scene" in str(told.exception) + told.output
