"""How large a recording gets when everything moves and the camera never rests."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sample_run as samples

from app.live import Snapshot
from app.live.monitor.writer import Writer
from controller import robot_model
from robots import Intrinsics

SECONDS, PERIOD = 8.0, 0.01
BATCH = 20
"""Ticks that are written at once while somebody watches: five times a second."""
LOOK = 40
"""Ticks between two images that the recorder lets through."""
LARGEST = 150e6 / 600.0
"""Of one second [bytes]: ten minutes in 150 MB."""


def restless() -> list[Snapshot]:
    """All joints and signals change every tick, and so do images of 640 by 480."""
    lens = Intrinsics(width=640, height=480, fx=386.0, fy=386.0, cx=319.5, cy=239.5)
    pattern = samples.snapshot(201, lens)
    assert pattern.frame is not None
    random = np.random.default_rng(0)
    run = []
    for tick in range(round(SECONDS / PERIOD)):
        looks = tick % LOOK == 0
        noise = random.normal(0.0, 0.001, pattern.frame.depth.shape) if looks else 0.0
        frame = replace(pattern.frame, depth=(pattern.frame.depth + noise).astype(np.float32))
        q = pattern.state.q + 0.1 * np.sin(tick * PERIOD + np.arange(7))
        run.append(
            replace(
                pattern,
                tick=tick,
                state=replace(pattern.state, stamp=tick * PERIOD, q=q),
                command=replace(pattern.command, qd=random.normal(size=7)),
                report=replace(pattern.report, slack=random.random()),
                seconds=random.random(),
                frame=frame if looks else None,
                detection=pattern.detection if looks else None,
            )
        )
    return run


@pytest.mark.slow
def test_ten_minutes_of_a_restless_run_fit_in_150_megabytes(tmp_path: Path) -> None:
    parts = {"tree": samples.TREE, "model": robot_model("frankie"), "scene": samples.SCENE}
    sizes = []
    for name, run in (("empty", []), ("full", restless())):
        writer = Writer(tmp_path / name, **parts, server=None)
        for start in range(0, len(run), BATCH):
            writer.write(run[start : start + BATCH])
        writer.close()
        sizes.append((tmp_path / name).stat().st_size)
    assert (sizes[1] - sizes[0]) / SECONDS < LARGEST
