"""Who can watch, where, and the messages when that is not possible."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.commands import app
from app.live import View, Viewer, ViewError, ViewOptions
from app.live.web.ports import LOOPBACK

NO_SCREEN: dict[str, str] = {}
SCREEN = {"DISPLAY": ":0"}


def viewer(*, messages: list[str] | None = None, screen: bool = False, **chosen) -> Viewer:
    say = print if messages is None else messages.append
    return Viewer(ViewOptions(**chosen), say=say, environment=SCREEN if screen else NO_SCREEN)


@pytest.fixture
def taken() -> Iterator[int]:
    """A port that somebody listens on."""
    with socket.socket() as other:
        other.bind((LOOPBACK, 0))
        other.listen()
        yield other.getsockname()[1]


def test_auto_opens_a_window_only_where_there_is_a_screen() -> None:
    assert viewer(view=View.AUTO).server is None
    served = viewer(view=View.AUTO, screen=True).server
    assert served is not None
    assert served.host == LOOPBACK


def test_a_window_without_a_screen_is_refused() -> None:
    with pytest.raises(ViewError, match="--view spawn: there is no screen here; --view web"):
        viewer(view=View.SPAWN)


def test_a_port_that_is_taken_is_refused_if_it_was_asked_for(taken: int) -> None:
    with pytest.raises(ViewError, match=f"--view-port {taken} on 127.0.0.1: .*in use; choose"):
        viewer(view=View.WEB, port=taken)
    with pytest.raises(ViewError, match=f"--web-port {taken} on 127.0.0.1: .*in use; choose"):
        viewer(view=View.WEB, web_port=taken)


def test_one_port_cannot_do_for_both() -> None:
    with socket.socket() as free:
        free.bind((LOOPBACK, 0))
        port = free.getsockname()[1]
    with pytest.raises(ViewError, match=f"--web-port {port}"):
        viewer(view=View.WEB, port=port, web_port=port)


def test_another_port_is_found_if_the_usual_one_is_taken(
    taken: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.live.viewer.viewer.USUAL_PORT", taken)
    served = viewer(view=View.WEB).server
    assert served is not None
    assert served.port not in (0, taken)


@pytest.mark.parametrize(
    ("host", "why"),
    [
        ("nowhere", "use an IPv4 address of this machine, for example 127.0.0.1"),
        ("::1", "use an IPv4 address"),
        ("203.0.113.7", "this machine does not have that address"),
    ],
)
def test_an_address_that_is_not_this_machines_is_refused(host: str, why: str) -> None:
    with pytest.raises(ViewError, match=f"--view-host {host}: {why}"):
        viewer(view=View.WEB, host=host)


def test_a_bad_port_ends_with_exit_code_2_before_anything_is_written(
    taken: int, tmp_path: Path
) -> None:
    options = ["--view", "web", "--view-port", str(taken), "--record", str(tmp_path / "runs")]
    result = CliRunner().invoke(app, ["run", "pick_one", *options])
    assert result.exit_code == 2
    assert f"--view-port {taken}" in result.stderr
    assert not (tmp_path / "runs").exists()


def test_whoever_serves_others_is_warned_that_there_is_no_password(tmp_path: Path) -> None:
    messages: list[str] = []
    with viewer(messages=messages, view=View.WEB, host="0.0.0.0").showing(tmp_path / "viewer.log"):
        pass
    assert "without a password" in messages[0]
    assert messages[1].startswith("watch at http://127.0.0.1:")


@pytest.mark.parametrize("view", [View.SPAWN, View.WEB])
def test_a_viewer_that_does_not_start_is_no_reason_not_to_run(
    view: View, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    messages: list[str] = []
    shown = viewer(messages=messages, view=view, screen=True)
    for room in ("viewer.viewer", "web.viewer_files"):
        monkeypatch.setattr(f"app.live.{room}.viewer_program", lambda: "/bin/false")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))  # where nothing is kept yet
    ran = False
    with shown.showing(tmp_path / "viewer.log"):
        ran = True
    assert ran
    assert messages[0].startswith("the viewer did not start (")
    assert messages[0].endswith("; the run is still recorded")
