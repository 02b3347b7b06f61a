"""A headless Chromium, and runs in processes of their own, for tests of pages."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import which

import pytest

FOLDER = Path(__file__).parents[3]
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
WAITING = (
    "task: toy\nscene: single\ntree:\n  sequence:\n"
    "    - wait: {duration_s: 1000}\n    - name: the end\n      wait: {duration_s: 1}\n"
)

LIVE = {"pause", "step", "next", "stop"}
"""What can be pressed on the page of a run that goes on."""
MOVING = """
task: toy
tree:
  sequence:
    - name: ahead
      drive: {forward_m: 0.2}
    - name: back
      drive: {forward_m: -0.2}
"""


@contextmanager
def chromium(proxy: str = "") -> Iterator:
    """A browser; all that it asks of other machines goes through a proxy, if there is one."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    program = next((found for name in BROWSERS if (found := which(name))), None)
    if program is None:
        pytest.skip("no Chromium on this machine; on Debian: apt install chromium")
    with playwright.sync_playwright() as play:
        browser = play.chromium.launch(
            executable_path=program,
            args=[
                *("--no-sandbox", "--use-gl=angle", "--use-angle=gl-egl", "--ignore-gpu-blocklist"),
                *("--disable-background-networking", "--disable-component-update"),
                *([f"--proxy-server={proxy}"] if proxy else []),
            ],
        )
        yield browser
        browser.close()


class Run:
    """`frankie-task run` with the page, until the end of the `with` statement."""

    def __init__(self, folder: Path, *options: str, task: str = WAITING) -> None:
        path = folder / "toy.yaml"
        path.write_text(task)
        command = [sys.executable, "-m", "frankie_task_cli", "run", path, "--record", folder]
        self.process = subprocess.Popen(
            [*map(str, command), "--with", "page", "--speed", "real", *options],
            stdout=subprocess.DEVNULL,
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

    def end(self) -> int:
        """Ctrl-C; returns the exit code."""
        self.process.terminate()  # not killed: it has a viewer to end as well
        self.process.communicate(timeout=60.0)
        return self.process.returncode

    def __enter__(self) -> "Run":
        return self

    def __exit__(self, *_: object) -> None:
        if self.process.poll() is None:
            self.end()


def opened_page(browser, url: str, **size):
    """The control page, once it shows the tree."""
    page = browser.new_page(viewport={"width": 1280, "height": 720, **size})
    page.set_default_timeout(60_000)
    page.goto(url)
    page.wait_for_selector(".row", state="attached")
    return page


def enabled(page) -> set[str]:
    """The buttons, shown ones only, that can be pressed."""
    return set(
        page.eval_on_selector_all(
            "header button:not([role=tab]), #chosen button",
            "all => all.filter(one => !one.disabled && one.offsetParent).map(one => one.id)",
        )
    )


def sentence(page) -> str:
    """What the page says of the run."""
    return page.inner_text("#run")


def expect_run(page, words: str | re.Pattern[str]) -> None:
    """Wait until the page says these words of the run."""
    from playwright.sync_api import expect

    expect(page.locator("#run")).to_have_text(words, timeout=60_000)
