"""What a terminal, or a file, shows of a run while it goes on."""

import io
from dataclasses import replace

import pytest
import sample_run as samples
from rich.console import Console

from app.live import RunDisplay, RunInfo, Snapshot
from app.live.run_display import picture
from hw import Fault, FaultKind

ABOUT = RunInfo(task="pick_place", where="frankie · kinematic", objects=10)


def moment(
    tick: int, paused: str = "", faults: tuple[Fault, ...] = (), placed: int = 7
) -> Snapshot:
    seen = samples.moment(tick)
    return replace(seen, state=replace(seen.state, faults=faults), placed=placed, paused=paused)


def shown(moments: list[Snapshot], *, terminal: bool, height: int = 30) -> str:
    """What is written when each moment is shown for long enough."""
    out = io.StringIO()
    console = Console(
        file=out, force_terminal=terminal, width=100, height=height, color_system=None
    )
    with RunDisplay(ABOUT, samples.TREE, console=console) as display:
        for one in moments:
            display.show(one)
    return out.getvalue()


def test_a_terminal_shows_task_figures_and_the_whole_tree() -> None:
    text = picture(ABOUT, samples.TREE, moment(60), elapsed=2.0, width=100, rows=30).plain
    assert "pick_place  frankie · kinematic" in text
    assert "7 of 10 placed  8 grasps" in text
    assert all(node.name.split()[0] in text for node in samples.TREE)
    assert "▶ navigate to above_container  2.4" in text


def test_pauses_and_faults_are_badges() -> None:
    fault = Fault(kind=FaultKind.REFLEX, text="collision reflex", clearable=True)
    one = moment(60, paused="by a person", faults=(fault,))
    text = picture(ABOUT, samples.TREE, one, elapsed=2.0, width=100, rows=30)
    first = text.plain.splitlines()[0]
    assert first.startswith(" FAULT: collision reflex   PAUSED by a person  pick_place")


def test_what_a_terminal_has_no_rows_for_is_left_out_but_never_the_running_leaf() -> None:
    for rows in range(4, 14):
        lines = picture(
            ABOUT, samples.TREE, moment(60), elapsed=2.0, width=60, rows=rows
        ).plain.splitlines()
        assert len(lines) <= max(rows, 5)
        assert all(len(line) <= 60 for line in lines)
        assert any("navigate to above_container" in line for line in lines)


def test_a_file_gets_one_line_a_change() -> None:
    text = shown([moment(tick, placed=tick // 100) for tick in range(300)], terminal=False)
    lines = text.splitlines()
    assert "\x1b" not in text
    assert lines[0] == "    0.00 s  ▶ recover: 3.00 m to go ⏱"
    assert any("✔ recover" in line for line in lines)
    assert any(line.endswith("1 of 10 placed") for line in lines)
    assert sum("navigate to above" in line for line in lines) == 2  # begun, and done
    assert len(lines) < 15


def test_a_file_gets_a_line_for_pause_and_fault_and_for_their_end() -> None:
    fault = Fault(kind=FaultKind.REFLEX, text="reflex", clearable=True)
    moments = [moment(0), moment(1, "by a person", (fault,)), moment(2, "by a person"), moment(3)]
    lines = [line[12:] for line in shown(moments, terminal=False).splitlines()]
    assert [line for line in lines if "recover" not in line and "region" not in line] == [
        "  7 of 10 placed",
        "! FAULT: reflex",
        "‖ PAUSED by a person",
        "! faults cleared",
        "▶ resumed",
    ]


@pytest.mark.parametrize("terminal", [True, False])
def test_markup_in_a_message_is_only_text(terminal: bool) -> None:
    one = moment(0)
    nodes = tuple(node._replace(message="[red]a\nb[/nope]") for node in one.nodes)
    one = replace(one, nodes=nodes)
    if terminal:
        text = picture(ABOUT, samples.TREE, one, elapsed=2.0, width=100, rows=30).plain
    else:
        text = shown([one], terminal=False)
    assert "[red]a b[/nope]" in text


def test_the_time_is_the_tasks_and_a_pause_stands_beside_it() -> None:
    one = moment(60, paused="by a person")
    one = replace(one, time=57.3, paused_s=297.6)
    text = picture(ABOUT, samples.TREE, one, elapsed=2.0, width=120, rows=30).plain
    assert "57.3 s, paused 4 min 57 s" in text
    assert shown([one], terminal=False).startswith("   57.30 s  ‖ PAUSED by a person")


def test_the_loop_is_told_when_the_terminal_is_gone() -> None:
    class Gone(io.StringIO):
        def write(self, text: str) -> int:
            raise OSError(5, "gone")

    console = Console(file=Gone(), force_terminal=False, width=100)
    with RunDisplay(ABOUT, samples.TREE, console=console) as display:
        display.show(moment(0))
        display._feed._thread.join(5.0)
        with pytest.raises(OSError, match="gone"):
            display.show(moment(1))
