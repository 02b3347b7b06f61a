"""The control page in a real browser, with a real run in a process of its own.

One session is quick; what the page says when its data stop coming, or its run does, is slow.
"""

import re
import socket
import time
from urllib.parse import urlsplit

import pytest
from browsers import LIVE, Run, chromium, enabled, expect_run, opened_page
from sample_run import TREE, moment

from app.live import Control
from extensions.page.control_page import ControlPage
from extensions.page.server import PageServer

expect = pytest.importorskip("playwright.sync_api", reason="playwright is not installed").expect
pytestmark = pytest.mark.realtime


@pytest.fixture(scope="module")
def browser():
    with chromium() as browser:
        yield browser


def settled(page) -> int:
    """The counter when it has come to rest."""
    before, now = "", page.inner_text("#ticks")
    while before != now:
        page.wait_for_timeout(700)
        before, now = now, page.inner_text("#ticks")
    return int(now)


def wait_for(page, condition: str) -> None:
    """As `wait_for_function`, which the page's policy forbids."""
    deadline = time.monotonic() + 90.0
    while not page.evaluate(condition):
        assert time.monotonic() < deadline, condition
        page.wait_for_timeout(200)


def wait_until_ticks(page, most: int) -> None:
    wait_for(page, f"parseInt(document.querySelector('#ticks').textContent) > {most}")


def node(page, name: str):
    return page.locator(".row").filter(has_text=name)


def test_a_person_sets_breakpoints_steps_forces_outcomes_and_reads_how_it_ended(tmp_path, browser):
    with Run(tmp_path, "--view", "none", "--approve") as run:
        page = opened_page(browser, run.url)
        expect_run(page, "running")
        assert enabled(page) == LIVE
        header = page.locator("header").bounding_box()
        node(page, "the end").click()
        page.click("#break")
        expect(page.locator("#unbreak")).to_be_visible()
        node(page, "wait").first.click()
        page.click("#force-success")
        expect_run(page, "paused: before the end")
        assert "waits" in node(page, "the end").get_attribute("class")
        paused_at = settled(page)
        page.click("#step")
        expect(page.locator("#ticks")).to_have_text(str(paused_at + 1))
        page.click("#resume")
        wait_until_ticks(page, paused_at + 5)
        page.click("#pause")
        expect_run(page, "paused: by a person")
        assert page.locator("header").bounding_box() == header, "the header does not jump"
        node(page, "the end").click()
        page.click("#force-failure")
        expect(node(page, "the end").locator(".badge")).to_contain_text("forced: failure")
        page.click("#resume")
        expect(page.locator("#outcome")).to_contain_text("toy failed", timeout=60_000)
        expect(page.locator("#explanation")).to_contain_text("forced by a person")
        assert page.locator("#pause").is_disabled()
        assert run.process.poll() is None, "the page stays"
        assert run.end() == 1
        expect_run(page, re.compile("the run has ended: ✗ toy failed after"))
        with socket.create_server(("127.0.0.1", urlsplit(run.url).port)):
            pass  # its port is free again


@pytest.mark.slow
def test_a_fault_is_told_and_an_emergency_stop_acknowledged_on_the_page(tmp_path, browser):
    with Run(tmp_path, "--view", "none", "--world", "faulty") as run:
        stranger = browser.new_page()
        stranger.goto(run.url.partition("#")[0])
        expect(stranger.locator("#run")).to_contain_text("no valid token")
        stranger.click("#stop")
        assert stranger.locator("#ticks").inner_text() == "–"

        page = opened_page(browser, run.url)
        wait_until_ticks(page, 20)
        page.click("#tests summary")
        page.select_option("#fault", "reflex")
        page.click("#inject")
        expect(page.locator("#faults")).to_have_text("reflex of the arm, injected")
        page.click("#clear")
        expect(page.locator("#faults")).to_be_hidden()
        page.select_option("#fault", "emergency stop")
        page.click("#inject")
        expect(page.locator("#acknowledge")).to_be_disabled()
        page.click("#clear")
        expect(page.locator("#acknowledge")).to_be_enabled()
        page.click("#acknowledge")
        expect(page.locator("#acknowledge")).to_be_hidden()
        paused_at = settled(page)
        page.click("#resume")
        wait_until_ticks(page, paused_at)
        page.click("#stop")
        expect(page.locator("#outcome")).to_contain_text("toy was interrupted", timeout=60_000)
        assert run.end() == 130


@pytest.mark.slow
def test_the_viewer_on_the_page_shows_the_moments_of_the_log_and_phones_nowhere(tmp_path, browser):
    """In few pixels, as the processor draws them; few frames pass while it does, and a click would
    wait for two in which its button stands still."""

    def press(selector: str) -> None:
        button = page.locator(selector).last
        expect(button).to_be_visible()
        button.dispatch_event("click")

    with Run(tmp_path, "--view", "web") as run:
        few = {"viewport": {"width": 1000, "height": 500}, "device_scale_factor": 0.2}
        page = browser.new_page(**few)
        page.set_default_timeout(90_000)
        page.add_init_script("console.debug = () => {}")
        reached: list[str] = []
        page.on("response", lambda reply: reached.append(reply.url))
        page.goto(run.url)
        with page.expect_response(re.compile("ReadMessages")):  # the viewer asks for the data
            press("#tab-viewer")
        viewer = next(frame for frame in page.frames if "/viewer/" in frame.url)
        assert viewer.evaluate("document.querySelectorAll('canvas').length") == 1
        expect(page.locator("#behind")).to_contain_text("s behind the run", timeout=90_000)
        press("#tab-robot")
        press("#log button")  # when the run began
        wait_for(page, "shownAt !== null && shownAt < 0.5")
        press("#jump")
        wait_for(page, "shownAt > 3")
        page.wait_for_timeout(5_000)  # time enough to phone home
        here = ("http://127.0.0.1:", "http://localhost:", "data:", "blob:")
        assert [url for url in reached if not url.startswith(here)] == []


@pytest.mark.slow
def test_a_loop_that_stands_still_is_frozen_though_the_page_answers(browser):
    with PageServer() as server:
        control = Control()
        served = ControlPage(control, TREE, seconds=server.seconds)
        server.serve(served)
        page = opened_page(browser, server.url)
        expect_run(page, "starting")
        served.show(moment(0))
        loop = r"frozen for \d+ s: its control loop stands still, the robot may be moving; .*"
        expect_run(page, re.compile(loop))
        assert enabled(page) == {"stop", "pause"}
        page.click("#stop")
        served.show(moment(3))
        expect_run(page, "stopping")
        assert control.stopped
        served.finish()
        expect_run(page, "the robot is at rest; the run is being written down")
        served.end("toy was interrupted", "")
        expect_run(page, "the run has ended: toy was interrupted")
