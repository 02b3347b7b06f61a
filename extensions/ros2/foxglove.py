"""Where the messages of a run go: into an MCAP file, or to live viewers."""

import secrets
from collections.abc import Callable, Iterable, Sequence
from importlib.resources import files
from itertools import chain
from pathlib import Path
from typing import Any

from app.live import Control, Feed, LiveRun, Observer, ShownRun, Snapshot
from app.web import LOOPBACK, choose_port, reachable
from config import UserError, extra
from extensions.ros2.messages import definition
from extensions.ros2.run_messages import TOPICS, Messages, Schemas, cdr

try:
    from foxglove import Capability, Channel, Context, Parameter, Schema, open_mcap, start_server
    from foxglove.mcap import MCAPWriteOptions
    from foxglove.websocket import Client, ServerListener

    from extensions.ros2.own_schemas import SCHEMAS, encode

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
    run: ShownRun, schemas: Schemas = "ros2"
) -> tuple[Context, Callable[[Iterable[Snapshot]], None]]:
    """What writes the messages of a run, and the context whose sinks get them."""
    own = schemas == "foxglove"
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
    options = MCAPWriteOptions(profile="ros2" if schemas == "ros2" else "")
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


class FoxgloveServer(Observer):
    """Serves a run over WebSocket. Anybody who can connect can watch; who has the token can pause.

    `port` None takes the usual one, or a free one if that is taken. Raises UserError: the port is
    not available.
    """

    resumes = True

    def __init__(self, run: LiveRun, host: str, port: int | None) -> None:
        (self._context, self._write), self._control = _writer(run.shown), run.control
        self._parameters = _Parameters(run.control)
        try:
            self._server = start_server(
                name="frankie-task",
                host=host,
                port=choose_port(host, port, USUAL_PORT),
                capabilities=[Capability.Parameters],
                server_listener=self._parameters,
                context=self._context,  # kept, as its channels end with it
            )
        except (OSError, OverflowError, RuntimeError) as error:
            where = f"--with foxglove:{host}:{port or USUAL_PORT}"
            raise UserError(f"{where}: {error}; choose another port or address") from error
        address = f"ws://{reachable(host)}:{self._server.port}"
        layout = files(__package__) / "layout.json"
        run.say(
            f"Foxglove at {address} (layout: {layout}); token to pause: {self._parameters.token}"
        )
        if host != LOOPBACK:
            run.say(f"warning: anybody who can reach {host} can watch, without a password")
        self._told = run.control.state.paused
        self._feed = Feed(self._send, lossless=False, period=_PERIOD, name="foxglove")

    def show(self, snapshot: Snapshot) -> None:
        """Send a tick soon."""
        self._feed.offer(snapshot)

    def close(self) -> None:
        """Send the rest, and stop serving."""
        self._feed.close(_PATIENCE)
        self._server.stop()

    def _send(self, batch: Sequence[Snapshot]) -> None:
        self._write(batch)
        if self._control.state.paused is not self._told:
            self._told = not self._told
            self._server.publish_parameter_values(self._parameters.values())


def foxglove(argument: str, run: LiveRun) -> Observer:
    """Serves Foxglove at `PORT`, `HOST` or `HOST:PORT`; nothing: the usual port on loopback."""
    host, _, port = argument.rpartition(":")
    if not port.isdecimal():
        host, port = port, ""
    try:
        return FoxgloveServer(run, host or LOOPBACK, int(port) if port else None)
    except ValueError as error:
        raise UserError(f"--with foxglove:{argument}: {error}; write HOST:PORT") from error
