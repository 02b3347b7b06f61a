"""The control page in a real browser, with a real run in a process of its own."""

import time

import pytest
from browsers import MOVING, Run, chromium

LEAVES = """
task: toy
tree:
  sequence:
    - name: first
      wait: {duration_s: 1000}
    - name: second
      wait: {duration_s: 1000}
    - name: third
      wait: {duration_s: 1000}
"""


@pytest.fixture(scope="module")
def browser():
    with chromium() as browser:
        yield browser


def ticks(page) -> int:
    shown = page.locator("#ticks").inner_text()
    return int(shown) if shown.isdecimal() else 0


def settled(page) -> int:
    """The counter when it has come to rest."""
    page.wait_for_timeout(700)
    return ticks(page)


def wait_until_ticks(page, most: int) -> None:
    deadline = time.monotonic() + 30.0
    while ticks(page) <= most:
        assert time.monotonic() < deadline
        page.wait_for_timeout(100)


def opened(browser, run: Run):
    page = browser.new_page(viewport={"width": 1280, "height": 720})
    page.set_default_timeout(20_000)
    page.goto(run.url)
    return page


def node(page, name: str):
    return page.locator("svg .node").filter(has_text=name)


def test_breakpoint_keys_forced_outcome_and_the_end_are_had_by_a_click(tmp_path, browser):
    from playwright.sync_api import expect

    with Run(tmp_path, "--view", "none", "--force-outcomes", task=LEAVES) as run:
        page = opened(browser, run)
        expect(page.locator("#run")).to_have_text("running")
        expect(page.locator("svg .tip")).to_contain_text("first")
        header = page.locator("header").bounding_box()
        node(page, "second").click()
        page.click("#break")
        expect(page.locator("#unbreak")).to_have_text("Remove breakpoint")
        node(page, "first").click()
        page.click("#force-success")
        expect(page.locator("#run")).to_have_text("paused before second")
        expect(page.locator("#history")).to_contain_text("success forced by a person")
        assert "waits" in node(page, "second").get_attribute("class")
        paused_at = settled(page)
        page.keyboard.press("s")
        assert settled(page) == paused_at + 1
        page.click("#resume")
        expect(page.locator("#run")).to_have_text("running")
        wait_until_ticks(page, paused_at + 20)
        page.keyboard.press(" ")
        expect(page.locator("#run")).to_have_text("paused by a person")
        page.keyboard.press("n")
        expect(page.locator("#run")).to_have_text("running")
        assert page.locator("header").bounding_box() == header, "the header does not jump"
        node(page, "third").click()
        page.click("#force-failure")
        badge = node(page, "third").locator(".badge")
        expect(badge).to_have_text("forced: failure")
        page.click("#force-nothing")
        expect(badge).to_have_text("")
        node(page, "second").click()
        page.click("#force-failure")
        expect(page.locator("#outcome")).to_contain_text("toy failed", timeout=30_000)
        expect(page.locator("#explanation")).to_contain_text("forced by a person")
        expect(page.locator("iframe")).to_have_count(1)
        assert page.locator("#pause").is_disabled()
        assert page.locator("header").bounding_box() == header
        assert run.process.poll() is None, "the page stays"
        assert run.end() == 1
        expect(page.locator("#run")).to_have_text("the run has ended")


def test_every_motion_waits_for_a_person_and_may_be_refused(tmp_path, browser):
    from playwright.sync_api import expect

    with Run(tmp_path, "--view", "none", "--approve", task=MOVING) as run:
        page = opened(browser, run)
        expect(page.locator("#wanted")).to_contain_text("the robot wants to: ahead")
        settled(page)
        expect(page.locator("#run")).to_have_text("paused ahead waits for approval")
        for key in (" ", "s", "n"):
            page.keyboard.press(key)
        assert page.locator("#step").is_disabled()
        settled(page)
        expect(page.locator("#wanted")).to_contain_text("the robot wants to: ahead")
        page.click("#approve")
        expect(page.locator("#wanted")).to_contain_text("the robot wants to: back")
        page.click("#refuse")
        expect(page.locator("#outcome")).to_contain_text("toy failed", timeout=30_000)
        expect(page.locator("#outcome")).to_contain_text("failure chosen by a person")
        assert run.end() == 1


def test_a_fault_is_told_and_an_emergency_stop_acknowledged_on_the_page(tmp_path, browser):
    from playwright.sync_api import expect

    with Run(tmp_path, "--view", "none") as run:
        stranger = browser.new_page()
        stranger.goto(run.url.partition("#")[0])
        expect(stranger.locator("#run")).to_contain_text("no valid token")
        stranger.click("#stop")
        assert stranger.locator("#ticks").inner_text() == "–"

        page = opened(browser, run)
        wait_until_ticks(page, 20)
        header = page.locator("header").bounding_box()
        page.select_option("#fault", "reflex")
        page.click("#inject")
        expect(page.locator("#faults")).to_have_text("reflex of the arm, injected")
        assert page.locator("header").bounding_box() == header
        page.locator("[data-node='0']").press("Enter")
        expect(page.locator("#chosen-name")).not_to_be_empty()
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
        expect(page.locator("#outcome")).to_contain_text("toy was interrupted", timeout=30_000)
        assert run.end() == 130


@pytest.mark.slow
def test_the_viewer_on_the_page_shows_the_run_and_phones_nowhere(tmp_path, browser):
    from playwright.sync_api import expect

    with Run(tmp_path, "--view", "web") as run:
        page = browser.new_page(viewport={"width": 1200, "height": 800})
        page.add_init_script("console.debug = () => {}")
        reached: list[str] = []
        page.on("response", lambda reply: reached.append(reply.url))
        page.goto(run.url)
        deadline = time.monotonic() + 90.0
        while not any("ReadMessages" in url for url in reached):  # the viewer asks for the data
            assert time.monotonic() < deadline
            page.wait_for_timeout(500)
        viewer = next(frame for frame in page.frames if "/viewer/" in frame.url)
        assert viewer.evaluate("document.querySelectorAll('canvas').length") == 1
        page.click("#pause")
        expect(page.locator("#run")).to_have_text("paused by a person", timeout=30_000)
        paused_at = settled(page)
        page.click("#step")
        expect(page.locator("#ticks")).to_have_text(str(paused_at + 1), timeout=30_000)
        page.wait_for_timeout(5_000)  # time enough to phone home
        here = ("http://127.0.0.1:", "data:", "blob:")
        assert [url for url in reached if not url.startswith(here)] == []
