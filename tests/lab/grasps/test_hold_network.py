"""Outcomes of grasps, the fit of the hold network to them, and its evaluation."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from command_line import call

from config.reader import ConfigError
from lab.grasps import grasp_outcomes
from lab.grasps.grasp_outcomes import Outcomes, read_outcomes
from lab.grasps.hold_network import auc, calibration_error
from lab.grasps.hold_training import FitSettings, fit_hold
from lab.grasps.torch_networks import save_network
from perception import NUMBERS, GraspPatches
from perception.grasps.patches import FAR_SHAPE, NEAR_SHAPE
from perception.networks.hold import load_hold
from robots import load_robot

GRIPPER = load_robot("frankie").gripper


def collect(folder: Path, scenes: int) -> None:
    code, _, err = call("grasp", "outcomes", folder, "--scenes", scenes, "--workers", 1)
    assert code == 0, err


def test_a_collection_is_the_same_again_and_goes_on_where_it_was(tmp_path, monkeypatch):
    pytest.importorskip("mujoco", reason="needs the extra `physics`")
    monkeypatch.setattr(grasp_outcomes, "SCENES", 1)
    monkeypatch.setattr(grasp_outcomes, "_GRASPS", 2)
    # A bin that shows grasps from both views.
    shown = grasp_outcomes.SETS["trained"]._replace(first=200_002)
    monkeypatch.setitem(grasp_outcomes.SETS, "trained", shown)
    once, interrupted = tmp_path / "once", tmp_path / "interrupted"
    collect(once, 2)
    collect(interrupted, 1)
    first = next(interrupted.iterdir())
    written = first.stat().st_mtime_ns
    collect(interrupted, 2)
    assert first.stat().st_mtime_ns == written
    one, other = (read_outcomes(folder, "trained") for folder in (once, interrupted))
    assert list(one.objects) == [1, 1, 6, 6, 6, 6]
    for field in ("good", "scene", "mass"):
        assert np.array_equal(getattr(one, field), getattr(other, field))
    for f in fields(GraspPatches):
        assert np.array_equal(getattr(one.patches, f.name), getattr(other.patches, f.name))


def drawn(count: int) -> Outcomes:
    """Grasps on a plain that hold unless something stands high at one of their far ends."""
    rng = np.random.default_rng(1)
    far = np.zeros((count, *FAR_SHAPE), dtype=np.float16)
    blocked = rng.random(count) < 0.4
    for number in np.flatnonzero(blocked):
        column = int(rng.choice((2, 27)))
        far[number, 10:22, column : column + 3] = 0.08
    near = np.zeros((count, *NEAR_SHAPE), dtype=np.float16)
    seen = {"near_unknown": near.astype(np.bool_), "far_unknown": np.zeros(far.shape, np.bool_)}
    numbers = rng.uniform(0.02, 0.05, (count, len(NUMBERS))).astype(np.float32)
    return Outcomes(
        patches=GraspPatches(near=near, far=far, numbers=numbers, **seen),
        good=~blocked,
        scene=np.arange(count),
        objects=np.ones(count, dtype=np.int64),
        mass=rng.uniform(0.1, 0.8, count),
    )


def test_the_fit_finds_what_the_check_does_not_see(tmp_path: Path) -> None:
    learnt = drawn(500)

    settings = FitSettings(rounds=4, batch=32)
    network = fit_hold(learnt.patches, learnt.good, GRIPPER, settings, lambda _: None)
    save_network(network, tmp_path / "hold.safetensors", {})
    hold = load_hold(tmp_path / "hold.safetensors", GRIPPER)
    good = learnt.good.astype(float)
    assert auc(hold(learnt.patches), good) > 0.95


def test_what_is_fitted_can_be_judged_and_used(tmp_path: Path) -> None:
    for kinds in ("trained", "tilted", "heldout", "heldout_tilted"):
        grasp_outcomes._write(grasp_outcomes._file(tmp_path, kinds, 0), drawn(60))
    out = tmp_path / "hold.safetensors"
    assert call("grasp", "fit", tmp_path, "--out", out, "--rounds", 1)[0] == 0
    code, told, _ = call("grasp", "probability", tmp_path, "--weights", out)
    assert code == 0
    assert "60 grasps in 60 scenes" in told
    tilted = tmp_path / "tilted.safetensors"
    assert call("grasp", "fit", tmp_path, "--start", out, "--out", tilted, "--rounds", 1)[0] == 0
    assert call("grasp", "probability", tmp_path, "--weights", tilted, "--tilted")[0] == 0
    assert out.read_bytes() != tilted.read_bytes()
    assert load_hold(out, GRIPPER)(drawn(3).patches).shape == (3,)


def test_auc_and_calibration_error_of_known_cases() -> None:
    good = np.array([0.0, 1.0] * 50)
    assert auc(good, good) == 1.0
    assert auc(1.0 - good, good) == 0.0
    assert auc(np.ones(100), good) == 0.5
    assert calibration_error(np.full(100, 0.5), good) == pytest.approx(0.0)
    assert calibration_error(np.full(100, 0.9), good) == pytest.approx(0.4)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04"])
def test_a_damaged_file_gets_one_clear_line(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "heldout-0.npz"
    file.write_bytes(content)
    with pytest.raises(ConfigError, match=f"{file.name}: not a file of `grasp outcomes`"):
        read_outcomes(tmp_path, "heldout")
    with pytest.raises(ConfigError, match="no outcomes of `trained`"):
        read_outcomes(tmp_path, "trained")
