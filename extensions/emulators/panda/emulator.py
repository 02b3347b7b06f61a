"""Server of the emulated Panda: both ports, the 1 kHz clock, and faults of the line."""

from __future__ import annotations

import random
import struct
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from pinocchio import SE3

from controller import robot_model
from drivers.panda import LIMITS, Mode
from extensions.emulators.common import chosen
from extensions.emulators.panda import wire
from extensions.emulators.panda.emulated_arm import EmulatedArm
from extensions.emulators.panda.emulated_hand import EmulatedHand
from extensions.emulators.panda.joints_and_fingers import OPENING, PERIOD, Fingers, Joints
from extensions.emulators.panda.port import Connection, Request
from extensions.emulators.panda.reported import AS_REPORTED
from extensions.emulators.panda.wire import (
    Command,
    HandCommand,
    HandStatus,
    MotionCommand,
    MoveStatus,
)
from hw import stopwatch

_HAND_EVERY, _SELDOM = 20, 100  # arm states per hand state, and the same as reported
_BURST_EVERY, _BURST = 2000, 30  # interval and length of bursts of lost packets [ms], as reported
_SLOW, _OTHER_VERSION = 0.001, 10  # delay of a slow line [s], and version of an FR3, as reported
_TEMPERATURE = 30
_LEAST = 0.9 * PERIOD  # a commander with less time to answer is excused [s]
_MOST_MISSED = 200  # longest time that the clock makes up for [ms]


@dataclass
class Line:
    """Faults of the line, in both directions."""

    dropped: float = 0.0  # fraction of the packets that are lost
    delayed: float = 0.0  # fraction of the packets that are late
    delay: float = 0.005  # of late packets [s]
    unplugged_until: float = 0.0  # nothing arrives until then [s of `stopwatch`]
    random: random.Random = field(default_factory=lambda: random.Random(0))

    def carry(
        self, packets: Iterable[bytes], now: int, late: list[tuple[int, bytes]]
    ) -> tuple[list[bytes], bool]:
        """The packets that arrive now [ms], `late` ones first; whether one was lost or delayed."""
        arrived, took = [packet for due, packet in late if due <= now], False
        late[:] = [one for one in late if one[0] > now]
        for packet in packets:
            if self.random.random() < self.dropped:
                took = True
            elif self.random.random() < self.delayed:
                took = True
                late.append((now + round(self.delay / PERIOD), packet))
            else:
                arrived.append(packet)
        return arrived, took


class PandaServer:
    """One emulated Panda with its hand."""

    def __init__(
        self,
        host: str,
        joints: Joints,
        fingers: Fingers,
        version: int = wire.VERSION,
        reported: Sequence[str] = (),
    ) -> None:
        self._reported = names = chosen(reported, AS_REPORTED, "arm and hand")
        self.arm, self.hand = EmulatedArm(joints, LIMITS, names), EmulatedHand(fingers, names)
        self.line = Line(delayed=1.0, delay=_SLOW) if "slow-line" in names else Line()
        self._hand_every = _SELDOM if "slow-hand" in names else _HAND_EVERY
        self.frozen_at = self.frozen_until = 0.0  # the whole robot, of `stopwatch` [s]
        self.missed = 0  # milliseconds that were made up for, without counting lost packets
        self._version = _OTHER_VERSION if "wrong-version" in names else version
        self._arm_port = Connection(host, wire.PORT, wire.HEADER)
        self._hand_port = Connection(host, wire.HAND_PORT, wire.HAND_HEADER)
        for port in (self._arm_port, self._hand_port):
            port.is_blocked = "udp-blocked" in names
        self._move: Request | None = None
        self._recovery: Request | None = None
        self._grip: Request | None = None
        self._sent, self._state_taken = 0.0, False
        self._late_commands: list[tuple[int, bytes]] = []
        self._late_states: list[tuple[int, bytes]] = []
        self._model, self._nowhere = robot_model("frankie"), SE3.Identity()
        self._from_foot = self._model.description.bTa.inverse()

    @property
    def still(self) -> float:
        """How long the joints were commanded to rest; a frozen robot is at rest [s]."""
        now = stopwatch()
        return now - self.frozen_at if now < self.frozen_until else self.arm.still * PERIOD

    @property
    def has_commander(self) -> bool:
        """Whether a client is connected to the arm."""
        return self._arm_port.has_client

    def run(self, is_over: Callable[[], bool], each: Callable[[], None] = lambda: None) -> None:
        """Run until `is_over`; `each` is called once a millisecond."""
        due = stopwatch()
        while not is_over():
            each()
            now = stopwatch()
            missed = int((now - due) / PERIOD)
            if now < self.frozen_until or missed > _MOST_MISSED:
                due, missed = now, 0
            self.missed += missed
            if now >= self.frozen_until:
                self.tick(now, excused=now - self._sent < _LEAST)
                for _ in range(missed):
                    self.tick(now, excused=True)
            due += (1 + missed) * PERIOD
            time.sleep(max(0.0, due - stopwatch()))

    def close(self) -> None:
        """Close the ports."""
        self._arm_port.close()
        self._hand_port.close()

    def tick(self, now: float, *, excused: bool = False) -> None:
        """Advance by one millisecond."""
        line_works = now >= self.line.unplugged_until
        if line_works:
            self._serve()
        is_lost = "lost-bursts" in self._reported and self.arm.number % _BURST_EVERY < _BURST
        command, taken = self._command(line_works and not is_lost)
        self.arm.tick(command, excused=excused and not (taken or self._state_taken))
        self._state_taken = False
        if self._arm_port.is_listened_to and line_works:
            states, self._state_taken = self.line.carry(
                [self._state()], self.arm.number, self._late_states
            )  # the commander cannot answer in time to what is late
            for state in states:
                self._arm_port.send_state(state)
            self._sent = stopwatch()
        if self._move is not None and self.arm.ended is not None:
            # after the state that shows it
            self._arm_port.answer(self._move, bytes([self.arm.ended]))
            self._move = self.arm.ended = None
        if self._recovery is not None and self.arm.recovered:
            self._arm_port.answer(self._recovery, bytes([wire.SUCCESS]))
            self._recovery = None
        self.arm.recovered = False
        self._tick_hand(line_works)

    def _serve(self) -> None:
        for request in self._arm_port.requests():
            try:
                self._do(request)
            except struct.error:  # of a wrong length
                self._arm_port.drop()
        if not self._arm_port.has_client:
            self._move = self._recovery = None
            self.arm.commander_left()

    def _do(self, request: Request) -> None:
        arm, port = self.arm, self._arm_port
        if request.command == Command.CONNECT:
            version, states_to = wire.CONNECT.unpack(request.payload)
            good = version == self._version
            port.answer(request, wire.CONNECTED.pack(not good, self._version))
            if good:
                port.send_states_to(states_to)
        elif request.command == Command.MOVE:
            controller, generator, *_ = wire.MOVE.unpack(request.payload)
            possible = (controller, generator) == (wire.JOINT_IMPEDANCE, wire.JOINT_VELOCITY)
            status = arm.begin_motion() if possible else MoveStatus.INVALID_ARGUMENT
            port.answer(request, bytes([status]))
            if status is MoveStatus.STARTED:
                self._move = request
        elif request.command == Command.STOP_MOVE:
            arm.stop_motion()
            port.answer(request, bytes([wire.SUCCESS]))
        elif request.command == Command.AUTOMATIC_ERROR_RECOVERY:
            if arm.recover():
                self._recovery = request
            else:
                needs = wire.MANUAL_RECOVERY if arm.errors else wire.NOT_POSSIBLE
                port.answer(request, bytes([needs]))
        elif request.command == Command.LOAD_MODEL_LIBRARY:
            port.answer(request, bytes([wire.NOT_POSSIBLE]))
        elif request.command == Command.GET_CARTESIAN_LIMIT:
            port.answer(request, bytes(1 + 24 + 128 + 1))
        else:
            is_busy = arm.mode is Mode.MOVE or arm.needs_recovery
            port.answer(request, bytes([wire.NOT_POSSIBLE if is_busy else wire.SUCCESS]))

    def _command(self, line_works: bool) -> tuple[MotionCommand | None, bool]:
        """The answer to the newest state, if it has arrived; whether the line took one."""
        number, packets = self.arm.number, list(self._arm_port.packets())
        arrived, took = self.line.carry(packets if line_works else (), number, self._late_commands)
        commands = filter(None, map(wire.read_motion, arrived))
        newest = next((one for one in commands if one.number == number), None)
        return newest, took or (bool(packets) and not line_works)

    def _state(self) -> bytes:
        arm = self.arm
        q = arm.joints.q
        foot_to_tool = self._from_foot * self._model.end_effector(self._nowhere, np.array(q))
        return wire.pack_state(
            arm.number,
            tuple(foot_to_tool.homogeneous.T.flat),
            (q, arm.joints.qd, arm.q_d, arm.qd_d, arm.qdd_d),
            arm.flags(arm.errors),
            arm.flags(arm.last_errors),
            arm.mode,
            arm.success_rate if arm.mode is Mode.MOVE else 0.0,
        )

    def _tick_hand(self, line_works: bool) -> None:
        hand, port = self.hand, self._hand_port
        if line_works:
            for request in port.requests():
                try:
                    self._do_with_hand(request)
                except (struct.error, ValueError, TypeError):
                    port.drop()
        if not port.has_client:
            self._grip = None
        status = hand.tick()
        if status is not None and self._grip is not None:
            port.answer(self._grip, wire.HAND_STATUS.pack(status))
            self._grip = None
        if line_works and hand.number % self._hand_every == 0:
            port.send_state(
                wire.HAND_STATE.pack(
                    hand.number // self._hand_every,
                    hand.fingers.width,
                    OPENING if hand.is_homed else 0.0,
                    hand.is_grasped,
                    _TEMPERATURE,
                )
            )

    def _do_with_hand(self, request: Request) -> None:
        hand, port, size = self.hand, self._hand_port, len(request.payload) // 8
        if request.command == HandCommand.CONNECT:
            version, states_to = wire.CONNECT.unpack(request.payload)
            good = version == wire.HAND_VERSION
            port.answer(request, wire.HAND_CONNECTED.pack(not good, wire.HAND_VERSION))
            if good:
                port.send_states_to(states_to)
            return
        if request.command == HandCommand.STOP and not hand.stop():
            return
        if self._grip is not None:
            port.answer(self._grip, wire.HAND_STATUS.pack(HandStatus.ABORTED))
            self._grip = None
        if request.command == HandCommand.STOP:
            port.answer(request, wire.HAND_STATUS.pack(HandStatus.SUCCESS))
            return
        arguments = np.frombuffer(request.payload, "<f8", size)
        status = hand.begin(HandCommand(request.command), tuple(map(float, arguments)))
        if status is None:
            self._grip = request
        else:
            port.answer(request, wire.HAND_STATUS.pack(status))
