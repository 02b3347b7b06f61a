"""Where the messages of a run go: into an MCAP file, or to live viewers."""

import secrets
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from importlib.resources import files
from itertools import chain
from pathlib import Path
from typing import Any

from app.choices import Schemas
from app.live.feed import Feed
from app.live.operator import Control
from app.live.ros2.messages import TOPICS, Messages, cdr
from app.live.snapshot import ShownRun, Snapshot
from app.live.web.ports import choose_port, reachable
from config import UserError, extra
from hw.ros2 import definition

try:
    from foxglove import Capability, Channel, Context, Parameter, Schema, open_mcap, start_server
    from foxglove.mcap import MCAPWriteOptions
    from foxglove.websocket import Client, ServerListener

    from app.live.ros2.own_schemas import SCHEMAS, encode

    _ROS2 = {
        topic: Schema(name=kind, encoding="ros2msg", data=definition(kind).encode())
        for topic, kind in TOPICS.items()
    }
except ModuleNotFoundError as error:
    raise UserError(f"MCAP and Foxglove need {error.name}: {extra('foxglove')}") from None

USUAL_PORT = 8765  # Foxglove's default

_PERIOD = 0.05  # interval of sending [s of real time]
_PATIENCE = 5.0  # time to send the rest [s]


def _writer(
    run: ShownRun, schemas: Schemas = Schemas.ROS2
) -> tuple[Context, Callable[[Iterable[Snapshot]], None]]:
    """What writes the messages of a run, and the context whose sinks get them."""
    own = schemas is Schemas.FOXGLOVE
    context, messages = Context(), Messages(run, encode if own else cdr)
    channels = {}
    for topic, schema in (_ROS2 | SCHEMAS if own else _ROS2).items():
        encoding = "protobuf" if schema.encoding == "protobuf" else "cdr"
        channels[topic] = Channel(topic, message_encoding=encoding, schema=schema, context=context)

    def write(snapshots: Iterable[Snapshot]) -> None:
        for one in chain.from_iterable(map(messages.of, snapshots)):
            channels[one.topic].log(one.data, log_time=one.time)

    return context, write


def write_mcap(path: Path, run: ShownRun, snapshots: Iterable[Snapshot], schemas: Schemas) -> None:
    """Write the messages of a run into a new file; UserError: it exists or cannot be written."""
    context, write = _writer(run, schemas)
    options = MCAPWriteOptions(profile="ros2" if schemas is Schemas.ROS2 else "")
    try:
        with open_mcap(path, context=context, writer_options=options):
            write(snapshots)
    except (OSError, RuntimeError) as error:
        raise UserError(f"{path}: cannot be written ({error}); name a new file") from error


class _Parameters(ServerListener):
    """Lets a client that sets `token` to the right one set `paused`; called by server threads."""

    def __init__(self, control: Control) -> None:
        self.token = secrets.token_urlsafe(16)
        self._control = control
        self._trusted: set[int] = set()

    def values(self) -> list[Parameter]:
        return [Parameter("paused", value=self._control.state.paused), Parameter("token", value="")]

    def on_get_parameters(self, client: Client, *_: Any) -> list[Parameter]:
        return self.values()

    def on_set_parameters(
        self, client: Client, parameters: list[Parameter], *_: Any
    ) -> list[Parameter]:
        for one in parameters:
            value = one.get_value()
            if one.name == "token":
                if secrets.compare_digest(str(value).encode(), self.token.encode()):
                    self._trusted.add(client.id)
            elif one.name == "paused" and client.id in self._trusted:
                (self._control.pause if value else self._control.resume)()
        return self.values()


@contextmanager
def served(
    run: ShownRun, control: Control, host: str, port: int | None, say: Callable[[str], None]
) -> Iterator[Callable[[Snapshot], None]]:
    """Serve the snapshots that are given to a function over WebSocket; `say` tells where.

    The loop never waits for it. Anybody who can connect can watch; who has the token can pause.
    `port` None takes the usual one, or a free one if that is taken. Raises UserError: the port is
    not available.
    """
    (context, write), parameters = _writer(run), _Parameters(control)
    try:
        server = start_server(
            name="frankie-task",
            host=host,
            port=choose_port(host, port, USUAL_PORT),
            capabilities=[Capability.Parameters],
            server_listener=parameters,
            context=context,
        )
    except (OSError, RuntimeError) as error:
        where = f"--view-port {port or USUAL_PORT} on {host}"
        raise UserError(f"{where}: {error}; choose another port or address") from error
    layout, address = files(__package__) / "layout.json", f"ws://{reachable(host)}:{server.port}"
    say(f"Foxglove at {address} (layout: {layout}); token to pause: {parameters.token}")
    told = control.state.paused

    def send(batch: Sequence[Snapshot]) -> None:
        nonlocal told
        write(batch)
        if control.state.paused is not told:
            told = not told
            server.publish_parameter_values(parameters.values())

    feed = Feed(send, lossless=False, period=_PERIOD, name="foxglove")
    try:
        yield feed.offer
    finally:
        feed.close(_PATIENCE)
        server.stop()
