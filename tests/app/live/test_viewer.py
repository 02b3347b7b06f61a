"""Who can watch, where, and the messages when that is not possible."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.live import View, Viewer, ViewError
from app.run_options import RunOptions
from app.web import LOOPBACK


@pytest.fixture(autouse=True)
def no_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


def viewer(messages: list[str] | None = None, **chosen) -> Viewer:
    return Viewer(
        RunOptions(tree=Path(), **chosen), say=print if messages is None else messages.append
    )


@pytest.fixture
def taken() -> Iterator[int]:
    """A port that somebody listens on."""
    with socket.socket() as other:
        other.bind((LOOPBACK, 0))
        other.listen()
        yield other.getsockname()[1]


def test_a_window_is_opened_only_where_there_is_a_screen(monkeypatch) -> None:
    with pytest.raises(ViewError, match="--view spawn: there is no screen here; --view web"):
        viewer(view=View.SPAWN)
    assert viewer(view=View.AUTO).server is None
    monkeypatch.setenv("DISPLAY", ":0")
    assert viewer(view=View.AUTO).server.host == LOOPBACK


def test_a_port_that_is_taken_is_refused_if_it_was_asked_for(taken: int) -> None:
    for page in (taken, taken - 1):
        with pytest.raises(ViewError, match=f"--view-address {LOOPBACK}:{taken}: .*in use; choose"):
            viewer(view=View.WEB, view_address=f"{LOOPBACK}:{page}")


def test_another_port_is_found_if_the_usual_one_is_taken(taken: int, monkeypatch) -> None:
    monkeypatch.setattr("app.live.viewer.viewer.USUAL_PORT", taken)
    assert viewer(view=View.WEB).server.port not in (0, taken)


def test_an_address_that_is_not_this_machines_is_refused() -> None:
    for wrong in ("nowhere", f"{LOOPBACK}:web"):
        with pytest.raises(ViewError, match=f"--view-address {wrong}: use an IPv4 address of this"):
            viewer(view=View.WEB, view_address=wrong)
    with pytest.raises(ViewError, match=r"--view-address 203\.0\.113\.7:9090: .*address"):
        viewer(view=View.WEB, view_address="203.0.113.7")


def test_whoever_serves_others_is_warned_that_there_is_no_password(tmp_path: Path) -> None:
    messages: list[str] = []
    with viewer(messages, view=View.WEB, view_address="0.0.0.0").showing(tmp_path / "viewer.log"):
        pass
    assert "without a password" in messages[0]
    assert messages[1].startswith("watch at http://127.0.0.1:")


@pytest.mark.parametrize("view", [View.SPAWN, View.WEB])
def test_a_viewer_that_does_not_start_is_no_reason_not_to_run(
    view: View, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    messages: list[str] = []
    monkeypatch.setenv("DISPLAY", ":0")
    shown = viewer(messages, view=view)
    for room in ("live.viewer.viewer", "web.viewer_files"):
        monkeypatch.setattr(f"app.{room}.viewer_program", lambda: "/bin/false")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))  # where nothing is kept yet
    with shown.showing(tmp_path / "viewer.log"):
        pass
    assert messages[0].startswith("the viewer did not start (")
    assert messages[0].endswith("; the run is still recorded")
