"""The control page in a real browser, with a real run in a process of its own."""

import os
import re
import subprocess
import sys
import time
from pathlib import Path
from shutil import which

import pytest

FOLDER = Path(__file__).parents[3]
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@pytest.fixture
def browser():
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    program = next((found for name in BROWSERS if (found := which(name))), None)
    if program is None:
        pytest.skip("no Chromium on this machine; on Debian: apt install chromium")
    with playwright.sync_playwright() as play:
        browser = play.chromium.launch(
            executable_path=program,
            args=[
                "--no-sandbox",
                "--use-gl=angle",
                "--use-angle=gl-egl",
                "--ignore-gpu-blocklist",
            ],
        )
        yield browser
        browser.close()


class Run:
    """`frankie-task run` with the page, until the end of the `with` statement."""

    def __init__(self, folder: Path, *options: str) -> None:
        task = folder / "toy.yaml"
        task.write_text(
            "task: toy\ntree:\n  sequence:\n"
            "    - wait: {duration_s: 1000}\n    - name: the end\n      wait: {duration_s: 1}\n"
        )
        command = [
            sys.executable,
            "-m",
            "frankie_task_cli",
            "run",
            task,
            "--record",
            folder,
            "--control",
        ]
        self.process = subprocess.Popen(
            [*map(str, command), "--speed", "real", *options],
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONPATH": str(FOLDER)},
        )
        output = ""
        while not (found := re.search(r"control at (http://127\.0\.0\.1:\d+/#\S+)", output)):
            line = self.process.stderr.readline()
            assert line, f"the run ended: {output}"
            output += line
        self.url = found[1]

    def __enter__(self) -> "Run":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()  # not killed: it has a viewer to end as well
        self.process.communicate(timeout=30.0)


def ticks(page) -> int:
    return int(page.locator("#ticks").inner_text())


def settled(page) -> int:
    """The counter when it has come to rest."""
    page.wait_for_timeout(700)
    return ticks(page)


def wait_until_ticks(page, most: int) -> None:
    deadline = time.monotonic() + 30.0
    while ticks(page) <= most:
        assert time.monotonic() < deadline
        page.wait_for_timeout(100)


def test_pause_step_resume_and_stop_are_seen_on_the_page(tmp_path, browser):
    from playwright.sync_api import expect

    with Run(tmp_path, "--view", "none") as run:
        stranger = browser.new_page()
        stranger.goto(run.url.partition("#")[0])
        expect(stranger.locator("#run")).to_contain_text("no valid token")
        stranger.click("#stop")
        assert stranger.locator("#ticks").inner_text() == "–"

        page = browser.new_page()
        page.goto(run.url)
        expect(page.locator("#run")).to_have_text("running")
        wait_until_ticks(page, 20)
        page.click("#pause")
        expect(page.locator("#run")).to_have_text("paused by a person")
        paused_at = settled(page)
        assert settled(page) == paused_at
        page.click("#step")
        page.click("#step")
        assert settled(page) == paused_at + 2
        page.click("#resume")
        wait_until_ticks(page, paused_at + 50)
        page.select_option("#fault", "reflex")
        page.click("#inject")
        expect(page.locator("#faults")).to_have_text("reflex of the arm, injected")
        page.click("#clear")
        expect(page.locator("#faults")).to_be_hidden()
        page.click("#stop")
        assert run.process.wait(timeout=20.0) == 130
        expect(page.locator("#run")).to_have_text("the run has ended")


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
