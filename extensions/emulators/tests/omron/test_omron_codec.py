"""The bytes of ArNetworking: both codecs, which share no code, against golden frames."""

from math import isfinite, pi

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.omron.handshake import Catalogue, introduction, read_greeting
from drivers.omron.packet import (
    Fields,
    LayoutError,
    Packet,
    PacketStream,
    encode,
    number_field,
    parse_number,
)
from drivers.omron.site import Ratios, Velocity
from drivers.omron.telemetry import POSE, PoseAssembly, Telemetry, drive_payload
from extensions.emulators.omron import wire

GOLDEN = {
    "connected": (5, "", "0f0c080005000005"),
    "shutdown": (1, "", "0f0c080001000001"),
    "rejected": (6, "010000", "0f0c0b0006000100000007"),
    "request every 100 ms": (129, "080164000000", "0f0c0e00810008016400000001ed"),
    "request every 30 ms": (129, "54031e000000", "0f0c0e00810054031e00000003f3"),
    "request on change": (129, "d301ffffffff", "0f0c0e008100d301ffffffff03ad"),
    "request no more": (130, "5403", "0f0c0a008200540300d5"),
    "drive": (278, "3530002d3230003130300030 00", "0f0c150016013530002d323000313030003000ef9d"),
    "drive slowly": (
        534,
        "31322e35002d332e3235003130300030 00",
        "0f0c1900160231322e35002d332e3235003130300030005b3a",
    ),
    "stop": (277, "", "0f0c080015010014"),
    "stop by another number": (537, "", "0f0c08001902001b"),
    "localise": (443, "e803000030f8ffff5a000000", "0f0c1400bb01e803000030f8ffff5a000000fe2c"),
    "numbers": (
        466,
        "6603d2040000d2e9ffff84fffa00f6ff000080",
        "0f0c1b00d2016603d2040000d2e9ffff84fffa00f6ff000080f44f",
    ),
    "localisation": (442, "006a03", "0f0c0b00ba01006a0301d0"),
    "battery once": (266, "", "0f0c08000a01000b"),
}
"""By name: command, payload and frame (hex), of a reference server or by its verified encoder."""

GREETING = "0f0c21000200616c70686100000044332211887766554b337900354d545800678d"
"""INTRODUCTION of a server: key "K3y", protocol "5MTX"."""
INTRODUCTION = (
    "0f0c2600020000006f6d726f6e00257b5b9c239f23cc4477ab030969e7c3354d54580000ad7f0f0c080005000005"
)
"""The answer of user "omron", password "pw", and that no UDP is wanted."""
LIST = "0f0c2a00810002001602726174696f447269766500647269766500190273746f700073746f707300f4f9"
"""LIST of 534 `ratioDrive` and 537 `stop`."""

packets = st.lists(
    st.builds(Packet, st.integers(0, 65535), st.binary(max_size=60)), min_size=1, max_size=8
)


@pytest.mark.parametrize(("command", "payload", "frame"), GOLDEN.values(), ids=GOLDEN)
def test_both_codecs_write_and_read_the_golden_frames(command, payload, frame):
    body, golden = bytes.fromhex(payload), bytes.fromhex(frame)
    assert encode(command, body) == golden
    assert wire.seal(command, body) == golden
    assert PacketStream().feed(golden) == [(command, body)]
    assert wire.Splitter().push(golden) == [(command, body)]


def test_the_greeting_is_answered_with_the_golden_introduction():
    greeting = read_greeting(PacketStream().feed(bytes.fromhex(GREETING))[0])
    assert greeting == ("K3y", "5MTX")
    assert introduction(greeting, "omron", "pw").hex() == INTRODUCTION


def test_numbers_are_looked_up_by_name():
    catalogue = Catalogue()
    (packet,) = PacketStream().feed(bytes.fromhex(LIST))
    assert catalogue.take(packet)
    assert catalogue.numbers["ratioDrive"] == 534
    assert catalogue.command("stop").hex() == GOLDEN["stop by another number"][2]
    slow = drive_payload(Ratios(12.5, -3.25))
    assert catalogue.command("ratioDrive", slow).hex() == GOLDEN["drive slowly"][2]
    catalogue.numbers |= {"pose": 852, "strings": 467}
    assert catalogue.request("pose", 0.03).hex() == GOLDEN["request every 30 ms"][2]
    assert catalogue.request("strings", None).hex() == GOLDEN["request on change"][2]
    assert not catalogue.has("updateNumbers")


def test_the_emulator_writes_the_golden_numbers():
    numbers = wire.Writer().integer(870, 2).integer(1234, 4).integer(-5678, 4).integer(-124, 2)
    numbers.integer(250, 2).integer(-10, 2).integer(0, 2).integer(-128, 1)
    assert wire.seal(466, numbers.body).hex() == GOLDEN["numbers"][2]
    drive = wire.Writer().double(50).double(-20).double(100).double(0)
    assert wire.seal(278, drive.body).hex() == GOLDEN["drive"][2]


def telemetry(**numbers: int) -> Telemetry:
    return Telemetry(Catalogue(numbers=numbers))


def test_the_golden_numbers_are_read():
    base = telemetry(updateNumbers=466, batteryInfo=266, getLocState=442)
    base.take(Packet(266, number_field(20) + number_field(5) + b"\x01"), 0.0)
    for name in ("numbers", "localisation"):
        base.take(*PacketStream().feed(bytes.fromhex(GOLDEN[name][2])), 7.0)
    assert base.battery == pytest.approx(0.87)
    assert base.pose.place == pytest.approx((1.234, -5.678, -124 * pi / 180))
    assert base.pose.at == 7.0
    assert base.velocity == pytest.approx(Velocity(0.25, -10 * pi / 180))
    assert base.localisation == 0
    assert base.score == pytest.approx(0.874)
    other = telemetry(updateNumbers=466, batteryInfo=266, getLocState=442)
    other.take(Packet(266, number_field(24) + number_field(22) + b"\0"), 0.0)  # a voltage
    other.take(Packet(466, bytes.fromhex(GOLDEN["numbers"][1])), 0.0)
    other.take(Packet(442, b"\0\x57\0"), 0.0)  # 87: of 100 or of 1000?
    assert other.battery is None
    assert other.score is None


@given(packets, st.data())
@settings(derandomize=True, deadline=None, max_examples=50)
def test_any_split_of_the_stream_gives_the_same_packets(sent, data):
    stream = b"".join(encode(*packet) for packet in sent)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=12)))
    pieces = [stream[a:b] for a, b in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
    ours, theirs = PacketStream(), wire.Splitter()
    assert stream == b"".join(wire.seal(*packet) for packet in sent)
    assert [packet for piece in pieces for packet in ours.feed(piece)] == sent
    assert [tuple(p) for piece in pieces for p in theirs.push(piece)] == sent
    assert ours.skipped == 0


@given(packets, st.data())
@settings(derandomize=True, deadline=None, max_examples=60)
def test_a_damaged_byte_costs_its_packet_and_no_other_gets_another_content(sent, data):
    frames = [encode(*packet) for packet in sent]
    number = data.draw(st.integers(0, len(sent) - 1))
    victim = frames[number]
    covered = [at for at in range(len(victim)) if at not in (2, 3)]  # the length comes below
    if len(victim) % 2:
        covered.remove(len(victim) - 3)  # the protocol protects it not
    at = data.draw(st.sampled_from(covered))
    flip = data.draw(st.integers(1, 255))
    frames[number] = victim[:at] + bytes((victim[at] ^ flip,)) + victim[at + 1 :]
    got = PacketStream().feed(b"".join(frames))
    assert got == sent[:number] + sent[number + 1 :]


@given(st.binary(max_size=40))
@settings(derandomize=True, deadline=None)
def test_any_payload_is_read_whole_or_not_at_all(payload):
    base = telemetry(
        updateNumbers=466,
        getLocState=442,
        getModeInfo=362,
        **dict(zip(POSE, (7, 8, 9), strict=True)),
    )
    for command in (466, 442, 362, 7, 8, 9):
        base.take(Packet(command, payload), 1.0)
    assert all(isfinite(one) for one in base.velocity)
    if base.pose is not None:
        assert all(map(isfinite, base.pose.place))


def test_numbers_are_read_and_what_is_no_finite_number_is_refused():
    assert parse_number("1e+06") == 1e6
    for value in (0.0, -1.5, 1e-30, 123456e7):
        assert Fields(number_field(value)).number() == wire.Taker(number_field(value)).double()
    for text in ("", "INF", "-INF", "nan", "1e999", "1_000", "12a", "0x10", " 1"):
        with pytest.raises(LayoutError):
            parse_number(text)


@pytest.mark.parametrize(("kind", "space"), [(b"d", b""), (b"\xff", b" "), (b"\x01", b"")])
def test_any_one_byte_may_stand_before_a_value_of_the_data_store(kind, space):
    base = telemetry(**dict(zip(POSE, (7, 8, 9), strict=True)))
    for number, value in ((7, b"1234.5"), (8, b"-5.25e+03"), (9, b"90")):
        base.take(Packet(number, kind + space + value + b"\0"), 3.0)
    assert base.pose.place == pytest.approx((1.2345, -5.25, pi / 2))
    base.take(Packet(7, b"1234.5\0"), 3.0)  # the first byte may be a digit of it
    assert base.damaged == 1


def test_a_pose_is_of_three_values_that_came_together():
    assembly, (x, y, theta) = PoseAssembly(POSE), POSE
    assert assembly.take(x, 1000.0, 1.0) is None
    assert assembly.take(y, 2000.0, 1.001) is None
    pose = assembly.take(theta, 0.0, 1.002)
    assert pose == ((1.0, 2.0, 0.0), 1.0)
    assert assembly.take(x, 9000.0, 1.03) is None  # the two others are late
    assert assembly.take(y, 2000.0, 1.06) is None
    assert assembly.take(theta, 0.0, 1.061) is None  # x is of another moment by now
    pose = assembly.take(x, 3000.0, 1.062)
    assert (pose.place.x, pose.at) == (3.0, 1.06)
