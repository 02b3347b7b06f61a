"""The page of `serve` in a real Chromium, on a desk and on a phone."""

import os
import re
import signal
from contextlib import contextmanager
from pathlib import Path

import pytest
from browsers import WAITING, chromium, expect_run
from served import Served

from app.core import RunOptions, run_task

expect = pytest.importorskip("playwright.sync_api", reason="playwright is not installed").expect
pytestmark = pytest.mark.slow

SCREENS = {"desk": (1440, 900), "phone": (390, 844)}
HOP = (
    "task: hop\nscene: single\nparams:\n  reserve_percent: {default: 20.0, max: 90}\n"
    "  times: {default: 1, min: 1, max: 9}\ntree:\n  retry: $times\n  sequence:\n"
    "    - say: {text: hop}\n    - name: rest\n      wait: {duration_s: 0.3}\n"
    "      timeout_s: $reserve_percent\n"
)


@pytest.fixture(scope="module")
def browser():
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    """A folder with two tasks, and a run of one of them in the past."""
    folder: Path = tmp_path_factory.mktemp("tasks")
    (folder / "toy.yaml").write_text(WAITING)
    (folder / "hop.yaml").write_text(HOP)
    run_task(RunOptions(tree=folder / "hop.yaml", scene="single", record=folder / "runs"))
    with Served(folder) as served:
        yield served


@pytest.fixture(params=SCREENS.values(), ids=SCREENS)
def page(request, browser, served):
    width, height = request.param
    context = browser.new_context(viewport={"width": width, "height": height}, bypass_csp=True)
    page = context.new_page()
    errors = []
    page.on("pageerror", lambda error: errors.append(error))
    page.goto(served.url)
    page.wait_for_selector("[data-task='toy.yaml']", state="attached")
    yield page
    assert errors == []
    context.close()


def assert_accessible(page) -> None:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    found = axe.run(page).response["violations"]
    assert [(one["id"], [n["html"] for n in one["nodes"]][:3]) for one in found] == []


def choose(page, task: str) -> None:
    if page.is_visible("#tab-tasks"):
        page.click("#tab-tasks")
    page.click(f"[data-task='{task}']")
    page.wait_for_function(f"document.activeElement.textContent === '{task}'")


def in_sight(page, selector: str) -> bool:
    """Whether all of an element can be seen and clicked."""
    return page.eval_on_selector(
        selector,
        "one => { const { left, top, right, bottom } = one.getBoundingClientRect();"
        " return [[left, top], [right, top], [left, bottom], [right, bottom]].every(([x, y]) =>"
        "  document.elementFromPoint(x + 3 * Math.sign(left + right - 2 * x),"
        "   y + 3 * Math.sign(top + bottom - 2 * y)) === one); }",
    )


@contextmanager
def running(page, served):
    """The task `toy` runs, started on the page."""
    choose(page, "toy.yaml")
    page.click("[name=start]")
    expect_run(page, "running")
    try:
        yield
    finally:
        served.wait_for("over", press="/stop")


def runs(served) -> list[str]:
    return [one["task"] for one in served.ask("GET", "/runs")]


def test_forms_name_the_field_and_start_is_in_sight(page, served):
    before = runs(served)
    assert_accessible(page)
    choose(page, "hop.yaml")
    assert page.evaluate("document.activeElement.textContent") == "hop.yaml"
    assert in_sight(page, "[name=start]")
    label = page.locator("label", has_text="reserve_percent")
    box, beside = label.bounding_box(), page.locator("[name=reserve_percent]").bounding_box()
    assert box["x"] + box["width"] <= beside["x"]
    assert label.evaluate("one => one.scrollWidth <= one.clientWidth + 1")
    for name in ("reserve_percent", "times", "robot", "scene", "seed"):
        page.fill(f"[name={name}]", "")
    page.click("[name=check]")
    expect(page.locator(".mistakes")).to_have_text("good: no mistakes", timeout=30_000)
    wrong = {"reserve_percent": "95", "times": "0", "robot": "frnkie", "scene": "kitchn"}
    for name, value in (wrong | {"seed": "-1"}).items():
        page.fill(f"[name={name}]", value)
    page.click("[name=start]")
    told = page.locator(".field:has([aria-invalid=true]) .error")
    expect(told).to_have_count(5, timeout=30_000)
    assert all(told.all_inner_texts())
    assert page.evaluate("document.activeElement.name") == "reserve_percent"
    assert in_sight(page, "[name=start]")
    assert_accessible(page)
    page.fill("[name=seed]", "1")
    assert told.count() == 4
    assert runs(served) == before


@pytest.mark.realtime
def test_what_is_on_the_screen_is_what_is_started_and_an_ended_run_has_no_running_node(
    page, served
):
    with running(page, served):
        assert page.evaluate("document.activeElement.id") == "tab-robot"
        assert_accessible(page)
        choose(page, "hop.yaml")
        assert page.inner_text("#task") == "Tasks"
        expect_run(page, "toy: running")
        expect(page.locator("[name=start]")).to_be_disabled()
        expect(page.locator("#busy")).to_have_text(
            "toy runs: stop it before you start another task"
        )
        assert in_sight(page, "#stop")
        page.keyboard.press("Escape")
        expect_run(page, re.compile("the last run: ■ toy was interrupted after"))
    expect(page.locator("#again")).to_be_hidden()
    assert "toy" not in page.title().partition(" · ")[2]
    page.click("#tab-robot")
    expect(page.locator("#again")).to_have_text("Start toy again")
    expect_run(page, re.compile("the run has ended: ■ toy was interrupted after"))
    assert page.locator(".row.running, .row.tip").count() == 0
    assert page.locator(".row.stopped").count() == 2
    assert "running" not in page.locator("#tree").aria_snapshot()
    choose(page, "hop.yaml")
    expect(page.locator("[name=start]")).to_be_enabled()
    assert in_sight(page, "[name=start]")
    before = runs(served)
    page.dblclick("[name=start]")
    expect_run(page, re.compile("the run has ended: ✔ hop succeeded"))
    assert runs(served) == ["hop", *before]


def test_a_past_run_shows_what_a_running_one_shows(page, served):
    (past,) = [one for one in served.ask("GET", "/runs") if one["task"] == "hop"][-1:]
    here = served.url.partition("/#")[0]
    page.goto(f"{here}/?run={past['name']}")
    page.wait_for_selector(".row", state="attached")
    expect(page.locator("#run")).to_have_text(re.compile("the run has ended: ✔ hop succeeded"))
    assert page.locator("body").inner_text().count("succeeded after") == 2  # header and outcome
    for part in ("#plan .robot", "#plan .furniture", "#plan .track"):
        expect(page.locator(part).first).to_be_attached()
    assert page.locator("#pictured").inner_text()
    assert "rest → 0.3 s" in page.locator("#tree").text_content()
    assert_accessible(page)
    page.click("#tab-viewer")
    page.evaluate("shownAt = 0.1; draw()")
    expect(page.locator("#jump")).to_be_hidden()
    assert "before the end" in page.inner_text("#behind")
    page.click("#back")
    expect(page.locator("#task")).to_have_text("Tasks")
    expect(page.locator("[data-task='hop.yaml']")).to_be_visible()
    page.goto(f"{here}/?run=no-such-run")
    expect(page.locator("#notice")).to_contain_text("no such run")
    page.goto(here + past["explanation"])
    assert_accessible(page)
    assert page.locator("main").count() == 1
    assert "objects placed" not in page.inner_text("main")


@pytest.mark.realtime
def test_keys_reach_tabs_and_tree_a_search_finds_nothing_and_a_crash_ends_the_run(page, served):
    def selected() -> str:
        (tab,) = page.locator("[role=tab][aria-selected=true]").all()
        assert page.locator("[role=tab][tabindex='0']").all() == [tab] or tab.is_visible()
        assert page.evaluate("document.activeElement.id") == tab.get_attribute("id")
        return tab.inner_text()

    with running(page, served):
        narrow = page.is_visible("#tab-tree")
        tabs = ["Robot", "Tree", "Log", "Tasks"] if narrow else ["Robot", "Tasks"]
        assert selected() == "Robot"
        for one in (*tabs[1:], tabs[0]):
            page.keyboard.press("ArrowRight")
            assert selected() == one
        page.keyboard.press("End")
        assert selected() == "Tasks"
        page.keyboard.press("Home")
        assert selected() == "Robot"
        if narrow:
            page.click("#tab-tree")
            assert_accessible(page)
        page.fill("#search", "no such node")
        expect(page.locator("#unfound")).to_contain_text("no such node")
        assert_accessible(page)
        page.fill("#search", "the end")
        expect(page.locator("#unfound")).to_be_hidden()
        page.focus("#unfold")
        page.keyboard.press("Tab")
        at = "document.activeElement.querySelector('.name').textContent"
        assert page.evaluate(at) == "sequence"
        for key, name in (("Down", "the end"), ("Right", "the end"), ("Left", "sequence")):
            page.keyboard.press(f"Arrow{key}")
            assert page.evaluate(at).startswith(name)
        page.fill("#search", "")
        for key in ("Tab", "Tab", "Tab", "End", "Enter"):
            page.keyboard.press(key)
        expect(page.locator(".row.chosen")).to_contain_text("the end")
        page.focus("#break")
        page.keyboard.press("Enter")
        expect(page.locator("#unbreak")).to_be_focused()
        os.kill(served.run, signal.SIGKILL)
        expect_run(page, "the run has ended: the process of the run ended by SIGKILL")
        assert page.locator(".row.running").count() == 0
        assert page.locator(".row.stopped").count() == 2
