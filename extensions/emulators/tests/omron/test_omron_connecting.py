"""Beginnings that fail: each says in one line why, and what to do."""

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from emulated import SPEED, base_of, connected, repeating
from waiting import until

from drivers.omron import ArclOptions, OmronBase, OmronOptions, Site
from extensions.emulators.omron import EVERYTHING, OmronEmulator, Options
from extensions.emulators.omron.onboard_controller import Teleop
from extensions.emulators.omron.wire import Writer, seal
from hw import HardwareError, WallClock


def refused(base: OmronBase, *words: str) -> None:
    """Connecting ends with one line that has these words."""
    with pytest.raises(HardwareError) as caught:
        base.connect()
    text = str(caught.value)
    assert "\n" not in text
    for word in ("Omron", *words):
        assert word in text
    base.close()


def at(port: int, **settings) -> OmronBase:
    given = {"address": "127.0.0.1", "port": port, "user": "frankie", "connect_patience": 0.3}
    return OmronBase(OmronOptions(**(given | settings)), WallClock())


@contextmanager
def server(greeting: bytes) -> Iterator[int]:
    """Something else that listens: its port."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        clients: list[socket.socket] = []

        def greet() -> None:
            clients.append(listener.accept()[0])
            clients[0].sendall(greeting)

        thread = threading.Thread(target=greet, daemon=True)
        thread.start()
        yield listener.getsockname()[1]
        thread.join(1.0)
        for client in clients:
            client.close()


def test_nothing_listens():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    refused(at(port), f"127.0.0.1:{port}", "nothing listens", "check the port")
    refused(at(port, arcl=ArclOptions(password="adept", port=port)), "ARCL", f":{port}")


BODY = Writer().string("alpha").integer(0, 2).integer(1, 4).integer(2, 4)
REJECTION = seal(6, Writer().integer(4, 2).string("").body)


@pytest.mark.parametrize(
    ("greeting", "why"),
    [
        (b"SSH-2.0-OpenSSH_9.2\r\n", "does not greet"),
        (seal(2, b"alpha\0\1\2"), "greeting cannot be read"),
        (  # which is final, whatever comes after it
            seal(2, BODY.string("key").string("5MTX").body)
            + REJECTION
            + seal(5)
            + seal(129, b"\0\0"),
            "refuses our protocol version",
        ),
    ],
)
def test_something_else_listens(greeting, why):
    with server(greeting) as port:
        refused(at(port), why)


LIMITED = {"users": {"frankie": ("", EVERYTHING - {"Movement", "UnsafeMovement"})}}
SECRET = {"users": {"frankie": ("secret", EVERYTHING)}}
# Two bytes before a value, where there should be one, look like another number.
MISREAD = {"offset": (1.0, 2.0, 0.0), "data_store_kind": b"d1"}


@pytest.mark.parametrize(
    ("options", "settings", "words"),
    [
        ({"protocol": "9MTX"}, {}, ("9MTX", "5MTX", "6MTX")),
        ({"clients": 0}, {}, ("too many clients",)),
        (LIMITED, {"lists_patience": 0.3}, ("ratioDrive", "Movement", "frankie")),
        (SECRET, {"password": "wrong"}, ("password", "user")),
        (SECRET, {"password": "secret", "user": "nobody"}, ("password", "user")),
        (MISREAD, {}, ("differ by 10.00 m", "DataStore")),
        ({}, {"arcl": "wrong"}, ("text interface", "password", "MobilePlanner")),
    ],
)
def test_a_base_that_cannot_be_commanded(options, settings, words):
    with OmronEmulator(Options(**options)) as emulator:
        refused(base_of(emulator, **settings), *words)


def test_a_base_with_a_password():
    with (
        OmronEmulator(Options(**SECRET)) as emulator,
        connected(emulator, password="secret") as base,
    ):
        assert base.read().faults == ()


def test_a_base_in_its_dock():
    with OmronEmulator() as emulator:
        with emulator.held() as controller:
            controller.dock()
        refused(base_of(emulator), "'Dock'", "undock")


@pytest.mark.parametrize(("speed", "who"), [(SPEED, "somebody else"), (0.0, "another program")])
def test_a_base_that_somebody_else_commands(speed, who):
    with (
        OmronEmulator() as emulator,
        connected(emulator) as first,
        repeating(lambda: first.send(np.array([speed, 0.0, 0.0]))),
    ):
        until(lambda: emulator.controller.mode == "Drive" and first.read().twist[0] >= 0.7 * speed)
        refused(base_of(emulator), "'Drive'", who)


def test_a_base_that_somebody_has_left_in_a_mode_is_taken():
    with OmronEmulator() as emulator:
        with emulator.held() as controller:
            controller.ratio_drive(0.0, 0.0, 100.0, 0.0)
        with connected(emulator) as base:
            assert base.read().faults == ()
            assert emulator.controller.mode == "Stop"


def test_a_second_client_of_the_text_interface_is_told_why_it_gets_none():
    with (
        OmronEmulator(as_reported=("one-arcl-client",)) as emulator,
        connected(emulator, arcl="adept"),
        pytest.raises(HardwareError, match="close other programs that use ARCL"),
    ):
        base_of(emulator, arcl="adept").connect()


def test_the_settings_of_the_base_are_read_by_its_text_interface():
    options = Options(teleop=Teleop(timeout=0.3))
    made = OmronEmulator(options, as_reported=["full-scale-lower"])
    with made as emulator, connected(emulator, arcl="adept") as base:
        assert base.read_teleop()["Timeout"] == 0.3
        told = base.read_site()
        assert told == Site(forward=0.67, turn_at_forward_deg=25.0, turn_at_reverse_deg=25.0)
    with (
        OmronEmulator() as emulator,
        connected(emulator) as base,
        pytest.raises(HardwareError, match="only ARCL tells them"),
    ):
        base.read_teleop()
