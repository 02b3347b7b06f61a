"""Recorded runs as a LeRobotDataset, layout version 3: one episode per run, for learning policies.

The layout is plain Parquet and JSON and is written directly: the `lerobot` package pins versions of
Rerun and PyTorch that conflict with this project's. A dataset has the motion of a run, without
camera images.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from os.path import isfile, lexists
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from app.core import COMMANDS, STATES
from app.review import read_run
from config import Diagnostics, UserError, content, read_yaml

if TYPE_CHECKING:
    import pyarrow as pa

USUAL_FPS = 50

_SHORTEST, _LONGEST = 1e-4, 1.0
"""Of a control period [s]."""

_JOINTS = [f"joint_{number}" for number in range(1, 8)]
_VECTORS = {
    "observation.state": ["base_x", "base_y", "base_heading", *_JOINTS, "fingers"],
    "observation.velocity": ["base_vx", "base_vy", "base_w", *_JOINTS],
    "action": ["base_vx", "base_vy", "base_w", *_JOINTS, "fingers"],
}
"""Vectors of float32 by feature, in metres, radians and seconds. The action has the applied
velocities, and the width of the fingers one frame later."""
_NUMBERS = {
    "timestamp": "float32",
    "frame_index": "int64",
    "episode_index": "int64",
    "index": "int64",
    "task_index": "int64",
}
_QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
_CHUNK = "chunk-000/file-000.parquet"
_PATTERN = "chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"

Array = npt.NDArray[Any]


class ExportError(UserError):
    """Runs cannot be exported; the text says which and why."""


@dataclass(frozen=True, kw_only=True)
class _Episode:
    task: str
    robot: str
    columns: dict[str, Array]
    """(frames,) or (frames, n) by feature, without the indices, which depend on other episodes."""

    @property
    def length(self) -> int:
        return len(self.columns["timestamp"])


def export_lerobot(folders: Sequence[Path], out: Path, fps: int = USUAL_FPS) -> int:
    """Write a dataset.

    Args:
        folders: of the runs, one episode each.
        out: folder of the dataset; created here.
        fps: frames per second; must divide the control rate.

    Returns:
        Number of frames.

    Raises:
        ExportError: a run has no recorded motion, or a different rate or robot; or `out` exists.
    """
    if lexists(out):
        raise ExportError(f"{out}: exists already; choose a new folder")
    episodes = [_read(folder, fps) for folder in folders]
    robots = {episode.robot for episode in episodes}
    if len(robots) > 1:
        raise ExportError(f"different robots ({', '.join(sorted(robots))}): export them separately")
    tasks = list(dict.fromkeys(episode.task for episode in episodes))
    tables = _numbered(episodes, tasks)
    everything = {key: np.concatenate([table[key] for table in tables]) for key in tables[0]}
    try:
        _write_parquet(out / "data" / _CHUNK, _data_table(everything))
        _write_parquet(out / "meta" / "episodes" / _CHUNK, _episodes_table(episodes, tables))
        _write_parquet(out / "meta" / "tasks.parquet", _tasks_table(tasks))
        _write_json(out / "meta" / "stats.json", _statistics(everything))
        _write_json(
            out / "meta" / "info.json",
            _info(robots.pop(), fps, len(episodes), len(everything["index"]), len(tasks)),
        )
    except OSError as error:
        raise ExportError(f"{out}: cannot be written ({error.strerror})") from error
    return len(everything["index"])


def _read(folder: Path, fps: int) -> _Episode:
    """The frames of one run."""
    states, commands = _array(folder / STATES, 22), _array(folder / COMMANDS, 11)
    count = min(len(states), len(commands))
    if count < 2:
        raise ExportError(f"{folder}: the run is too short ({count} ticks); name another")
    period = float(np.median(np.diff(states[:count, 0])))
    if not _SHORTEST <= period <= _LONGEST:
        raise ExportError(f"{folder}: its stamps are {period:g} s apart; name another run")
    rate = round(1.0 / period)
    if fps < 1 or rate % fps:
        fitting = ", ".join(str(n) for n in range(1, rate + 1) if rate % n == 0)
        raise ExportError(f"--fps {fps}: {folder} has {rate} ticks per second; choose {fitting}")
    states, commands = states[: count : rate // fps], commands[: count : rate // fps]
    pose, twist, q, qd, fingers = np.split(states[:, 1:], [3, 6, 13, 20], axis=1)
    later = np.concatenate([fingers[1:], fingers[-1:]])
    record = read_run(folder)
    return _Episode(
        task=_description(folder) or record.task,
        robot=record.summary.robot or "frankie",
        columns={
            "observation.state": np.hstack([pose, q, fingers]).astype(np.float32),
            "observation.velocity": np.hstack([twist, qd]).astype(np.float32),
            "action": np.hstack([commands[:, 1:], later]).astype(np.float32),
            "timestamp": (np.arange(len(states)) / fps).astype(np.float32),
        },
    )


def _array(path: Path, columns: int) -> Array:
    """Recorded numbers, (ticks, columns); files that contain code are refused, not run."""
    try:
        if not isfile(path):
            raise ValueError("there is no such file")
        array = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError, MemoryError, OverflowError, SyntaxError) as error:
        reason = " ".join(str(error).split())[:100]
        raise ExportError(
            f"{path}: the run has no recorded motion ({reason}); name another"
        ) from error
    if not isinstance(array, np.ndarray) or array.dtype != np.float64:
        raise ExportError(f"{path}: contains no array of float64; name another run")
    if array.shape[1:] != (columns,):
        raise ExportError(
            f"{path}: has the shape {array.shape}, not (ticks, {columns}); name another run"
        )
    if not np.isfinite(array).all():
        raise ExportError(f"{path}: contains numbers that are not finite; name another run")
    return array


def _description(folder: Path) -> str:
    """The description in the task file; empty if it has none that can be read."""
    path = folder / "task.yaml"
    read = read_yaml(Diagnostics(path)) if isfile(path) else None
    task = content(read[1]) if read is not None else None
    description = task.get("description") if isinstance(task, dict) else None
    return description if isinstance(description, str) else ""


def _numbered(episodes: Iterable[_Episode], tasks: list[str]) -> list[dict[str, Array]]:
    """The columns of every episode, with all indices."""
    tables, begin = [], 0
    for number, episode in enumerate(episodes):
        frames = np.arange(episode.length)
        tables.append(
            {
                **episode.columns,
                "frame_index": frames,
                "episode_index": np.full(episode.length, number),
                "index": begin + frames,
                "task_index": np.full(episode.length, tasks.index(episode.task)),
            }
        )
        begin += episode.length
    return tables


def _statistics(columns: dict[str, Array]) -> dict[str, dict[str, list[float]]]:
    """Statistics of each feature, for normalisation."""
    found = {}
    for key, values in columns.items():
        rows = values.reshape(len(values), -1).astype(np.float64)
        found[key] = {
            "min": rows.min(axis=0).tolist(),
            "max": rows.max(axis=0).tolist(),
            "mean": rows.mean(axis=0).tolist(),
            "std": rows.std(axis=0).tolist(),
            "count": [len(rows)],
            **{name: np.quantile(rows, q, axis=0).tolist() for name, q in _QUANTILES.items()},
        }
    return found


def _info(robot: str, fps: int, episodes: int, frames: int, tasks: int) -> dict[str, Any]:
    features: dict[str, Any] = {
        key: {"dtype": "float32", "shape": [len(names)], "names": names}
        for key, names in _VECTORS.items()
    }
    features |= {
        key: {"dtype": kind, "shape": [1], "names": None} for key, kind in _NUMBERS.items()
    }
    return {
        "codebase_version": "v3.0",
        "robot_type": robot,
        "total_episodes": episodes,
        "total_frames": frames,
        "total_tasks": tasks,
        "chunks_size": 1000,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": fps,
        "splits": {"train": f"0:{episodes}"},
        "data_path": f"data/{_PATTERN}",
        "video_path": None,
        "features": features,
    }


def _data_table(columns: dict[str, Array]) -> pa.Table:
    import pyarrow as pa

    arrays = {
        key: pa.FixedSizeListArray.from_arrays(pa.array(columns[key].ravel()), len(names))
        for key, names in _VECTORS.items()
    }
    arrays |= {key: pa.array(columns[key], kind) for key, kind in _NUMBERS.items()}
    return pa.table(arrays)


def _episodes_table(episodes: Sequence[_Episode], tables: Sequence[dict[str, Array]]) -> pa.Table:
    """Position and statistics of each episode."""
    import pyarrow as pa

    rows = []
    for episode, table in zip(episodes, tables, strict=True):
        begin = int(table["index"][0])
        row: dict[str, Any] = {
            "episode_index": int(table["episode_index"][0]),
            "tasks": [episode.task],
            "length": episode.length,
            "data/chunk_index": 0,
            "data/file_index": 0,
            "dataset_from_index": begin,
            "dataset_to_index": begin + episode.length,
        }
        for key, numbers in _statistics(table).items():
            row |= {f"stats/{key}/{name}": value for name, value in numbers.items()}
        rows.append(row | {"meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0})
    return pa.Table.from_pylist(rows)


def _tasks_table(tasks: list[str]) -> pa.Table:
    """The texts as the index of a pandas table, in which LeRobot looks them up."""
    import pyarrow as pa

    index = "__index_level_0__"
    table = pa.table({"task_index": pa.array(range(len(tasks)), "int64"), index: tasks})
    names = (("task_index", "task_index", "int64", "int64"), (None, index, "unicode", "object"))
    described = {
        "index_columns": [index],
        "column_indexes": [],
        "columns": [
            {"name": n, "field_name": f, "pandas_type": p, "numpy_type": t, "metadata": None}
            for n, f, p, t in names
        ],
    }
    return table.replace_schema_metadata({"pandas": json.dumps(described)})


def _write_parquet(path: Path, table: pa.Table) -> None:
    import pyarrow.parquet as pq

    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(table, path)


def _write_json(path: Path, content: dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content, indent=4) + "\n", encoding="utf-8")
