"""The bytes of the research interface, both ways: as the vendor's library 0.9.2 reads and sends."""

import os
import select
import socket
import struct
import subprocess
import sys
import threading
import time

import pytest
from emulated_panda import free_address, needs_library

from drivers.panda import Mode
from extensions.emulators.panda import LaggedJoints, wire
from extensions.emulators.panda.emulator import PandaServer
from extensions.emulators.panda.joints_and_fingers import FreeFingers
from extensions.emulators.panda.wire import Command, HandCommand, HandStatus, MoveStatus
from hw.clock import stopwatch

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


class Recorder(threading.Thread):
    """The port of an arm that answers a handshake, sends states and keeps what it is sent."""

    def __init__(self, address: str) -> None:
        super().__init__(daemon=True)
        self._listener = socket.create_server((address, wire.PORT))
        self._address, self.received = address, b""

    def run(self) -> None:
        client, _ = self._listener.accept()
        with client, self._listener, socket.socket(type=socket.SOCK_DGRAM) as udp:
            self.received = client.recv(64)
            client.sendall(wire.HEADER.pack(0, 0, 15) + bytes.fromhex("000500"))
            udp.bind((self._address, 0))
            to = struct.unpack_from("<H", self.received, len(self.received) - 2)[0]
            for number in range(1, 100):
                udp.sendto(state(number), ("127.0.0.1", to))
                time.sleep(0.01)


SCRIPT = """
import sys
from drivers.panda.library import load_library
library = load_library()
robot = library.Robot(sys.argv[1], library.RealtimeConfig.kIgnore)
s = robot.read_once()
print(robot.server_version(), s.q, s.q_d, s.dq, s.dq_d, s.ddq_d, s.robot_mode,
      s.current_errors, s.last_motion_errors, s.control_command_success_rate, s.O_T_EE)
"""


@needs_library
def test_the_real_library_reads_our_state_and_sends_the_handshake_that_we_read():
    address = free_address()
    recorder = Recorder(address)
    recorder.start()
    text = subprocess.run(
        [sys.executable, "-c", SCRIPT, address],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        stdout=subprocess.PIPE,
        text=True,
        timeout=30.0,
        check=True,
    ).stdout
    values = [list(joints(first)) for first in (1.0, 3.0, 2.0, 4.0, 5.0)]
    assert text == (
        f"5 {' '.join(map(str, values))} RobotMode.kReflex "
        f'["joint_reflex"] ["power_limit_violation"] 0.93 {list(POSE)}\n'
    )
    # connect, request 0, 16 bytes, version 5, then the port
    assert recorder.received[:14].hex() == "000000000000000010000000" + "0500"
    assert len(recorder.received) == 16


class Client:
    """A client of one port of an emulated robot, which goes on while an answer is awaited."""

    def __init__(self, robot: PandaServer, address: str, port: int, header: struct.Struct) -> None:
        self.robot, self.header = robot, header
        self.tcp = socket.create_connection((address, port))
        self.tcp.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # no waiting
        self.udp = socket.socket(type=socket.SOCK_DGRAM)
        self.udp.bind(("127.0.0.1", 0))

    def connect(self, version: int) -> dict[int, int]:
        return self.ask(Command.CONNECT, wire.CONNECT.pack(version, self.udp.getsockname()[1]))

    def ask(self, command: int, payload: bytes = b"") -> dict[int, int]:
        """The status of every answer to a request; none if the connection is closed instead."""
        self.tcp.sendall(self.header.pack(command, 7, self.header.size + len(payload)) + payload)
        return self.answers()

    def answers(self) -> dict[int, int]:
        while not select.select([self.tcp], (), (), 0.0)[0]:
            self.robot.tick(stopwatch())
        data, found = self.tcp.recv(4096), {}
        while data:
            command, number, size = self.header.unpack_from(data)
            assert number == 7
            found[command], data = data[self.header.size], data[size:]
        return found

    def follow(self, qd: float, finished: bool = False) -> None:
        """Answer the newest state with a velocity of joint 7."""
        self.robot.tick(stopwatch())
        packet, sender = self.udp.recvfrom(4096)
        assert packet[-9] == Mode.MOVE
        motion = packet[:8] + bytes(56) + struct.pack("<7d", *(0.0,) * 6, qd) + bytes(193)
        self.udp.sendto(motion + bytes([finished]) + bytes(56), sender)


@pytest.fixture
def clients():
    address = free_address()
    robot = PandaServer(address, LaggedJoints(), FreeFingers())
    arm = Client(robot, address, wire.PORT, wire.HEADER)
    hand = Client(robot, address, wire.HAND_PORT, wire.HAND_HEADER)
    yield robot, arm, hand
    for one in (arm.tcp, arm.udp, hand.tcp, hand.udp, robot):
        one.close()


MOVE = wire.MOVE.pack(wire.JOINT_IMPEDANCE, wire.JOINT_VELOCITY, *(0.0,) * 6)
SETTER = 5
REQUESTS = [
    (Command.MOVE, bytes(wire.MOVE.size), {Command.MOVE: MoveStatus.INVALID_ARGUMENT}),
    (Command.MOVE, MOVE, {Command.MOVE: MoveStatus.STARTED}),
    (Command.MOVE, MOVE, {Command.MOVE: MoveStatus.NOT_POSSIBLE}),
    (SETTER, b"", {SETTER: wire.NOT_POSSIBLE}),
    (Command.STOP_MOVE, b"", {Command.STOP_MOVE: 0, Command.MOVE: MoveStatus.PREEMPTED}),
    (SETTER, b"", {SETTER: wire.SUCCESS}),
    (Command.LOAD_MODEL_LIBRARY, b"", {Command.LOAD_MODEL_LIBRARY: wire.NOT_POSSIBLE}),
    (Command.GET_CARTESIAN_LIMIT, b"", {Command.GET_CARTESIAN_LIMIT: wire.SUCCESS}),
]


def test_the_emulated_arm_answers_every_request(clients):
    robot, arm, _ = clients
    assert arm.connect(4) == {Command.CONNECT: 1}
    assert arm.connect(5) == {Command.CONNECT: 0}
    for command, payload, answers in REQUESTS:
        assert arm.ask(command, payload) == answers
    recover = Command.AUTOMATIC_ERROR_RECOVERY
    robot.arm.reflex("joint_reflex")
    assert arm.ask(recover) == {recover: wire.SUCCESS}
    assert robot.arm.mode is Mode.IDLE
    robot.arm.switch(Mode.USER_STOPPED)
    assert arm.ask(recover) == {recover: wire.NOT_POSSIBLE}
    robot.arm.reflex("self_collision_avoidance_violation")
    assert arm.ask(recover) == {recover: wire.MANUAL_RECOVERY}
    assert arm.ask(Command.MOVE, b"123") == {}
    assert not robot.has_commander


def test_the_emulated_arm_follows_velocities_until_the_motion_or_the_line_ends(clients):
    robot, arm, _ = clients
    arm.connect(5)
    for is_cut, status in ((False, MoveStatus.SUCCESS), (True, MoveStatus.REFLEX_ABORTED)):
        arm.ask(Command.MOVE, MOVE)
        while arm.udp.recv(4096)[-9] != Mode.MOVE:
            pass  # states of the time before
        for qd in (0.002, 0.006, 0.01, 0.012, 0.01, 0.006, 0.002, 0.0, 0.0):
            arm.follow(qd)
        assert robot.arm.seen.speed == pytest.approx(0.012 / 2.61)
        if is_cut:
            robot.line.unplugged_until = stopwatch() + 0.05
        else:
            arm.follow(0.0, finished=True)
        assert arm.answers() == {Command.MOVE: status}
    assert robot.arm.errors == {"communication_constraints_violation"}


def test_the_emulated_hand_answers_every_request(clients):
    robot, _, hand = clients
    assert hand.connect(2) == {HandCommand.CONNECT: 1}
    assert hand.connect(3) == {HandCommand.CONNECT: 0}
    move, grasp, stop = HandCommand.MOVE, HandCommand.GRASP, HandCommand.STOP
    assert hand.ask(move, struct.pack("<2d", 0.03, 0.1)) == {move: HandStatus.SUCCESS}
    assert robot.hand.fingers.width == pytest.approx(0.03)
    assert hand.ask(move, struct.pack("<2d", 0.2, 0.1)) == {move: HandStatus.FAIL}
    nothing = struct.pack("<5d", 0.05, 0.01, 0.01, 0.1, 20.0)
    assert hand.ask(grasp, nothing) == {grasp: HandStatus.UNSUCCESSFUL}
    hand.tcp.sendall(hand.header.pack(HandCommand.HOMING, 7, hand.header.size))
    robot.tick(stopwatch())
    assert hand.ask(stop) == {HandCommand.HOMING: HandStatus.ABORTED, stop: HandStatus.SUCCESS}
    assert hand.ask(move, b"123") == {}
