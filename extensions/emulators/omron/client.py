"""One client of the emulated server: handshake, requests and replies."""

import hashlib
import random
import socket
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from struct import pack

from extensions.emulators.omron.options import Options
from extensions.emulators.omron.requests import Entry, Requests
from extensions.emulators.omron.wire import Splitter, Taker, Writer, seal, spoiled

_CHUNK = 12  # entries of one list packet


class GoneError(Exception):
    """The client has left, or was rejected."""


def received(connection: socket.socket) -> bytes:
    """What has arrived; raises GoneError when the client has left."""
    try:
        data = connection.recv(65536)
    except BlockingIOError:
        return b""
    except OSError as error:
        raise GoneError from error
    if not data:
        raise GoneError
    return data


@dataclass
class Subscription:
    """A request that is answered repeatedly."""

    entry: Entry
    interval: float  # [s]; negative: on change
    arguments: bytes
    due: float
    last: bytes | None = None


class Client:
    """A connection, driven by the emulator's thread."""

    def __init__(
        self,
        connection: socket.socket,
        requests: Requests,
        options: Options,
        number: int,
        *,
        is_full: bool = False,
    ) -> None:
        self.socket = connection
        self._requests, self._options = requests, options
        self._random = random.Random(options.seed * 1000 + number)
        self._splitter = Splitter()
        self._offers: dict[int, Entry] = {}
        self._subscriptions: dict[int, Subscription] = {}
        self._key = f"{self._random.getrandbits(48):012x}"
        self._is_full = is_full
        self._is_leaving = False
        self._out: list[tuple[float, bytes]] = []  # frames on their way, and when they may leave
        self._leaves_at = 0.0
        self.is_welcome = False  # whether the handshake is done
        body = Writer().string("alpha").integer(0, 2)
        body.integer(self._random.getrandbits(32), 4).integer(self._random.getrandbits(32), 4)
        self._send(seal(2, body.string(self._key).string(options.protocol).body), 0.0)

    def hear(self, now: float) -> None:
        """Read and process; raise GoneError when the client has left."""
        for command, body in self._splitter.push(received(self.socket)):
            self._heed(command, Taker(body), now)
        self.write(now)

    def serve(self, now: float) -> None:
        """Once a cycle: send the replies that are due, and write."""
        for number, one in sorted(self._subscriptions.items()):
            if one.interval < 0.0:
                answer = one.entry.answer(Taker(one.arguments))
                if answer is not None and answer != one.last:
                    one.last = answer
                    self._send(seal(number, answer), now)
            elif now - one.due > max(one.interval, self._options.least_interval):
                one.due = now
                self._reply(number, one, now)
        self.write(now)

    def write(self, now: float) -> None:
        """Send frames that may leave; raise GoneError when the client has left or is rejected."""
        ready = b"".join(data for at, data in self._out if at <= now)
        self._out = [(at, data) for at, data in self._out if at > now]
        try:
            while ready:
                size = self._random.randint(1, 3) if self._options.pieces else len(ready)
                sent = self.socket.send(ready[:size])
                ready = ready[sent:]
        except BlockingIOError:
            self._out.insert(0, (now, ready))
        except OSError as error:
            raise GoneError from error
        if self._is_leaving and not self._out:
            raise GoneError

    def break_off(self) -> None:
        """Reset the connection in the middle of a frame."""
        with suppress(OSError):
            self.socket.send(seal(2, b"half of this is missing")[:9])
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, pack("ii", 1, 0))
        self.socket.close()

    def say_goodbye(self, now: float) -> None:
        """Announce that the server shuts down."""
        self._send(seal(1), now)
        self._is_leaving = True

    def _heed(self, command: int, taker: Taker, now: float) -> None:
        match command:
            case 1:
                raise GoneError
            case 2 if not self.is_welcome:
                self._introduce(taker, now)
            case 129:
                self._subscribe(taker, now)
            case 130:
                self._subscriptions.pop(taker.integer(2), None)
            case _ if command in self._offers:
                answer = self._offers[command].answer(taker)
                if answer is not None:
                    self._send(seal(command, answer), now)

    def _subscribe(self, taker: Taker, now: float) -> None:
        number, interval = taker.integer(2), taker.integer(4, signed=True)
        if number not in self._offers:
            return  # silently, as the robot does
        arguments = taker.raw(taker.left)
        one = Subscription(self._offers[number], interval / 1000.0, arguments, now)
        self._subscriptions[number] = one
        self._reply(number, one, now)

    def _reply(self, number: int, one: Subscription, now: float) -> None:
        one.last = one.entry.answer(Taker(one.arguments))
        if one.last is not None:
            self._send(seal(number, one.last), now)

    def _introduce(self, taker: Taker, now: float) -> None:
        taker.integer(2)
        user, digest = taker.string(), taker.raw(16)
        protocol = taker.string()
        password, groups = self._options.users.get(user, (None, frozenset()))
        expected = hashlib.md5(f"{self._key}{password}".encode("latin-1")).digest()
        if self._is_full:
            self._reject(5, now)
        elif password is None or digest != expected:
            self._reject(1, now)
        elif protocol != self._options.protocol:
            self._reject(4, now)
        else:
            self._welcome(groups, now)

    def _reject(self, reason: int, now: float) -> None:
        self._send(seal(6, Writer().integer(reason, 2).string("").body), now)
        self._is_leaving = True

    def _welcome(self, groups: frozenset[str], now: float) -> None:
        self.is_welcome = True
        offers = self._requests.of_groups(groups)
        self._offers = {one.number: one for one in offers.values()}
        self._send(seal(5), now)
        rows: dict[int, Callable[[str, Entry], tuple[str, str]]] = {
            129: lambda name, one: (name, f"about {name}"),
            131: lambda name, one: (one.arguments, ""),
            133: lambda name, one: (one.group, ""),
        }
        for command, row in rows.items():
            items = list(offers.items())
            for start in range(0, len(items), _CHUNK):
                chunk = items[start : start + _CHUNK]
                body = Writer().integer(len(chunk), 2)
                for name, one in chunk:
                    first, second = row(name, one)
                    body.integer(one.number, 2).string(first).string(second)
                self._send(seal(command, body.body), now)

    def _send(self, frame: bytes, now: float) -> None:
        options = self._options
        if options.garbage and self.is_welcome and self._random.random() < 0.3:
            frame = self._random.choice((b"\x0f", b"\0", spoiled(seal(300, b"damaged")))) + frame
        late = options.delay + self._random.uniform(0.0, options.jitter)
        self._leaves_at = max(self._leaves_at, now + late)  # nothing overtakes in a stream
        self._out.append((self._leaves_at, frame))
