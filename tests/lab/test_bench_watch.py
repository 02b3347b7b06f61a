import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.commands import app
from app.live.monitor.headless import has_vulkan


@pytest.mark.slow
@pytest.mark.skipif(
    not has_vulkan(), reason="the viewer needs Vulkan: apt-get install mesa-vulkan-drivers"
)
def test_bench_watch_measures_a_run_for_every_watcher(tmp_path: Path) -> None:
    figures = tmp_path / "figures.json"
    result = CliRunner().invoke(app, ["bench", "watch", "--seconds", "2", "--json", str(figures)])
    assert result.exit_code == 0, result.output
    runs = json.loads(figures.read_text())["runs"]
    assert [run["watcher"].split()[0] for run in runs] == ["nobody", "viewer", "viewer"]
    for run in runs:
        assert run["ticks"] >= 200
        assert 0.0 < run["median_us"] <= run["p99_us"] <= run["worst_us"]
        assert run["dropped"] == 0
        assert run["recording_mb"] > 0.1
    assert "what watching costs a tick" in result.output
