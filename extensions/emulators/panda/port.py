"""One port of the emulated robot: requests over TCP from one client, states to it over UDP."""

import socket
import struct
from collections.abc import Iterator
from contextlib import suppress
from typing import NamedTuple


class Request(NamedTuple):
    """One request of a client."""

    command: int
    number: int
    payload: bytes


class Connection:
    """One port with at most one client; a second one waits until the first has left."""

    def __init__(self, host: str, port: int, header: struct.Struct) -> None:
        self._header = header
        self._listener = socket.socket()
        self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._listener.bind((host, port))
        self._listener.listen(4)
        self._listener.setblocking(False)
        self._udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._udp.bind((host, 0))
        self._udp.setblocking(False)
        self._client: socket.socket | None = None
        self._states_to: tuple[str, int] | None = None
        self._buffer = b""
        self._peer = ""
        self.is_blocked = False  # whether a firewall blocks states

    @property
    def has_client(self) -> bool:
        """Whether a client is connected."""
        return self._client is not None

    def requests(self) -> Iterator[Request]:
        """Requests that have arrived; accepts a client if there is none."""
        if self._client is None:
            with suppress(BlockingIOError):
                self._client, (self._peer, *_) = self._listener.accept()
                self._client.setblocking(False)
                self._client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if self._client is None:
            return
        try:
            data = self._client.recv(65536)
        except BlockingIOError:
            data = None
        except OSError:
            data = b""
        if data == b"":
            self.drop()
            return
        self._buffer += data or b""
        size = self._header.size
        while len(self._buffer) >= size:
            command, number, length = self._header.unpack_from(self._buffer)
            if not size <= length <= 65536:
                self.drop()
                return
            if len(self._buffer) < length:
                return
            payload, self._buffer = self._buffer[size:length], self._buffer[length:]
            yield Request(command, number, payload)

    def answer(self, request: Request, payload: bytes) -> None:
        """Answer a request."""
        size = self._header.size + len(payload)
        if self._client is not None:
            with suppress(OSError):
                self._client.sendall(
                    self._header.pack(request.command, request.number, size) + payload
                )

    def send_states_to(self, port: int) -> None:
        """Send states to a port of the client from now on."""
        self._states_to = (self._peer, port)

    @property
    def is_listened_to(self) -> bool:
        """Whether states are sent."""
        return self._states_to is not None

    def send_state(self, packet: bytes) -> None:
        """Send a state, if requested."""
        if self._states_to is not None and not self.is_blocked:
            with suppress(OSError):
                self._udp.sendto(packet, self._states_to)

    def packets(self) -> Iterator[bytes]:
        """Packets that have arrived."""
        while True:
            try:
                yield self._udp.recv(512)
            except OSError:
                return

    def drop(self) -> None:
        """Disconnect the client."""
        if self._client is not None:
            self._client.close()
        self._client, self._states_to, self._buffer = None, None, b""

    def close(self) -> None:
        """Close the port."""
        self.drop()
        self._listener.close()
        self._udp.close()
