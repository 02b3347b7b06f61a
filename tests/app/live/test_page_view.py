"""What the control page makes of one state, in a real browser; a test ticks the run by hand."""

import re

import pytest
from browsers import FOLDER, LIVE, chromium, enabled, expect_run, opened_page, sentence
from sample_run import TREE, snapshot

from app.live.operator import Control, ControlPage, Ending, PageServer

STATIC = FOLDER / "app" / "live" / "operator"


@pytest.fixture(scope="module")
def browser():
    with chromium() as browser:
        yield browser


class Served:
    """The page of a run that a test ticks by hand."""

    def __init__(self, server: PageServer) -> None:
        self.server, self.control = server, Control()
        self.page = ControlPage(
            self.control, TREE, inject=print, clear=print, seconds=server.seconds
        )
        server.serve(self.page)


def test_a_loop_that_stands_still_is_frozen_though_the_page_answers(browser):
    with PageServer() as server:
        served = Served(server)
        page = opened_page(browser, server.url)
        expect_run(page, "starting")
        for tick in range(3):
            served.page.show(snapshot(tick))
            page.wait_for_timeout(200)
        expect_run(page, "running")
        assert enabled(page) == LIVE
        page.wait_for_timeout(2300)
        assert re.fullmatch(
            r"frozen for [1-5] s: its control loop stands still, the robot may be moving; "
            "press the emergency stop",
            sentence(page),
        ), sentence(page)
        assert enabled(page) == {"stop", "pause"}
        page.click("#stop")
        page.wait_for_timeout(400)
        assert served.control.stopped
        served.page.show(snapshot(3))
        expect_run(page, "stopping")
        served.page.finish()
        page.wait_for_timeout(1500)
        assert sentence(page) == "the robot is at rest; the run is being written down"
        served.page.end(Ending(outcome="toy was interrupted", explanation="", recording=None))
        expect_run(page, "the run has ended")
        page.close()


def test_what_was_asked_for_long_ago_is_refused_unless_it_stops(browser):
    now = [0.0]
    with PageServer(seconds=lambda: now[0]) as server:
        served = Served(server)
        served.control.pause()
        served.page.show(snapshot(0))
        page = opened_page(browser, server.url)
        expect_run(page, "paused by a person")
        page.evaluate("poll = () => {}")
        page.wait_for_timeout(500)
        now[0] = 6.0
        page.evaluate("press('resume')")
        page.wait_for_timeout(500)
        assert served.control.state.paused
        assert page.inner_text("#notice") == "Resume came too late: look, and press it again"
        page.evaluate("press('stop')")
        page.wait_for_timeout(500)
        assert served.control.stopped
        page.close()


def test_buttons_derive_from_one_function_and_from_nothing_else():
    scripts = {path.name: path.read_text() for path in STATIC.glob("*.js")}
    for word in (".disabled", ".hidden", 'setAttribute("disabled"', 'setAttribute("hidden"'):
        uses = [name for name, text in scripts.items() for _ in range(text.count(word))]
        assert uses in ([], ["page.js"]), word
    assert "element(" not in scripts["view.js"]
    assert "document" not in scripts["view.js"]
