"""Grasps from the side and from afar: the views are what they are called, and are judged."""

import numpy as np
import pytest
from typer.testing import CliRunner

from app.commands import app
from lab.grasps import NetworkChoice, measure_views, views

pytest.importorskip("mujoco", reason="needs the extra `physics`")


@pytest.mark.parametrize("tilt_deg", views.TILTS_DEG)
def test_the_camera_looks_at_the_object_at_its_tilt_from_its_distance(tilt_deg: float) -> None:
    target = np.array([0.1, -0.2, 0.5])
    wTc = views.looking_at(target, np.radians(tilt_deg), 0.7, np.random.default_rng(3))
    seen = wTc.actInv(target)
    assert seen == pytest.approx([0.0, 0.0, 0.7], abs=1e-9)
    assert np.degrees(np.arccos(-wTc.rotation[2, 2])) == pytest.approx(tilt_deg, abs=1e-6)


def test_every_view_of_a_scene_is_judged_and_the_same_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(views, "TILTS_DEG", (0.0, 40.0))
    monkeypatch.setattr(views, "DISTANCES", (0.45,))
    seen = measure_views(NetworkChoice(network="none"), scenes=2, workers=1)
    assert [(one.tilt_deg, one.distance) for one in seen] == [(0.0, 0.45), (40.0, 0.45)] * 2
    assert {one.end for one in seen} <= set(views.ENDS)
    assert "held" in {one.end for one in seen}
    assert seen == measure_views(NetworkChoice(network="none"), scenes=2, workers=1)


def test_the_command_prints_each_view() -> None:
    told = CliRunner().invoke(app, ["grasp", "views", "--scenes", "1", "--network", "none"])
    assert told.exit_code == 0, told.output
    assert all(f"{distance:g} m" in told.output for distance in views.DISTANCES)
    assert "worst view, " in told.output
