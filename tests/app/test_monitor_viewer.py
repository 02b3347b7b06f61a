"""Opens a recording in the real viewer, without a window."""

import glob
import os
import socket
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import monitor_samples as samples
import pytest

from app.monitor import Recorder
from app.monitor.glyphs import LETTERS, SYMBOLS
from controller import robot_model

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not glob.glob("/usr/share/vulkan/icd.d/*.json"),
        reason="the viewer needs Vulkan: apt-get install mesa-vulkan-drivers",
    ),
]

VIEWS = {
    *("tree", "now", "history", "log", "scene", "depth and grasp quality"),
    *("joint velocities / limits", "base velocity"),
}


def wait_for(what: Callable[[], Any], seconds: float = 60.0) -> Any:
    """What `what` gives as soon as it is something."""
    error: Exception | None = None
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            if result := what():
                return result
        except Exception as failed:  # not up yet
            error = failed
        threading.Event().wait(0.2)
    raise AssertionError(f"nothing came in {seconds:.0f} s ({error})")


@pytest.fixture
def viewer(tmp_path: Path) -> Iterator[Any]:
    import rerun_cli
    from rerun.experimental import ViewerClient

    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    program = Path(rerun_cli.__file__).parent / "rerun"
    where = ["--bind", "127.0.0.1", "--port", str(port)]
    with (tmp_path / "viewer.log").open("w") as log:
        process = subprocess.Popen(
            [program, "--headless", *where, "--window-size", "1600x1000"],
            stdout=log,
            stderr=log,
            env=os.environ | {"XDG_RUNTIME_DIR": str(tmp_path)},
        )
        try:
            url = f"rerun+http://127.0.0.1:{port}/proxy"
            yield wait_for(lambda: ViewerClient.connect(url))
            assert process.poll() is None, (tmp_path / "viewer.log").read_text()[-2000:]
        finally:
            process.terminate()
            process.wait(20.0)


def test_the_viewer_shows_every_part_and_complains_of_none(viewer: Any, tmp_path: Path) -> None:
    letters = "".join(chr(code) for low, high in LETTERS for code in range(low, high + 1))
    characters = letters + "".join(sorted(SYMBOLS)) + "🤖"
    share = -(-len(characters) // len(samples.TREE))
    names = [characters[start : start + share] for start in range(0, len(characters), share)]
    path = tmp_path / "recording.rrd"
    recorder = Recorder(
        path,
        tree=[replace(node, name=name) for node, name in zip(samples.TREE, names, strict=True)],
        model=robot_model("frankie"),
        scene=samples.SCENE,
        lossless=True,
    )
    for snapshot in samples.run(300):
        recorder.record(snapshot)
    recorder.close()

    viewer.open(str(path))
    wait_for(lambda: {view.name for view in viewer.get_state().views} >= VIEWS)
    for stamp in (0.5, 3.9, 5.5):
        viewer.set_time("t", duration=stamp, play_state="paused")
        picture = viewer.take_screenshot()
        assert len(picture) > 50_000, "the picture is not empty"
    reports = {view.name: view.reports for view in viewer.get_state().views}
    assert reports == {name: [] for name in reports}
