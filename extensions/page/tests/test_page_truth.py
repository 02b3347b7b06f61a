"""What the control page says in a real browser when its data stop coming, or its run does."""

import os
import re
import signal
import time

import pytest
from browsers import LIVE, MOVING, Run, chromium, enabled, expect_run, opened_page, sentence

pytestmark = [pytest.mark.realtime, pytest.mark.slow]

TWO = """
task: toy
tree:
  sequence:
    - name: first
      wait: {duration_s: 1000}
    - name: second
      wait: {duration_s: 1000}
"""
UNCONFIRMED = r"Stop sent, not confirmed yet \([1-5] s\)"
LOST = r"connection lost {} s ago, the robot may be moving; press the emergency stop"
FROZEN = r"frozen for {} s: no answer, the robot may be moving; press the emergency stop"


@pytest.fixture(scope="module")
def browser():
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    with Run(tmp_path_factory.mktemp("run"), "--view", "none", "--approve", task=TWO) as run:
        yield run


def test_a_gap_is_told_with_its_age_and_leaves_nothing_behind(browser, run):
    page = opened_page(browser, run.url)
    expect_run(page, "running")
    assert enabled(page) == LIVE
    assert re.fullmatch(r"\d\.\d s old", page.inner_text("#age"))
    for seconds in (1.5, 4.0):
        page.context.set_offline(True)
        page.wait_for_timeout(1000 * seconds)
        expect_run(page, re.compile(LOST.format(r"\d+")))
        told = re.fullmatch(LOST.format(r"(\d+)"), sentence(page))
        assert abs(int(told[1]) - seconds) <= 2.0  # the machine may be busy
        assert enabled(page) == {"stop", "pause"}
        page.context.set_offline(False)
        expect_run(page, "running")
        assert enabled(page) == LIVE
    page.close()


def test_the_keyboard_is_enough_and_the_one_global_key_stops(browser, tmp_path):
    from playwright.sync_api import expect

    with Run(tmp_path, "--view", "none", task=TWO) as run:
        page = opened_page(browser, run.url)
        expect_run(page, "running")
        for key in (" ", "s", "n", "Enter"):
            page.keyboard.press(key)
        page.wait_for_timeout(400)
        assert sentence(page) == "running"
        page.focus("#pause")
        page.keyboard.press(" ")
        expect_run(page, "paused: by a person")
        ticks = page.inner_text("#ticks")
        page.focus("#step")
        page.keyboard.press("Enter")
        expect(page.locator("#ticks")).to_have_text(str(int(ticks) + 1))
        page.keyboard.press("Shift+Tab")
        assert page.evaluate("document.activeElement.id") == "resume"
        page.keyboard.press("Enter")
        expect_run(page, "running")
        page.focus("[data-node='0']")
        for key in ("ArrowDown", "ArrowDown", " "):
            page.keyboard.press(key)
        expect(page.locator("#chosen-name")).to_have_text(re.compile("second"))
        page.focus("#search")
        page.keyboard.press("Escape")
        expect(page.locator("#outcome")).to_contain_text("toy was interrupted", timeout=30_000)
        page.close()


def test_a_process_that_was_killed_is_a_lost_connection_for_ever(browser, run):
    page = opened_page(browser, run.url)
    expect_run(page, "running")
    run.process.kill()
    run.process.wait()
    expect_run(page, re.compile(LOST.format(r"[1-9]\d*")))
    assert enabled(page) == {"stop", "pause"}
    page.click("#stop")
    page.wait_for_timeout(2300)
    assert re.fullmatch(UNCONFIRMED, page.inner_text("#notice"))
    assert re.fullmatch(LOST.format(r"\d+"), sentence(page))
    assert "stop" in enabled(page)
    page.close()


def test_approval_works_after_a_gap_and_stop_at_a_frozen_process_when_it_thaws(tmp_path, browser):
    from playwright.sync_api import expect

    with Run(tmp_path, "--view", "none", "--approve", task=MOVING) as run:
        page = opened_page(browser, run.url)
        expect(page.locator("#wanted")).to_contain_text("the robot wants to: ahead")
        asked = {"approve", "refuse", "stop"}
        assert enabled(page) == asked
        page.context.set_offline(True)
        page.wait_for_timeout(1500)
        expect_run(page, re.compile(LOST.format("[1-4]")))
        assert enabled(page) == {"stop", "pause"}
        page.context.set_offline(False)
        expect_run(page, "paused: ahead waits for approval")
        assert enabled(page) == asked
        page.click("#approve")
        expect(page.locator("#wanted")).to_contain_text("the robot wants to: back")

        begun = time.monotonic()
        os.kill(run.process.pid, signal.SIGSTOP)
        try:
            page.wait_for_timeout(1800)
            expect_run(page, re.compile(FROZEN.format("[1-4]")))
            assert enabled(page) == {"stop", "pause"}
            page.click("#stop")
            page.wait_for_timeout(2300)
            assert re.fullmatch(UNCONFIRMED, page.inner_text("#notice"))
            page.wait_for_timeout(max(0.0, 6000 - 1000 * (time.monotonic() - begun)))
            expect_run(page, re.compile(FROZEN.format("[5-8]")))
        finally:
            os.kill(run.process.pid, signal.SIGCONT)
        expect(page.locator("#outcome")).to_contain_text("toy was interrupted", timeout=30_000)
        expect_run(page, re.compile("the run has ended: ■ toy was interrupted after"))
        assert enabled(page) == set()
        expect(page.locator("#notice")).to_be_hidden()
        run.process.kill()
        run.process.wait()
        page.wait_for_timeout(1500)
        assert sentence(page).startswith("the run has ended: ■ toy")  # it has said so itself
        page.close()
