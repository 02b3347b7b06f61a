"""The bytes of the research interface, both ways: as the vendor's library 0.9.2 reads and sends."""

from __future__ import annotations

import os
import socket
import struct
import subprocess
import sys
import threading
import time

from emulated_panda import free_address, needs_library

from hw.emulators.panda import wire
from hw.panda import Mode

POSE = tuple(float(i) for i in range(16))


def joints(first: float) -> tuple[float, ...]:
    return tuple(first + 0.1 * i for i in range(7))


def state(number: int) -> bytes:
    return wire.pack_state(
        number,
        POSE,
        tuple(joints(first) for first in (1.0, 2.0, 3.0, 4.0, 5.0)),
        bytes(name == "joint_reflex" for name in wire.ERRORS),
        bytes(name == "power_limit_violation" for name in wire.ERRORS),
        Mode.REFLEX,
        0.93,
    )


STATE = state(0x0102030405060708)
VELOCITIES = joints(0.1)


def doubles(packet: bytes, place: int, count: int) -> tuple[float, ...]:
    return struct.unpack_from(f"<{count}d", packet, place)


MOTION = (
    bytes.fromhex("0800000000000000")
    + struct.pack("<7d", *joints(0.2))
    + struct.pack("<7d", *VELOCITIES)
)
MOTION += bytes(128 + 48 + 16 + 1) + b"\x01" + bytes(56)


def test_a_motion_command_is_read():
    assert len(MOTION) == 370
    command = wire.read_motion(MOTION)
    assert command == (8, VELOCITIES, True)
    assert wire.read_motion(MOTION[:-1]) is None


class Recorder(threading.Thread):
    """A port that answers a handshake, sends states and keeps what it is sent."""

    def __init__(self, address: str, port: int, answer: bytes, state) -> None:
        super().__init__(daemon=True)
        self._listener = socket.create_server((address, port))
        self._address, self._answer, self._state = address, answer, state
        self.received = b""

    def run(self) -> None:
        client, _ = self._listener.accept()
        with client, self._listener, socket.socket(type=socket.SOCK_DGRAM) as udp:
            self.received = client.recv(64)
            client.sendall(self._answer)
            udp.bind((self._address, 0))
            to = struct.unpack_from("<H", self.received, len(self.received) - 2)[0]
            for number in range(1, 100):
                udp.sendto(self._state(number), ("127.0.0.1", to))
                time.sleep(0.01)


SCRIPT = """
import sys
from hw.panda.library import load_library
library = load_library()
{what}
"""


def ask_library(what: str) -> str:
    """What the real library prints, in a process of its own."""
    path = os.pathsep.join(sys.path)
    return subprocess.run(
        [sys.executable, "-c", SCRIPT.format(what=what)],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=30.0,
        check=True,
    ).stdout


@needs_library
def test_the_real_library_reads_our_state_and_sends_the_handshake_that_we_read():
    address = free_address()
    answer = wire.HEADER.pack(0, 0, 15) + bytes.fromhex("000500")
    recorder = Recorder(address, wire.PORT, answer, state)
    recorder.start()
    text = ask_library(
        f"robot = library.Robot({address!r}, library.RealtimeConfig.kIgnore)\n"
        "s = robot.read_once()\n"
        "print(robot.server_version(), s.q, s.q_d, s.dq, s.dq_d, s.ddq_d, s.robot_mode,\n"
        "      s.current_errors, s.last_motion_errors, s.control_command_success_rate, s.O_T_EE)\n"
    )
    values = [list(joints(first)) for first in (1.0, 3.0, 2.0, 4.0, 5.0)]
    assert text == (
        f"5 {' '.join(map(str, values))} RobotMode.kReflex "
        f'["joint_reflex"] ["power_limit_violation"] 0.93 {list(POSE)}\n'
    )
    # connect, request 0, 16 bytes, version 5, then the port
    assert recorder.received[:14].hex() == "000000000000000010000000" + "0500"
    assert len(recorder.received) == 16


@needs_library
def test_the_real_library_reads_our_hand():
    address = free_address()
    answer = wire.HAND_HEADER.pack(0, 0, 14) + bytes.fromhex("00000300")

    def hand(number: int) -> bytes:
        return wire.HAND_STATE.pack(number, 0.0421, 0.08, True, 31)

    assert hand(7).hex() == "07000000" + struct.pack("<dd", 0.0421, 0.08).hex() + "01" + "1f00"
    recorder = Recorder(address, wire.HAND_PORT, answer, hand)
    recorder.start()
    text = ask_library(
        f"hand = library.Gripper({address!r})\n"
        "s = hand.read_once()\n"
        "print(hand.server_version(), s.width, s.max_width, s.is_grasped, s.temperature)\n"
    )
    assert text == "3 0.0421 0.08 True 31\n"
    assert recorder.received[:12].hex() == "0000" + "00000000" + "0e000000" + "0300"
