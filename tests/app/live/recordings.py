"""Recordings for tests: writing one of the sample run, and reading it back."""

from pathlib import Path
from typing import Any

import sample_run as samples
from rerun.chunk import RrdReader

from app.live import Recorder, Snapshot
from controller import robot_model

Table = list[dict[str, Any]]


def recorder(path: Path, **changes: Any) -> Recorder:
    settings: dict[str, Any] = {"tree": samples.TREE, "scene": samples.SCENE, "lossless": True}
    return Recorder(path, model=robot_model("frankie"), **(settings | changes))


def rows(path: Path, entity: str) -> Table:
    """The rows of an entity, by tick; times in seconds."""
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
    """The rows that have a component."""
    return [row for row in rows(path, entity) if component in row]


def poses(path: Path, frame: str) -> Table:
    """The recorded poses of a frame."""
    return [row for row in rows(path, "/world/poses") if row["child_frame"] == [frame]]


def static(path: Path, entity: str, component: str) -> list[Any]:
    """A static component of an entity."""
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
