"""Peers that send anything: the driver's readings stay sound, the emulator goes on serving."""

import os
import random
import threading

import numpy as np
from emulated import base_of, connected, drive, is_at_rest
from waiting import until

from extensions.emulators.omron import OmronEmulator
from extensions.emulators.omron import client as emulated_client
from extensions.emulators.omron.wire import Writer, seal


def mutated(frame: bytes, rng: random.Random) -> bytes:
    """A frame with a few bytes that are others, none or more, and a checksum that mostly fits."""
    body = bytearray(frame[6:-2])
    for _ in range(rng.randint(0, 3)):
        at = rng.randrange(len(body) + 1)
        body[at : at + rng.randint(0, 2)] = rng.randbytes(rng.randint(0, 3))
    command = int.from_bytes(frame[4:6], "little")
    whole = seal(command, bytes(body))
    return whole if rng.random() < 0.8 else rng.randbytes(rng.randint(0, 60))


def test_a_base_that_babbles_gives_faults_but_no_exception_and_no_nonsense(monkeypatch):
    rng = random.Random(1)
    babbling = threading.Event()
    sound = emulated_client.Client._send

    def send(self, frame, now):
        mad = babbling.is_set() and rng.random() < 0.5
        sound(self, mutated(frame, rng) if mad else frame, now)

    monkeypatch.setattr(emulated_client.Client, "_send", send)
    with OmronEmulator() as emulator:
        base = base_of(emulator)
        base.connect()
        babbling.set()
        for _ in range(60):
            drive(base, seconds=0.01)
            state = base.read()
            assert np.isfinite(state.oTb.homogeneous).all()
            assert np.isfinite(state.twist).all()
            assert state.battery is None or 0.0 <= state.battery <= 1.0
        babbling.clear()
        base.stop()
        until(lambda: is_at_rest(emulator))
        base.close()


def test_ratios_that_are_no_numbers_do_not_move_the_base():
    with OmronEmulator() as emulator, connected(emulator) as base:
        number = base.catalogue.numbers["ratioDrive"]
        for text in ("nan", "INF", "x", ""):
            body = Writer().string(text).string(text).string("100").string("0").body
            base.link._socket.send(seal(number, body))
        until(lambda: len(emulator.heard) == 4)
        assert all(one.is_zero for one in emulator.heard)


def test_connections_leave_no_thread_no_process_and_no_file_behind():
    with OmronEmulator() as emulator:

        def once() -> None:
            with connected(emulator, arcl="adept") as base:
                drive(base, v=0.0, seconds=0.02)
            until(lambda: not emulator.clients and not emulator.text_clients)

        once()
        files, threads = len(os.listdir("/proc/self/fd")), threading.active_count()
        for _ in range(5):
            once()
        assert threading.active_count() <= threads
        assert len(os.listdir("/proc/self/fd")) <= files
