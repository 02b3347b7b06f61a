"""`frankie-task serve`: tasks and their mistakes; runs that crash, freeze, or are over."""

import json
import os
import signal
from pathlib import Path

import pytest
from browsers import WAITING, chromium, expect_run, opened_page
from served import Served
from waiting import until

from app.choices import View
from app.core import RunOptions, run_task
from extensions.page.catalogue import catalogue, mistakes
from extensions.page.desk import TaskDesk
from extensions.page.saved import saved

BAD = "task: bad\nparams: {n: {default: 3, max: 9}}\ntree:\n  open_griper:\n"
DRIVE = (
    "task: toy\nscene: single\nparams: {far: {default: 2.0, description: how far}}\ntree:\n"
    "  drive: {forward_m: $far}\n"
)


def test_the_catalogue_has_forms_and_mistakes_their_lines(tmp_path):
    (tmp_path / "bad.yaml").write_text(BAD)
    (tmp_path / "places.yaml").write_text("poses: {}\n")
    tasks = {one["name"]: one for one in catalogue(tmp_path)["tasks"]}
    assert tasks["bad.yaml"]["bad"]
    assert not tasks["pick_place"]["bad"]
    assert "places.yaml" not in tasks
    (field,) = tasks["pick_place"]["parameters"]
    assert (field["name"], field["default"], field["step"]) == ("attempts", "5", "1")
    (found,) = mistakes(tmp_path / "bad.yaml", "frankie", {})
    assert "bad.yaml:4:3: " in found["text"]
    assert found["source"] == "   4    open_griper:\n        ^"
    (tmp_path / "bad.yaml").write_text(BAD.replace("open_griper:", "wait: {duration_s: $n}"))
    assert mistakes(tmp_path / "bad.yaml", "frankie", {}) == []
    (found,) = mistakes(tmp_path / "bad.yaml", "frankie", {"n": "12"})
    assert "at most 9" in found["text"]
    assert "no robot" in mistakes(tmp_path / "bad.yaml", "frankei", {})[0]["text"]


def test_each_wrong_field_is_told_at_itself_and_an_emptied_one_means_its_default(tmp_path):
    task = "task: t\nparams: {n: {default: 3}, share: {default: 5.0, max: 9}}\ntree:\n  {}\n"
    (tmp_path / "t.yaml").write_text(
        task.replace("{}", "retry: $n\n  timeout_s: $share\n  open_gripper:")
    )
    desk = TaskDesk(tmp_path, armed=False, view=View.NONE, say=print)

    def told(**order: object) -> dict[str, str]:
        answer = desk.post("/check", json.dumps({"task": "t.yaml", **order}).encode())
        return {one["field"]: one["text"] for one in answer["mistakes"]}

    emptied = {"robot": "", "scene": "", "seed": "", "parameters": {"n": "", "share": ""}}
    assert told(**emptied) == {}
    wrong = told(robot="frnkie", scene="kitchn", parameters={"n": "0", "share": "12"})
    assert [*wrong] == ["robot", "scene", "parameters.n", "parameters.share"]
    assert "`frankie`" in wrong["robot"]
    assert "`kitchen`" in wrong["scene"]
    assert "at least 1" in wrong["parameters.n"]
    assert "at most 9" in wrong["parameters.share"]
    assert [*told(seed=-1, speed="warp")] == ["seed", "speed"]
    for body in (b"", b"{", b"[]", b"[" * 60_000, b"\xff"):
        assert "refused" in desk.post("/check", body)


@pytest.mark.realtime
@pytest.mark.slow
def test_a_crash_ends_no_server_stop_always_works_and_nothing_outlives_the_server(tmp_path):
    (tmp_path / "toy.yaml").write_text(WAITING)
    with Served(tmp_path) as served:
        assert served.ask("GET", "/state")["phase"] == "idle"
        assert served.ask("POST", "/start", task="toy.yaml", seed=-1)["refused"]
        assert served.ask("POST", "/start", task="../toy.yaml")["refused"]
        assert served.ask("POST", "/start", task="toy.yaml")["started"]
        served.wait_for("running")
        assert "toy runs" in served.ask("POST", "/start", task="toy.yaml")["refused"]
        os.kill(served.run, signal.SIGKILL)
        assert "ended by SIGKILL" in served.wait_for("over")["outcome"]

        assert served.ask("POST", "/again/1")["started"]
        served.wait_for("running")
        os.kill(served.run, signal.SIGSTOP)
        served.wait_for("over", press="/stop")
        assert "another task was started since" in served.ask("POST", "/again/1")["refused"]

        run = served.ask("GET", "/runs")[-1]
        assert served.answer("GET", run["recording"], "", token="")[1].startswith(b"RRF2")
        assert served.answer("GET", run["explanation"], "", token="")[0] == 403

        assert served.ask("POST", "/again/2")["started"]
        served.wait_for("running")
        run = served.run
        served.process.kill()
        process = Path(f"/proc/{run}/cmdline")
        until(lambda: not process.exists() or not process.read_text())
    (summary,) = tmp_path.glob("runs/*/summary.json")
    assert json.loads(summary.read_text())["outcome"] == "interrupted"


@pytest.mark.realtime
@pytest.mark.slow
def test_two_people_start_a_task_edit_it_and_start_it_again(tmp_path):
    expect = pytest.importorskip("playwright.sync_api").expect
    (tmp_path / "toy.yaml").write_text(DRIVE.replace("drive:", "drvie:"))
    with chromium() as browser, Served(tmp_path) as served:
        page = browser.new_page()
        page.goto(served.url)
        page.click("[data-task='toy.yaml']")
        expect(page.locator(".mistakes")).to_contain_text("toy.yaml:5:3")
        expect(page.locator(".mistakes code")).to_contain_text("5    drvie: {forward_m: $far}")
        (tmp_path / "toy.yaml").write_text(DRIVE)
        page.click("[data-task='toy.yaml']")
        page.fill("[name=far]", "0.2")
        page.click("[name=start]")
        expect(page.locator("#outcome")).to_contain_text("toy succeeded", timeout=60_000)
        page.reload()
        expect(page.locator("#outcome")).to_contain_text("toy succeeded")
        (tmp_path / "toy.yaml").write_text(WAITING)
        page.click("#tab-tasks")
        expect(page.locator("#runs li")).to_contain_text("toy success after")
        here = served.url.partition("/#")[0]
        page.goto(here + page.get_attribute("#runs a >> nth=1", "href"))
        page.click("#log li span")
        expect(page.locator(".row.chosen")).to_contain_text("drive")
        page.goto(here)
        page.click("#tab-tasks")
        page.click("[data-task='toy.yaml']")
        page.click("[name=start]")
        expect_run(page, "running")
        other = opened_page(browser, served.url)
        expect_run(other, "running")
        expect(page.locator("#people")).to_have_text("2 people watch")
        other.keyboard.press("Escape")
        for one in (page, other):
            expect(one.locator("#outcome")).to_contain_text("was interrupted", timeout=60_000)
        page.click("#again")
        expect_run(page, "running")
        expect_run(other, "running")
        other.click("#stop")
        expect(page.locator("#outcome")).to_contain_text("was interrupted", timeout=60_000)


ROUND = (
    "task: round\nposes: {corner: {base: [0.3, 0.0], heading_deg: 0}}\ntree:\n  sequence:\n"
    "    - navigate: {to: corner}\n    - name: pause\n      wait: {duration_s: 0.2}\n"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("runs")
    (path / "round.yaml").write_text(ROUND)
    options = RunOptions(tree=path / "round.yaml", record=path, recording=False)
    return run_task(options).folder


def test_it_has_tree_log_plan_figures_and_outcome(folder):
    told = saved(folder, "now")
    about, state = told["about"], told["state"]
    titles = [title for title, *_ in about["nodes"]]
    assert titles == ["sequence", "navigate → corner", "pause → 0.2 s"]
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
