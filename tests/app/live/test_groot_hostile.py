"""Groot2's port under garbage: the next good request is answered, nothing is replaced."""

import json
import random
import socket
import struct
import threading
from contextlib import suppress

import pytest
from groot_client import PORT, Client, ServedTree
from py_trees.common import Status
from sample_run import TREE, snapshot

zmq = pytest.importorskip("zmq", reason='needs pip install "frankie-task[groot]"')

LETTERS = b"TSBIRNUDAXrtZ\x00\xff"
DEEP = b"[" * 100_000


def head(letter: bytes) -> bytes:
    return b"\x02" + letter + struct.pack("<I", 1)


def described(**more: object) -> bytes:
    hook = {"uid": 8, "position": 0, "enabled": True, "mode": 0, "once": False}
    return json.dumps(hook | {"desired_status": "SKIPPED"} | more).encode()


GARBAGE = [
    [b""],
    [b"\x02"],
    [b"\x02S\x00\x00\x00\x00\x00"],
    [b"\x02S" * 400_000],
    [head(b"Z")],
    [head(b"N")],
    [head(b"I")],
    [head(b"I"), *([b"x"] * 1000)],
    [head(b"I"), b"\xff\xfe"],
    [head(b"I"), DEEP],
    [head(b"R"), DEEP],
    [head(b"U"), DEEP],
    [head(b"I"), b"null"],
    [head(b"I"), b'"text"'],
    [head(b"I"), b"{}"],
    [head(b"R"), b"17"],
    [head(b"R"), b'{"uid": 99, "position": 0}'],
    [head(b"U"), b'{"uid": 1, "position": 0}'],
    [head(b"I"), b"9" * 100_000],
    [head(b"I"), b"[1, 2]"],
    [head(b"I"), described().replace(b"8", b"1e999")],
    [head(b"I"), described().replace(b"8", b"NaN")],
    [head(b"I"), described(uid=10**400)],
    [head(b"I"), described(uid=8.5)],
    [head(b"I"), described(uid=[8])],
    [head(b"I"), described(position=2)],
    [head(b"I"), described(mode=10**30)],
    [head(b"I"), described(mode=[])],
    [head(b"I"), described(desired_status=["FAILURE"])],
    [head(b"I"), described(desired_status="\ud800")],
    [head(b"I"), described(desired_status="GLORY")],
    [head(b"I"), b"[" + described(uid=1) + b"," + described(uid=999) + b"]"],
    [head(b"R"), b'{"\\ud800": 1}'],
    [head(b"B"), b"\xff"],
]


@pytest.fixture
def served():
    served = ServedTree(may_replace=False)
    with served.server:
        yield served


@pytest.fixture
def client(served):
    with zmq.Context() as context:
        client = Client(context)
        yield client
        context.destroy(linger=0)


def alive(client: Client) -> bool:
    return len(client.ask(b"S")[1]) == 3 * len(TREE)


def test_garbage_is_answered_by_an_error_and_inserts_no_hook(client):
    for parts in GARBAGE:
        client.socket.send_multipart(parts)
        assert client.socket.recv_multipart()[0] == b"error", [part[:40] for part in parts[:2]]
        assert alive(client)
    assert json.loads(client.ask(b"D")[1]) == []


def test_random_messages_leave_the_server_alive(served, client):
    rng = random.Random(0)
    for number in range(300):
        first = rng.choice(
            [head(bytes([rng.choice(LETTERS)])), rng.randbytes(6), rng.randbytes(rng.randrange(20))]
        )
        more = [rng.randbytes(rng.randrange(60)) for _ in range(rng.randrange(3))]
        client.socket.send_multipart([first, *more])
        client.socket.recv_multipart()
        if number % 50 == 0:
            served.server.show(snapshot(number), {"odd": object()})
    assert alive(client)
    assert all(hook.tick_once() is None for hook in served.hooks)


def test_other_peers_and_one_that_sends_too_much_leave_the_server_alive(client):
    with zmq.Context() as context:
        for kind in (zmq.DEALER, zmq.PUSH, zmq.PUB, zmq.SUB, zmq.ROUTER):
            peer = context.socket(kind)
            peer.setsockopt(zmq.LINGER, 0)
            for port in (PORT, PORT + 1):
                peer.connect(f"tcp://127.0.0.1:{port}")
            for parts in ([b""], [b"x"] * 5, [b"", b"x" * 2_000_000], [b"", head(b"I"), DEEP]):
                with suppress(zmq.Again):  # the server hung up on the part before
                    peer.send_multipart(parts, zmq.NOBLOCK) if kind == zmq.DEALER else None
        greedy = Client(context)
        greedy.socket.setsockopt(zmq.RCVTIMEO, 300)
        greedy.socket.send_multipart([head(b"I"), b"x" * 50_000_000])
        with pytest.raises(zmq.Again):
            greedy.socket.recv_multipart()
        assert alive(client)
        context.destroy(linger=0)
    for garbage in (b"GET / HTTP/1.1\r\n\r\n", bytes(100), b"\xff" * 10_000, b"\xff\x00"):
        for port in (PORT, PORT + 1):
            with socket.create_connection(("127.0.0.1", port)) as raw:
                raw.sendall(garbage)
    assert alive(client)


def test_outcomes_are_replaced_only_where_a_person_allowed_it(served, client):
    for mode, status in ((1, "FAILURE"), (1, "SUCCESS")):
        reply = client.hook(8, mode=mode, desired_status=status)
        assert reply[0] == b"error"
        assert b"--groot2-control" in reply[1]
    assert served.tick(8) is Status.SUCCESS
    assert len(client.hook(8)) == 1  # a breakpoint is a pause, as every watcher may have
    assert served.tick(8) is Status.RUNNING
    for status in ("FAILURE", "SUCCESS"):
        assert b"--groot2-control" in client.unlock(8, status)[1]
        assert served.control.state.paused
    client.unlock(8)
    assert served.tick(8) is Status.SUCCESS
    assert not served.control.state.paused


def test_nobody_resumes_after_an_emergency_stop_from_here(served, client):
    control = served.control
    client.hook(8)
    assert served.tick(8) is Status.RUNNING
    control.emergency_stop("pressed", pressed=True)
    client.unlock(8)
    control.emergency_stop("pressed", pressed=False)
    control.acknowledge()
    assert control.emergency_stop("pressed", pressed=False)
    client.unlock(8)
    client.ask(b"A")
    assert control.state.paused
    control.resume()
    assert not control.state.paused


def test_the_loop_never_waits_for_the_port(served, client):
    stop = threading.Event()

    def shout() -> None:
        with zmq.Context() as context:
            peer = context.socket(zmq.DEALER)
            peer.setsockopt(zmq.LINGER, 0)
            peer.connect(f"tcp://127.0.0.1:{PORT}")
            while not stop.is_set():
                try:
                    peer.send_multipart([b"", head(b"T")], zmq.NOBLOCK)
                except zmq.Again:
                    stop.wait(0.001)
            context.destroy(linger=0)

    thread = threading.Thread(target=shout)
    thread.start()
    try:
        for tick in range(100):
            served.server.show(snapshot(tick), {})
            served.tick(1 + tick % len(TREE))
        assert alive(client)
    finally:
        stop.set()
        thread.join()
