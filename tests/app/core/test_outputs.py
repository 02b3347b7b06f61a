"""What a run leaves, whatever happens to its process, its folder, its disk or its terminal.

Its files are whole at every moment, and what goes wrong with them is told once.
"""

import json
import os
import resource
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

import cv2
import numpy as np
import pytest
from command_line import call
from recorded_runs import faulty_words
from recordings import rows
from rerun.chunk import RrdReader
from waiting import until

from app.core import RunOptions, run_task
from app.core.files.disk import Disk
from app.core.outcome import End
from trees import find

TOY = """\
task: toy
scene: single
poses: {near: {xyz: [0.9, 0.2, 0.7], rpy_deg: [180, 0, 0]}}
tree: {sequence: [{wait: {duration_s: WAIT}}, {navigate: {to: near}}]}
"""


def toy(folder: Path, wait: float = 0.1) -> Path:
    path = folder / "toy.yaml"
    path.write_text(TOY.replace("WAIT", str(wait)))
    return path


def command(task: Path, *options: str) -> list[str]:
    where = ["--view", "none", "--record", str(task.parent / "runs")]
    return [sys.executable, "-m", "frankie_task_cli", "run", str(task), *where, *options]


@pytest.mark.realtime
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:RRD file has no footer")
def test_a_killed_run_leaves_all_but_the_last_second(tmp_path):
    run = subprocess.Popen(
        command(toy(tmp_path, wait=60.0), "--speed", "real"), stderr=subprocess.DEVNULL
    )
    try:
        until(lambda: [p for p in tmp_path.glob("runs/*/commands.npy") if len(np.load(p))])
        (folder,) = tmp_path.glob("runs/*")
        seen, at = np.load(folder / "commands.npy")[-1, 0], time.monotonic()
        time.sleep(2.2)
    finally:
        run.kill()
        ended = seen + time.monotonic() - at
        run.wait()
    for name, width in (("commands.npy", 11), ("states.npy", 22)):
        kept = np.load(folder / name)
        assert kept.shape[1] == width
        assert kept[-1, 0] >= ended - 1.0
        np.testing.assert_allclose(np.diff(kept[:, 0]), 0.01, atol=0.1)
    for entity in ("/signals/tick", "/world/poses"):
        assert rows(folder / "recording.rrd", entity)[-1]["t"] >= ended - 1.5
    events = [json.loads(line) for line in (folder / "events.jsonl").open()]
    assert events[0]["event"] == "begin"
    assert events[-1]["time"] >= ended - 2.0  # one a second, besides


def test_a_disk_that_is_full_before_the_run_is_told_in_a_line_and_nothing_moves(tmp_path):
    with largest_file(40_000):
        code, out, err = call("run", toy(tmp_path), "--record", tmp_path / "runs", "--json")
    assert (code, out) == (2, "")
    assert "cannot keep the run here (File too large); choose another with --record" in err
    assert not list(tmp_path.glob("runs/*/*.npy"))


@pytest.mark.slow
@pytest.mark.parametrize("terminal", ["<&- >&- 2>&-", "--json | true"])
def test_without_a_terminal_it_runs_and_prints_into_no_file(tmp_path, terminal):
    script = f'set -o pipefail; "$@" {terminal}'
    run = subprocess.run(
        ["bash", "-c", script, "bash", *command(toy(tmp_path))], stderr=subprocess.PIPE, text=True
    )
    assert (run.returncode, run.stderr.count("Traceback")) == (0, 0)
    assert "Exception ignored" not in run.stderr
    (folder,) = tmp_path.glob("runs/*")
    json.loads((folder / "summary.json").read_text())
    assert not any(b"success" in p.read_bytes() for p in folder.glob("*.npy"))


def test_a_folder_that_is_removed_does_not_end_the_run(tmp_path):
    ticks = count()

    def remove() -> bool:
        if next(ticks) == 50:
            shutil.rmtree(tmp_path / "runs")
        return False

    task = toy(tmp_path)
    result = run_task(RunOptions(tree=task, record=tmp_path / "runs"), interrupted=remove)
    assert result.outcome.end is End.SUCCESS
    assert "commands.npy was removed while it was written" in result.summary.warnings
    assert "summary.json cannot be written (No such file or directory)" in result.summary.warnings


SEVERAL = """\
import os, sys, time
from pathlib import Path
from app.core import RunOptions, run_task
for _ in range(4):
    run_task(RunOptions(tree=Path(sys.argv[1]), record=Path(sys.argv[2]), replayable=True))
    seen = []
    for _ in range(40):  # threads of the viewer's library take a moment to end
        time.sleep(0.05)
        seen.append([len(os.listdir(f"/proc/self/{of}")) for of in ("task", "fd")])
    print(*[min(counts) for counts in zip(*seen)])
"""


@pytest.mark.slow
def test_runs_in_one_process_leave_no_threads_and_no_handles(tmp_path):
    process = [sys.executable, "-c", SEVERAL, str(toy(tmp_path)), str(tmp_path / "runs")]
    first, *later = np.loadtxt(subprocess.check_output(process, text=True).splitlines())
    assert (np.max(later, axis=0) <= first).all()


@pytest.mark.slow
def test_a_disk_that_fills_under_way_costs_the_ends_of_files_though_the_robot_breaks(tmp_path):
    task = tmp_path / "drive.yaml"
    task.write_text("task: on\nposes: {away: {base: [60, 0], heading_deg: 0}}\n"
                    "tree: {drive: {to: away}}\n")  # fmt: skip
    options = ("--record", tmp_path / "runs", "--view", "none", "--json")
    with largest_file(1_000_000):  # as much as a run asks for before it begins, and no more
        code, out, err = call("run", task, *options, *faulty_words("reading breaks@40"))
    assert code == 3
    assert "Traceback" not in err
    told = "\n".join(json.loads(out)["warnings"])
    assert "recording.rrd: the recording ends early" in told
    assert "readings.npy ends early (File too large)" in told
    kept = np.load(next(tmp_path.glob("runs/*/readings.npy")))
    assert (kept["number"] == np.arange(len(kept))).all()


@pytest.mark.slow
def test_memory_does_not_grow_with_the_length_of_a_run(tmp_path):
    """Two minutes of driving about, looked at every four seconds."""
    options = RunOptions(tree=find("patrol"), record=tmp_path, parameters={"rounds": "1000"})
    ticks, sizes = count(), []

    def look() -> bool:
        if next(ticks) % 400 == 0:
            sizes.append(int(Path("/proc/self/statm").read_text().split()[1]))
        return len(sizes) > 30

    run_task(options, interrupted=look)
    assert max(sizes[3:]) < 1.03 * sizes[3]


def test_pictures_that_the_task_takes_are_in_the_folder_and_in_the_recording(tmp_path):
    task = tmp_path / "t.yaml"
    task.write_text("task: t\nscene: single\ntree: {repeat: 2, snapshot: {file: here}}\n")
    result = run_task(RunOptions(tree=task, record=tmp_path / "runs"))
    assert result.summary.messages == ["picture here", "picture here.2"]
    for name in ("here", "here.2"):
        depth = cv2.imread(str(result.folder / f"{name}.depth.png"), cv2.IMREAD_UNCHANGED)
        assert depth.dtype == np.uint16
        assert cv2.imread(str(result.folder / f"{name}.png")).shape == (*depth.shape, 3)
    chunks = RrdReader(result.folder / "recording.rrd").stream().to_chunks()
    recorded = {chunk.entity_path for chunk in chunks if "pictures" in chunk.entity_path}
    assert recorded == {"/pictures/here", "/pictures/here.2"}
    assert result.summary.warnings == []


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """No file of this process grows beyond this: as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def row(number: int) -> bytes:
    return np.array([number, number + 0.5]).tobytes()


def test_an_array_can_be_loaded_while_it_grows_and_holds_every_row_in_order(tmp_path):
    disk = Disk(tmp_path, lossless=True)
    array = disk.array("rows.npy", (np.float64, (2,)))
    seen = []
    for number in range(50_000):
        array.add(row(number))
        if number % 5_000 == 0:
            loaded = np.load(tmp_path / "rows.npy")
            assert (loaded[:, 0] == np.arange(len(loaded))).all()
            seen.append(len(loaded))
    assert disk.close() == []
    assert seen[-1] > 0, "nothing was written before the end"
    expected = np.stack([np.arange(50_000), np.arange(50_000) + 0.5], axis=1)
    assert (np.load(tmp_path / "rows.npy") == expected).all()


def test_a_full_disk_ends_one_file_and_spares_the_others(tmp_path):
    disk = Disk(tmp_path, lossless=True)
    large, small = disk.array("large.npy", (np.float64, (2,))), disk.file("small.txt")
    with largest_file(10_000):
        for number in range(5_000):
            large.add(row(number))
        small.add(b"still here")
        wrong = disk.close()
    assert wrong == ["large.npy ends early (File too large)"]
    assert (tmp_path / "small.txt").read_bytes() == b"still here"
    kept = np.load(tmp_path / "large.npy")
    assert (kept[:, 0] == np.arange(len(kept))).all()


def test_a_run_in_real_time_never_waits_for_a_disk_that_hangs(tmp_path):
    """A pipe that nobody reads takes no more than 64 kB; then writing hangs."""
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    disk = Disk(tmp_path, lossless=False, capacity=100)
    pipe = disk.file("pipe")
    loop = threading.Thread(target=lambda: [pipe.add(bytes(10_000)) for _ in range(1000)])
    loop.start()
    loop.join(10.0)
    assert not loop.is_alive()
    assert disk.close(0.1) == ["the disk did not take the rest of the run within 0 s"]
    os.close(reader)
    assert "pipe ends early (Broken pipe)" in disk.close()  # it goes on, and ends
