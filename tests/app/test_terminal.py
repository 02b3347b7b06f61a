"""Text from files and robots on the screen: it is shown, and does nothing to the terminal."""

import io
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import call
from rich.live import Live
from rich.table import Table
from rich.text import Text

from app.terminal import Terminal, visible

ROOT = Path(__file__).parents[2]
HOSTILE = {
    "clear the screen": "\x1b[2J",
    "set the title": "\x1b]0;owned\x07",
    "overwrite the line": "all is well\r",
    "right to left": "\u202egnp.exe",
    "no width": "a\u200bb",
    "half a pair": "\ud800",
}


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_only_text_reaches_the_terminal(text):
    for renderable in (text, Text(text), _table(text)):
        written = _printed(lambda terminal, it=renderable: terminal.print(it))
        assert all(letter.isprintable() or letter in "\n\t" for letter in written)
        written.encode("utf-8")
    assert visible(f"{text}\n") == visible(text) + "\n"
    assert visible(visible(text)) == visible(text)


def test_good_text_and_markup_are_taken_literally():
    text = "✔ 1° [red]no markup[/] :smile: é 漢字 →"
    assert _printed(lambda terminal: terminal.say(text)) == f"{text}\n"
    assert "[/bold]" in _printed(lambda terminal: terminal.print(_table("[/bold]")))


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
tree:
  sequence:
    - say: {text: "good \\e]0;owned\\a \\r [/red]"}
    - wait: {duration_s: 0.01}
"""


def test_a_task_says_things_to_people_and_not_to_their_terminal(tmp_path):
    task = tmp_path / "toy.yaml"
    task.write_text(TASK)
    runs = tmp_path / "runs"
    hostile_name = 'task: toy\ntree: {name: "a\\e[2J", wait: {duration_s: 1}}\n'
    (tmp_path / "named.yaml").write_text(hostile_name)
    options = ("--scene", "single", "--view", "none", "--record", str(runs))
    for code, arguments in (
        (0, ("run", str(task), *options)),
        (0, ("dry", str(task))),
        (0, ("draw", str(task))),
        (0, ("explain", "--runs", str(runs))),
        (0, ("runs", str(runs))),
        (2, ("check", str(tmp_path / "named.yaml"))),
        (2, ("run", str(tmp_path / "named.yaml"), *options)),
        (2, ("check", str(tmp_path / "no\x1b[2Jsuch.yaml"))),
        (2, ("run", str(task), "--scene", "no\x1b[2Jsuch")),
        (2, ("run", str(task), "--robot", "no\x1b[2Jsuch")),
        (2, ("run", str(task), "--weights", "no\x1b[2Jsuch")),
    ):
        ended, *texts = call(*arguments)
        assert ended == code, (arguments, texts)
        for text in texts:
            assert all(letter.isprintable() or letter in "\n\t" for letter in text), arguments


def _printed(what) -> str:
    file = io.StringIO()
    what(Terminal(file=file, width=200))
    return file.getvalue()


def _table(text: str) -> Table:
    table = Table(title=text)
    table.add_column(text)
    table.add_row(text)
    return table


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
    ran = subprocess.run(
        [sys.executable, "-c", FIRST_WRITE], cwd=ROOT, capture_output=True, text=True, timeout=300
    )
    assert ran.stdout.strip() == "frankie-task: loading"
    assert ran.returncode == 0
