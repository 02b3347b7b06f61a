"""A recorder whose disk, file or process fails: the run goes on, and the user is told."""

import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import sample_run as samples
from recordings import recorder, rows

from app.live import RecorderError


@pytest.mark.parametrize("place", ["missing/x.rrd", ""])
def test_a_file_that_cannot_be_written_is_reported_at_once(tmp_path: Path, place: str) -> None:
    with pytest.raises(RecorderError, match=r"cannot write the recording .*choose a folder"):
        recorder(tmp_path / place)


def test_an_error_in_the_writer_is_reported_once_and_spares_the_run(tmp_path: Path) -> None:
    made = recorder(tmp_path / "x.rrd")
    snapshot = samples.snapshot(0)
    broken = replace(snapshot, state=replace(snapshot.state, q=snapshot.state.q[:3]))
    for tick in range(1200):
        state = replace((broken if tick == 150 else snapshot).state, stamp=tick * 0.02)
        made.record(replace(snapshot, tick=tick, state=state))
    with pytest.raises(RecorderError, match=r"x\.rrd: the recording ends early"):
        made.close()
    made.close()
    assert len(rows(tmp_path / "x.rrd", "/signals/tick")) < 200


LIMITED = """
import resource, sys
from pathlib import Path
sys.path[:0] = sys.argv[2:]
import sample_run as samples
from app.live import Recorder, RecorderError
from controller import robot_model
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
recorder = Recorder(
    Path(sys.argv[1]), tree=samples.TREE, model=robot_model("frankie"), scene=samples.SCENE,
    lossless=True,
)
for snapshot in samples.run(300):
    recorder.record(snapshot)
try:
    recorder.close()
except RecorderError as error:
    print(error)
"""

IN_REAL_TIME = LIMITED.split("resource.set", maxsplit=1)[0] + (
    """
import threading
recorder = Recorder(
    Path(sys.argv[1]), tree=samples.TREE, model=robot_model("frankie"), scene=samples.SCENE,
    lossless=False,
)
for snapshot in samples.run(1000):
    recorder.record(snapshot)
    print(snapshot.stamp, flush=True)
    threading.Event().wait(samples.PERIOD)
"""
)


def command(program: str, path: Path) -> list[str | Path]:
    here = Path(__file__).parent
    return [sys.executable, "-c", program, path, here, here.parents[2]]


@pytest.mark.slow
def test_a_disk_that_fills_up_is_reported_at_the_end(tmp_path: Path) -> None:
    path = tmp_path / "x.rrd"
    done = subprocess.run(
        command(LIMITED, path), capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0
    assert "the recording ends early" in done.stdout
    assert "is the disk full?" in done.stdout
    assert path.stat().st_size <= 200_000


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:RRD file has no footer")
def test_a_run_that_is_killed_is_kept_up_to_a_second_before(tmp_path: Path) -> None:
    path = tmp_path / "x.rrd"
    with subprocess.Popen(
        command(IN_REAL_TIME, path), stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        stamps = [float(process.stdout.readline()) for _ in range(200)]
        process.kill()
        stamps += [float(line) for line in process.stdout if line.endswith("\n")]
    assert process.returncode == -signal.SIGKILL
    for entity in ("/signals/tick", "/world/poses", "/world/camera/depth"):
        assert rows(path, entity)[-1]["t"] >= stamps[-1] - 1.0, entity
