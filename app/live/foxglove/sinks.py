"""Where the messages of a run go: into an MCAP file, or to live viewers."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from app.live.snapshot import ShownRun, Snapshot
from config import UserError


class FoxgloveError(UserError):
    """Messages cannot be written or served as requested."""


def write_mcap(path: Path, run: ShownRun, snapshots: Iterable[Snapshot]) -> None:
    """Write the messages of a run into a new file.

    Raises FoxgloveError: the extra is missing, or the file exists or cannot be written.
    """
    context, write = _channels("export --mcap", run)
    from foxglove import open_mcap
    from foxglove.mcap import MCAPWriteOptions

    try:
        with open_mcap(path, context=context, writer_options=MCAPWriteOptions(profile="ros2")):
            write(snapshots)
    except (OSError, RuntimeError) as error:
        raise FoxgloveError(f"{path}: cannot be written ({error}); name a new file") from error


def _channels(what: str, run: ShownRun) -> tuple[Any, Callable[[Iterable[Snapshot]], None]]:
    """A context with a channel for each topic, and what writes snapshots to them."""
    try:
        from foxglove import Channel, Context, Schema

        from app.live.foxglove.messages import TOPICS, Messages
        from app.live.foxglove.ros import definition
    except ModuleNotFoundError as error:
        text = f'{what} needs {error.name}: pip install "frankie-task[foxglove]"'
        raise FoxgloveError(text) from None
    context, messages = Context(), Messages(run)
    channels = {}
    for topic, kind in TOPICS.items():
        schema = Schema(name=kind, encoding="ros2msg", data=definition(kind).encode())
        channels[topic] = Channel(topic, message_encoding="cdr", schema=schema, context=context)

    def write(snapshots: Iterable[Snapshot]) -> None:
        for snapshot in snapshots:
            for one in messages.of(snapshot):
                channels[one.topic].log(one.data, log_time=one.time)

    return context, write
