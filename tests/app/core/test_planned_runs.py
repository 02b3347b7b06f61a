"""Whole runs with planned motion, and what is said where motions cannot be planned."""

from importlib import import_module

import pytest
from command_line import call

from app.core import MotionForm, RunOptions, replay_run, run_task
from app.live import View, ViewOptions
from controller import PlanningError
from controller.planning import rrt
from trees import find as tree


def options(tmp_path, **changed) -> RunOptions:
    return RunOptions(
        tree=tree("pick_one"),
        motion=MotionForm.PLANNING,
        record=tmp_path,
        view=ViewOptions(view=View.NONE),
        recording=False,
        **changed,
    )


def test_without_its_extra_one_line_says_what_to_install(monkeypatch, tmp_path):
    def found(name: str):
        if name.startswith("ompl"):
            raise ModuleNotFoundError(f"No module named {name!r}", name="ompl")
        return import_module(name)

    monkeypatch.setattr(rrt, "import_module", found)
    with pytest.raises(PlanningError, match=r'pip install "frankie-task\[planning\]"'):
        run_task(options(tmp_path))


def test_plans_are_not_made_in_real_time():
    code, _, err = call("run", "pick_one", "--motion", "planning", "--speed", "real")
    assert code == 2
    assert "--speed max" in err


@pytest.mark.slow
def test_the_same_tree_runs_with_planned_motion_and_the_same_seed_is_the_same_run(tmp_path):
    pytest.importorskip("ompl", reason="the extra `planning` is not installed")
    result = run_task(options(tmp_path, seed=1, replayable=True))
    assert result.outcome.end.value == "success"
    assert (result.summary.placed, result.summary.contacts) == (1, 0)
    assert result.summary.limit_violations == 0
    assert replay_run(result.folder).identical
