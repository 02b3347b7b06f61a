"""Text from files and robots on the screen: it is shown, and does nothing to the terminal."""

import io
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from command_line import call
from rich.live import Live
from rich.table import Table
from rich.text import Text

from app.terminal import Terminal, until_interrupted, visible

ROOT = Path(__file__).parents[2]
HOSTILE = {
    "clear the screen": "\x1b[2J",
    "set the title": "\x1b]0;owned\x07",
    "overwrite the line": "all is well\r",
    "right to left": "\u202egnp.exe",
    "no width": "a\u200bb",
    "half a pair": "\ud800",
}


def printed(thing: object) -> str:
    file = io.StringIO()
    Terminal(file=file, width=200).print(thing)
    return file.getvalue()


def table(text: str) -> Table:
    made = Table(text, title=text)
    made.add_row(text)
    return made


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_only_text_reaches_the_terminal(text):
    for renderable in (text, Text(text), table(text)):
        written = printed(renderable)
        assert all(letter.isprintable() or letter in "\n\t" for letter in written)
        written.encode("utf-8")
    assert visible(f"{text}\n") == visible(text) + "\n"
    assert visible(visible(text)) == visible(text)


def test_good_text_and_markup_are_taken_literally():
    text = "✔ 1° [red]no markup[/] :smile: é 漢字 →"
    assert printed(text) == f"{text}\n"
    assert "[/bold]" in printed(table("[/bold]"))


def test_a_display_that_stays_in_place_still_moves_the_cursor():
    file = io.StringIO()
    terminal = Terminal(file=file, force_terminal=True, width=60)
    with Live(console=terminal, auto_refresh=False, transient=True) as live:
        live.update(Text("one\x1b[2J"), refresh=True)
        live.update(Text("two"), refresh=True)
    assert "\x1b[2K" in file.getvalue()  # its own
    assert "\x1b[2J" not in file.getvalue()
    assert r"one\x1b[2J" in file.getvalue()


TASK = """\
task: toy
description: "\\e[2J"
tree: {sequence: [{say: {text: "good \\e]0;owned\\a \\r [/red]"}}, {wait: {duration_s: 0.01}}]}
"""
NAMED = 'task: toy\ntree: {name: "a\\e[2J", wait: {duration_s: 1}}\n'


def test_a_task_says_things_to_people_and_not_to_their_terminal(tmp_path):
    task, named, runs = tmp_path / "toy.yaml", tmp_path / "named.yaml", tmp_path / "runs"
    task.write_text(TASK)
    named.write_text(NAMED)
    options = ("--scene", "single", "--view", "none", "--record", runs)
    for code, *arguments in (
        (0, "run", task, *options),
        (0, "dry", task),
        (0, "draw", task),
        (0, "explain", "--runs", runs),
        (0, "runs", runs),
        (2, "check", named),
        (2, "run", named, *options),
        (2, "check", tmp_path / "no\x1b[2Jsuch.yaml"),
        *((2, "run", task, option, "no\x1b[2Jsuch") for option in ("--scene", "--robot")),
    ):
        ended, *texts = call(*arguments)
        assert ended == code, (arguments, texts)
        for text in texts:
            assert all(letter.isprintable() or letter in "\n\t" for letter in text), arguments


FIRST_WRITE = """
import os, sys
class First:
    encoding, errors = "utf-8", "strict"
    def write(self, text):
        os.write(1, text.encode())
        os._exit(int("app.core" in sys.modules))
    def flush(self): ...
    def isatty(self): return False
    def fileno(self): return 2
sys.stderr, sys.argv = First(), ["frankie-task", "run", "pick_one"]
from app.commands import main
main()
"""


def test_a_run_into_a_pipe_says_something_before_it_loads_what_takes_seconds():
    command = [sys.executable, "-c", FIRST_WRITE]
    said = subprocess.check_output(command, cwd=ROOT, text=True, timeout=300)
    assert said.strip() == "frankie-task: loading"


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_ends_the_waiting_whichever_thread_receives_the_signal():
    def interrupt() -> None:
        waiting.wait(60.0)
        signal.pthread_kill(threading.get_ident(), signal.SIGINT)

    waiting = threading.Event()
    thread = threading.Thread(target=interrupt)
    thread.start()
    with until_interrupted():
        waiting.set()
    thread.join()
    reached = False
    with until_interrupted():
        signal.raise_signal(signal.SIGINT)  # before the waiting
        reached = True
    assert not reached
