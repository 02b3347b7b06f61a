"""Export of runs as a LeRobotDataset, layout version 3.

The layout is plain Parquet, JSON and MP4 and is written directly: the `lerobot` package brings
PyTorch, and its viewer an older Rerun.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from os.path import lexists
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from extensions.export.depth_video import CODEC, FAR, NEAR, Video, write_video
from extensions.export.episodes import Episode, ExportError, read_episodes

if TYPE_CHECKING:
    import pyarrow as pa

USUAL_FPS = 50

_NUMBERS = {
    "next.done": "bool",
    "next.success": "bool",
    "timestamp": "float32",
    "frame_index": "int64",
    "episode_index": "int64",
    "index": "int64",
    "task_index": "int64",
}
_QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
_CHUNK = "chunk-000/file-000.parquet"
_VIDEO = "chunk-000/file-000.mp4"
DEPTH = "observation.images.depth"
_PATTERN = "chunk-{chunk_index:03d}/file-{file_index:03d}"
_VIDEO_PATTERN = f"videos/{{video_key}}/{_PATTERN}.mp4"

Array = npt.NDArray[Any]


class Exported(NamedTuple):
    """Contents of a dataset."""

    episodes: int
    failed: int
    frames: int
    has_video: bool


def _vectors(columns: dict[str, Array]) -> dict[str, list[str]]:
    """Names of the float32 numbers of each feature [m, rad, s].

    The action has the applied velocities, and the width of the fingers one frame later.
    """
    twist = ["base_vx", "base_vy", "base_w"]
    j = columns["observation.velocity"].shape[1] - len(twist)
    joints = [f"joint_{number}" for number in range(1, j + 1)]
    return {
        "observation.state": ["base_x", "base_y", "base_heading", *joints, "fingers"],
        "observation.velocity": [*twist, *joints],
        "action": [*twist, *joints, "fingers"],
    }


def export_lerobot(folders: Sequence[Path], out: Path, fps: int = USUAL_FPS) -> Exported:
    """Write a dataset of runs into a new folder, at a frame rate that divides the control rate.

    Raises ExportError: a run has no recorded motion, or a different rate, robot or size of
    pictures; or `out` exists.
    """
    if lexists(out):
        raise ExportError(f"{out}: exists already; choose a new folder")
    episodes = [one for folder in folders for one in read_episodes(folder, fps)]
    robots = {episode.robot for episode in episodes}
    if len(robots) > 1:
        raise ExportError(f"different robots ({', '.join(sorted(robots))}): export them separately")
    tasks = list(dict.fromkeys(episode.task for episode in episodes))
    tables = _numbered(episodes, tasks)
    everything = {key: np.concatenate([table[key] for table in tables]) for key in tables[0]}
    try:
        _write_parquet(out / "data" / _CHUNK, _data_table(everything))
        video = write_video(out / "videos" / DEPTH / _VIDEO, episodes, fps)
        rows = _episode_rows(episodes, tables, fps if video else None)
        _write_parquet(out / "meta" / "episodes" / _CHUNK, rows)
        _write_parquet(out / "meta" / "tasks.parquet", _tasks_table(tasks))
        pictures = {} if video is None else {DEPTH: video.statistics()}
        _write_json(out / "meta" / "stats.json", _statistics(everything) | pictures)
        _write_json(
            out / "meta" / "info.json",
            _info(robots.pop(), fps, len(episodes), everything, len(tasks), video),
        )
    except OSError as error:
        raise ExportError(f"{out}: cannot be written ({error.strerror})") from error
    failed = sum(not one.success for one in episodes)
    return Exported(len(episodes), failed, len(everything["index"]), video is not None)


def _numbered(episodes: Iterable[Episode], tasks: list[str]) -> list[dict[str, Array]]:
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


def _info(
    robot: str, fps: int, episodes: int, columns: dict[str, Array], tasks: int, video: Video | None
) -> dict[str, Any]:
    features: dict[str, Any] = {
        key: {"dtype": "float32", "shape": [len(names)], "names": names}
        for key, names in _vectors(columns).items()
    }
    features |= {
        key: {"dtype": kind, "shape": [1], "names": None} for key, kind in _NUMBERS.items()
    }
    if video is not None:
        features[DEPTH] = _video_feature(video, fps)
    return {
        "codebase_version": "v3.0",
        "robot_type": robot,
        "total_episodes": episodes,
        "total_frames": len(columns["index"]),
        "total_tasks": tasks,
        "chunks_size": 1000,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": fps,
        "splits": {"train": f"0:{episodes}"},
        "data_path": f"data/{_PATTERN}.parquet",
        "video_path": _VIDEO_PATTERN if video else None,
        "features": features,
    }


def _video_feature(video: Video, fps: int) -> dict[str, Any]:
    height, width = video.height, video.width
    return {
        "dtype": "video",
        "shape": [height, width, 3],
        "names": ["height", "width", "channels"],
        "info": {
            "video.height": height,
            "video.width": width,
            "video.channels": 3,
            "video.codec": CODEC,
            "video.pix_fmt": "yuv420p",
            "video.fps": fps,
            "video.is_depth_map": False,  # in LeRobot's own scale; ours stands below
            "has_audio": False,
            "depth.metres_at_1": NEAR,
            "depth.metres_at_255": FAR,
        },
    }


def _data_table(columns: dict[str, Array]) -> pa.Table:
    import pyarrow as pa

    arrays = {
        key: pa.FixedSizeListArray.from_arrays(pa.array(columns[key].ravel()), len(names))
        for key, names in _vectors(columns).items()
    }
    arrays |= {key: pa.array(columns[key], kind) for key, kind in _NUMBERS.items()}
    return pa.table(arrays)


def _episode_rows(
    episodes: Sequence[Episode], tables: Sequence[dict[str, Array]], video_fps: int | None
) -> pa.Table:
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
            "success": episode.success,
            "ended": episode.why,
            "run": episode.folder.name,
        }
        if video_fps is not None:
            row |= {
                f"videos/{DEPTH}/chunk_index": 0,
                f"videos/{DEPTH}/file_index": 0,
                f"videos/{DEPTH}/from_timestamp": begin / video_fps,
                f"videos/{DEPTH}/to_timestamp": (begin + episode.length) / video_fps,
            }
        for key, numbers in _statistics(table).items():
            row |= {f"stats/{key}/{name}": value for name, value in numbers.items()}
        rows.append(row | {"meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0})
    return pa.Table.from_pylist(rows)


def _tasks_table(tasks: list[str]) -> pa.Table:
    """The tasks as the index of a pandas table, in which LeRobot looks them up."""
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
