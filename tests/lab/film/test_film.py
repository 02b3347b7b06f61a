"""`film`: a recording as a moving picture."""

import pytest
from command_line import call
from PIL import Image

from app.core import RunOptions, run_task
from lab.film.headless_viewer import has_vulkan
from trees import find


@pytest.mark.parametrize(
    ("out", "options", "said"),
    [
        ("run.mp4", (), "a film ends in .webp"),
        ("run.webp", ("--from", "5", "--to", "5"), "is no time"),
    ],
)
def test_what_cannot_be_filmed_is_one_line(tmp_path, out, options, said):
    recording = tmp_path / "recording.rrd"
    recording.write_bytes(b"RRF2")
    code, _, err = call("film", recording, tmp_path / out, *options)
    assert code == 2
    assert said in err


@pytest.mark.slow
@pytest.mark.skipif(
    not has_vulkan(), reason="the viewer needs Vulkan: apt-get install mesa-vulkan-drivers"
)
def test_a_film_shows_that_something_moves(tmp_path):
    folder = run_task(RunOptions(tree=find("pick_one"), record=tmp_path)).folder
    assert call("film", folder, "--to", "1")[0] == 0
    film = Image.open(folder / "recording.webp")
    assert film.n_frames == 4
    pictures = []
    for number in range(film.n_frames):
        film.seek(number)
        pictures.append(film.convert("RGB").tobytes())
    assert len(set(pictures)) == film.n_frames
