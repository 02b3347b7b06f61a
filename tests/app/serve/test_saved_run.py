"""A finished run, as the page shows it, has what a running one has, and no more than is true."""

import pytest

from app.core import RunOptions, run_task
from app.review import explain, explanation_page
from app.serve.saved import saved

TASK = (
    "task: round\nposes: {corner: {base: [0.3, 0.0], heading_deg: 0}}\ntree:\n  sequence:\n"
    "    - navigate: {to: corner}\n    - name: pause\n      wait: {duration_s: 0.2}\n"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("runs")
    (path / "round.yaml").write_text(TASK)
    options = RunOptions(tree=path / "round.yaml", record=path, recording=False)
    return run_task(options).folder


def test_it_has_tree_log_plan_figures_and_outcome(folder):
    told = saved(folder, "now")
    about, state = told["about"], told["state"]
    assert [title for title, *_ in about["nodes"]] == [
        "sequence",
        "navigate → corner",
        "pause → 0.2 s",
    ]
    assert about["nodes"][1][3].startswith("Move")
    assert about["where"].startswith("frankie · kinematic · household · seed 0")
    assert "<polygon" in about["plan"]
    assert 'class="robot"' in state["moving"]
    assert state["looks"] == "sss"
    assert state["spent"][2] == pytest.approx(0.2, abs=0.05)
    assert "base x [m]" in state["figures"]
    assert state["outcome"].startswith("✔ round succeeded after ")
    assert "succeeded after" not in state["explanation"]
    assert told["log"][-1].text.startswith("✔ pause → 0.2 s")
    assert told["picture"] is None


def test_a_run_without_its_motion_has_no_plan(folder, tmp_path):
    (folder / "states.npy").rename(tmp_path / "states.npy")
    try:
        about = saved(folder, "now")["about"]
    finally:
        (tmp_path / "states.npy").rename(folder / "states.npy")
    assert "plan" not in about


def test_the_explanation_of_a_task_that_moves_nothing_counts_no_objects(folder):
    text = explanation_page(explain(folder))
    assert "<main>" in text
    assert "placed" not in text
    assert "attempted" not in text
