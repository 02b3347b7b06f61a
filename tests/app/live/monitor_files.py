"""Recordings for tests: making one of a made-up run, and reading back what it says."""

from pathlib import Path
from typing import Any

import monitor_samples as samples
from rerun.chunk import RrdReader

from app.live.monitor import Recorder, Snapshot
from controller import robot_model

Table = list[dict[str, Any]]


def recorder(path: Path, **changes: Any) -> Recorder:
    settings: dict[str, Any] = {"tree": samples.TREE, "scene": samples.SCENE, "lossless": True}
    return Recorder(path, model=robot_model("frankie"), **(settings | changes))


def rows(path: Path, entity: str) -> Table:
    """What the file says about an entity over time, by tick; times in seconds."""
    table: Table = []
    for chunk in RrdReader(path).stream().filter(content=entity).to_chunks():
        batch = chunk.to_record_batch()
        if "tick" not in batch.schema.names:
            continue
        columns = {
            name.split(":")[-1]: batch.column(name)
            for name in batch.schema.names
            if not name.startswith(("rerun.", "log_"))
        }
        columns["t"] = columns["t"].cast("int64")
        for index in range(batch.num_rows):
            row = {name: column[index].as_py() for name, column in columns.items()}
            table.append(row | {"t": row["t"] / 1e9})
    return sorted(table, key=lambda row: row["tick"])


def with_component(path: Path, entity: str, component: str) -> Table:
    """The rows that say something about one component."""
    return [row for row in rows(path, entity) if component in row]


def poses(path: Path, frame: str) -> Table:
    """Where the file says that a frame was."""
    return [row for row in rows(path, "/world/poses") if row["child_frame"] == [frame]]


def still(path: Path, entity: str, component: str) -> list[Any]:
    """What the file says about an entity for all times."""
    for chunk in RrdReader(path).stream().filter(content=entity).to_chunks():
        batch = chunk.to_record_batch()
        if "tick" not in batch.schema.names and component in batch.schema.names:
            return list(batch.column(component)[0].as_py())
    raise AssertionError(f"no {component} of {entity}")


def record(path: Path, snapshots: list[Snapshot], **changes: Any) -> Path:
    made = recorder(path, **changes)
    for snapshot in snapshots:
        made.record(snapshot)
    made.close()
    assert made.dropped == 0
    return path
