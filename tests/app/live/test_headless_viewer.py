"""Opens recordings and live runs in the real viewer, without a window."""

import signal
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
import sample_run as samples
from recordings import recorder
from waiting import until

from app.live.monitor.glyphs import LETTERS, SYMBOLS
from app.live.monitor.signals_panel import PLOTS
from app.web import Address
from lab.film.headless_viewer import HeadlessViewer, has_vulkan, headless_viewer

pytestmark = pytest.mark.skipif(
    not has_vulkan(), reason="the viewer needs Vulkan: apt-get install mesa-vulkan-drivers"
)

VIEWS = {
    *("tree", "now", "history", "log", "scene"),
    "depth and grasp quality",
    *(curves.name for curves in PLOTS.values()),
}
CLOSE_BEHIND = 2.0
"""A viewer that is this close is live [s]."""


def assert_nothing_is_wrong(viewer: HeadlessViewer) -> None:
    """Every view shows something and complains of nothing; tabs are opened one after the other."""
    views = {view.name: view.view_id for view in viewer.client.get_state().views}
    assert set(views) == VIEWS
    layout = viewer.client.get_blueprint().blueprint
    for view_id in views.values():
        layout["/viewport"]["ViewportBlueprint"]["maximized"] = view_id
        viewer.client.set_blueprint(layout, of="recording")
        assert len(viewer.client.take_screenshot(view_id)) > 1_000
    reports = {view.name: view.reports for view in viewer.client.get_state().views}
    assert reports == {name: [] for name in views}


@pytest.mark.slow
def test_a_recording_shows_every_part_and_complains_of_none(tmp_path: Path) -> None:
    letters = "".join(chr(code) for low, high in LETTERS for code in range(low, high + 1))
    characters = letters + "".join(sorted(SYMBOLS)) + "🤖"
    share = -(-len(characters) // len(samples.TREE))
    names = [characters[start : start + share] for start in range(0, len(characters), share)]
    path = tmp_path / "recording.rrd"
    tree = [replace(node, name=name) for node, name in zip(samples.TREE, names, strict=True)]
    made = recorder(path, tree=tree)
    for snapshot in samples.run(300):
        made.record(snapshot)
    made.close()
    with headless_viewer() as viewer:
        viewer.client.open(str(path))
        until(lambda: viewer.client.get_state().views)
        for stamp in (0.5, 3.9, 5.5):
            viewer.client.set_time("t", duration=stamp, play_state="paused")
            assert len(viewer.client.take_screenshot()) > 50_000, "the picture is not empty"
        assert_nothing_is_wrong(viewer)


@pytest.fixture
def live(tmp_path: Path) -> Iterator[SimpleNamespace]:
    """A run in real time, from a thread of its own: where it is seen, and how far it is."""
    run = SimpleNamespace(server=Address(), stamp=0.0)
    made = recorder(tmp_path / "recording.rrd", server=run.server, lossless=False)
    over = threading.Event()

    def go() -> None:
        begun = time.monotonic()
        for snapshot in samples.run(3000):
            made.record(snapshot)
            run.stamp = snapshot.stamp
            if over.wait(max(begun + snapshot.stamp - time.monotonic(), 0.0)):
                return

    thread = threading.Thread(target=go)
    thread.start()
    yield run
    over.set()
    thread.join()
    made.close()
    assert made.dropped == 0


@pytest.mark.realtime
@pytest.mark.slow
def test_a_viewer_that_hangs_holds_up_nothing_and_a_late_one_gets_it_all(live) -> None:
    with headless_viewer(watch=live.server.url) as viewer:
        until(lambda: viewer.cursor > 0.0)
        viewer.process.send_signal(signal.SIGSTOP)
        hung = live.stamp
        until(lambda: live.stamp > hung + 10.0)
        viewer.process.send_signal(signal.SIGCONT)
        until(lambda: live.stamp - viewer.cursor < CLOSE_BEHIND)
    with headless_viewer(watch=live.server.url) as late:
        until(lambda: live.stamp - late.cursor < CLOSE_BEHIND)
        (recording,) = late.client.get_state().recordings
        (begin,) = (line.start for line in recording.timelines if line.name == "t")
        assert begin == 0
