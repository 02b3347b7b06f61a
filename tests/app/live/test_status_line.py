import io
from dataclasses import replace

import sample_run as samples
from rich.console import Console

from app.live.status_line import StatusLine


class Seconds:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def shown(terminal: bool, ticks: int, step: float) -> str:
    """What is written when each tick takes `step` real seconds."""
    out, seconds = io.StringIO(), Seconds()
    console = Console(file=out, force_terminal=terminal, width=100, color_system=None)
    with StatusLine(samples.TREE, seconds=seconds, console=console) as line:
        for tick in range(ticks):
            seconds.now += step
            line.update(samples.snapshot(tick), placed=3, attempts=4)
    return out.getvalue()


def test_a_terminal_shows_branch_reason_and_figures() -> None:
    text = shown(terminal=True, ticks=60, step=0.1)
    assert "… / pick / pick once / navigate to above_con…: 2.4" in text
    assert "placed 3  attempts 4  tick 2." in text
    assert "(0.2x)" in text


def test_a_terminal_is_not_written_to_oftener_than_five_times_a_second() -> None:
    text = shown(terminal=True, ticks=100, step=0.01)
    assert 3 <= text.count("placed 3") <= 7


def test_a_file_gets_a_plain_line_now_and_then() -> None:
    text = shown(terminal=False, ticks=60, step=0.5)
    lines = text.splitlines()
    assert len(lines) == 3
    assert "\x1b" not in text
    assert lines[0].startswith("0.4 s (0.0x)  placed 3")
    assert "recover: 2.81 m to go" in lines[0]


def test_a_short_run_in_a_file_says_nothing() -> None:
    assert shown(terminal=False, ticks=5, step=0.5) == ""


def test_markup_in_a_message_is_only_text() -> None:
    out, seconds = io.StringIO(), Seconds()
    console = Console(file=out, force_terminal=True, width=100, color_system=None)
    snapshot = samples.snapshot(0)
    nodes = tuple(node._replace(message="[red]a\nb[/nope]") for node in snapshot.nodes)
    with StatusLine(samples.TREE, seconds=seconds, console=console) as line:
        line.update(replace(snapshot, nodes=nodes), placed=0, attempts=0)
    assert "[red]a b[/nope]" in out.getvalue()


def test_it_goes_to_standard_error(capsys: object) -> None:
    console = StatusLine(samples.TREE)._console  # the default is the promise
    assert console.stderr
