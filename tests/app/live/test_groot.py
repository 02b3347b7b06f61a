"""The Groot2 endpoint, asked byte for byte by a real client while a real tree runs."""

import json
import random
import socket
import struct
import time
from dataclasses import replace
from xml.etree import ElementTree

import pytest
from groot_client import PORT, Client, ServedTree
from py_trees.common import Status
from sample_run import STATUSES, TREE, snapshot
from waiting import until

from app.live.groot import GrootError

msgpack = pytest.importorskip("msgpack", reason='needs pip install "frankie-task[groot]"')
zmq = pytest.importorskip("zmq", reason='needs pip install "frankie-task[groot]"')


@pytest.fixture
def served():
    served = ServedTree()
    with served.server:
        yield served


@pytest.fixture
def client(served):
    with zmq.Context() as context:
        client = Client(context)
        yield client
        context.destroy(linger=0)


def test_the_tree_comes_with_numbers_and_models(client):
    _, text = client.ask(b"T")
    root = ElementTree.fromstring(text)
    assert root.attrib == {"BTCPP_format": "4", "main_tree_to_execute": "demo"}
    tree = root.find("BehaviorTree")
    nodes = [element for element in tree.iter() if element is not tree]
    assert [int(node.get("_uid")) for node in nodes] == list(range(1, len(TREE) + 1))
    assert [node.get("name") for node in nodes] == [node.name for node in TREE]
    models = {model.get("ID"): model.tag for model in root.find("TreeNodesModel")}
    assert {node.tag for node in nodes} == set(models)
    assert models["Sequence"] == "Control"
    assert models["RetryUntilSuccessful"] == "Decorator"
    assert models["navigate"] == "Action"
    assert models["until"] == "Control"
    assert all(len(node) == 1 for node in nodes if models[node.tag] == "Decorator")


def test_statuses_are_three_bytes_a_node_and_an_idle_one_says_what_it_was(served, client):
    codes = {Status.INVALID: 0, Status.RUNNING: 1, Status.SUCCESS: 2, Status.FAILURE: 3}
    seen = snapshot(0)
    served.server.show(seen, {})
    body = client.ask(b"S")[1]
    assert body == b"".join(
        struct.pack("<HB", uid, codes[status]) for uid, status in enumerate(STATUSES[0][1], 1)
    )
    nodes = tuple(node._replace(status=Status.INVALID) for node in seen.nodes)
    for _ in range(2):
        served.server.show(replace(seen, nodes=nodes), {})
    assert client.ask(b"S")[1][:3] == b"\x01\x00\x0b"  # idle, was running


def test_the_blackboard_is_message_pack_by_name_of_the_tree(served, client):
    served.server.show(snapshot(0), {"goal distance [m]": 0.25, "odd": {1, 2} - {2}})
    boards = msgpack.unpackb(client.ask(b"B", b"demo;other")[1])
    assert boards == {"demo": {"goal distance [m]": 0.25, "odd": "{1}"}}
    assert msgpack.unpackb(client.ask(b"B", b"")[1]) == boards
    assert msgpack.unpackb(client.ask(b"B", b"other")[1]) == {}


def test_a_breakpoint_pauses_is_announced_and_is_unlocked(served, client):
    assert len(client.hook(8)) == 1
    time.sleep(0.2)  # a subscription takes a moment
    assert served.tick(8) is Status.RUNNING
    assert served.control.state.paused
    head, uid = client.notices.recv_multipart()
    assert (head[:2], len(head), uid) == (b"\x02N", 6, b"8")
    assert served.tick(7) is Status.SUCCESS  # the others have none
    assert client.unlock(8, "FAILURE")[0] == b"error"  # outcomes are for the page
    assert served.control.state.paused
    client.unlock(8)
    assert not served.control.state.paused
    assert served.tick(8) is Status.SUCCESS
    assert served.tick(8) is Status.RUNNING
    client.unlock(8, remove=True)
    assert [served.tick(8), served.tick(8)] == [Status.SUCCESS, Status.SUCCESS]
    assert json.loads(client.ask(b"D")[1]) == []


def test_breakpoints_are_listed_disabled_and_removed(served, client):
    served.hooks[8].stops = True  # of the command line: no client's business
    for uid in (2, 3, 9):
        client.hook(uid)
    assert [hook["uid"] for hook in json.loads(client.ask(b"D")[1])] == [2, 3, 9]
    client.ask(b"X")
    assert not any(hook["enabled"] for hook in json.loads(client.ask(b"D")[1]))
    assert served.tick(2) is Status.SUCCESS
    client.ask(b"R", json.dumps({"uid": 2, "position": 0}).encode())
    assert [hook["uid"] for hook in json.loads(client.ask(b"D")[1])] == [3, 9]
    client.ask(b"A")
    assert json.loads(client.ask(b"D")[1]) == []
    assert served.tick(9) is Status.RUNNING


def test_a_silent_client_leaves_no_breakpoints_but_the_robot_stays_paused(served, client):
    client.hook(8)
    client.hook(9)
    served.tick(8)
    served.now += 6.0
    until(lambda: not served.hooks[8].groot_stops)
    assert served.tick(9) is Status.SUCCESS
    assert served.control.state.paused
    client.ask(b"S")
    assert served.tick(9) is Status.RUNNING  # back again, and so are its breakpoints


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


def test_a_port_that_is_taken_is_refused(served):
    with pytest.raises(GrootError, match=f"port {PORT} .*--groot2-port"):
        ServedTree()


def head(letter: bytes) -> bytes:
    return b"\x02" + letter + struct.pack("<I", 1)


def described(**more: object) -> bytes:
    hook = {"uid": 8, "position": 0, "enabled": True, "mode": 0, "once": False}
    return json.dumps(hook | more).encode()


ERRORS = [
    ([b"\x02S"], b"wrong request header"),
    ([head(b"N")], b"Request not recognized"),
    ([head(b"R"), b'{"uid": 99, "position": 0}'], b"Node ID not found"),
    ([head(b"I"), described(mode=1)], b"only breakpoints before a node are served"),
    ([head(b"I"), described(position=1)], b"only breakpoints before a node are served"),
    ([head(b"I"), described(uid=[8])], b"Node ID not found"),
    ([head(b"I"), b"[" + described(uid=1) + b"," + described(uid=999) + b"]"], b"Node ID not"),
    ([b""], b""),
    ([head(b"I")], b""),
    ([head(b"I"), *([b"x"] * 1000)], b""),
    ([head(b"U"), b"[" * 100_000], b""),
    ([head(b"I"), b'"text"'], b""),
    ([head(b"I"), b"9" * 100_000], b""),
    ([head(b"B"), b"\xff"], b""),
]


def test_garbage_is_answered_by_an_error_and_sets_no_breakpoint(client):
    for parts, message in ERRORS:
        client.socket.send_multipart(parts)
        reply = client.socket.recv_multipart()
        assert reply[0] == b"error", [part[:40] for part in parts[:2]]
        assert reply[1].startswith(message)
    rng = random.Random(0)
    for _ in range(100):
        first = rng.choice([head(rng.randbytes(1)), rng.randbytes(rng.randrange(20))])
        client.socket.send_multipart([first, rng.randbytes(rng.randrange(60))])
        client.socket.recv_multipart()
    for garbage in (b"GET / HTTP/1.1\r\n\r\n", bytes(100), b"\xff" * 10_000):
        for port in (PORT, PORT + 1):
            with socket.create_connection(("127.0.0.1", port)) as raw:
                raw.sendall(garbage)
    assert len(client.ask(b"S")[1]) == 3 * len(TREE)
    assert json.loads(client.ask(b"D")[1]) == []


def test_a_peer_that_sends_too_much_leaves_the_server_alive(client):
    with zmq.Context() as context:
        greedy = Client(context)
        greedy.socket.setsockopt(zmq.RCVTIMEO, 300)
        greedy.socket.send_multipart([head(b"I"), b"x" * 50_000_000])
        with pytest.raises(zmq.Again):
            greedy.socket.recv_multipart()
        context.destroy(linger=0)
    assert len(client.ask(b"S")[1]) == 3 * len(TREE)
