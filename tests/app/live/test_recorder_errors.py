"""A recorder whose disk, file or process fails: the run goes on, and the user is told."""

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
