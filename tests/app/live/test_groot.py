"""The Groot2 endpoint, asked byte for byte by a real client while a real tree runs."""

import json
import struct
import time
from dataclasses import replace
from xml.etree import ElementTree

import pytest
from groot_client import PORT, Client, Nothing, ServedTree
from py_trees.common import Status
from sample_run import STATUSES, TREE, snapshot

from app.live.groot import GrootError, GrootServer
from app.live.groot.protocol import code
from app.live.operator import Control, Hook, HookAction, Side

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


def wait_for(condition) -> None:
    deadline = time.monotonic() + 5.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_the_tree_comes_with_numbers_and_models(client):
    _, text = client.ask(b"T")
    root = ElementTree.fromstring(text)
    assert root.attrib == {"BTCPP_format": "4", "main_tree_to_execute": "demo"}
    tree = root.find("BehaviorTree")
    assert tree.get("ID") == "demo"
    nodes = [element for element in tree.iter() if element is not tree]
    assert [int(node.get("_uid")) for node in nodes] == list(range(1, len(TREE) + 1))
    assert [node.get("name") for node in nodes] == [node.name for node in TREE]
    models = {model.get("ID"): model.tag for model in root.find("TreeNodesModel")}
    assert {node.tag for node in nodes} == set(models)
    assert models["Sequence"] == "Control"
    assert models["RetryUntilSuccessful"] == "Decorator"
    assert models["navigate"] == "Action"
    assert models["until"] == "Control"
    for node in nodes:
        if models[node.tag] == "Decorator":
            assert len(node) == 1


def test_statuses_are_three_bytes_a_node(served, client):
    assert client.ask(b"S")[1] == b"".join(
        struct.pack("<HB", uid, 0) for uid in range(1, len(TREE) + 1)
    )
    codes = {Status.INVALID: 0, Status.RUNNING: 1, Status.SUCCESS: 2, Status.FAILURE: 3}
    served.server.show(snapshot(0), {})
    body = client.ask(b"S")[1]
    assert body == b"".join(
        struct.pack("<HB", uid, codes[status]) for uid, status in enumerate(STATUSES[0][1], 1)
    )
    assert body[:3] == b"\x01\x00\x01"


def test_a_node_that_became_idle_says_what_it_was(served, client):
    seen = snapshot(0)
    served.server.show(seen, {})
    idle = replace(
        seen, nodes=tuple(type(node)(Status.INVALID, node.message) for node in seen.nodes)
    )
    served.server.show(idle, {})
    served.server.show(idle, {})
    assert client.ask(b"S")[1][:3] == b"\x01\x00\x0b"  # idle, was running
    assert [code(Status.INVALID, was) for was in (0, 1, 2, 3, 12)] == [0, 11, 12, 13, 12]


def test_the_blackboard_is_message_pack_by_name_of_the_tree(served, client):
    served.server.show(snapshot(0), {"goal distance [m]": 0.25, "odd": {1, 2} - {2}})
    boards = msgpack.unpackb(client.ask(b"B", b"demo;other")[1])
    assert boards == {"demo": {"goal distance [m]": 0.25, "odd": "{1}"}}
    assert msgpack.unpackb(client.ask(b"B", b"")[1]) == boards
    assert msgpack.unpackb(client.ask(b"B", b"other")[1]) == {}


def test_transitions_are_recorded_on_request(served, client):
    served.server.show(snapshot(10), {})
    assert int(client.ask(b"r", b"start")[1]) > 1_700_000_000_000_000
    served.server.show(snapshot(40), {})  # 0.6 s later, after the change in tick 30
    body = client.ask(b"t")[1]
    assert len(body) % 9 == 0
    found = [
        (int.from_bytes(body[i : i + 6], "little"), *struct.unpack("<HB", body[i + 6 : i + 9]))
        for i in range(0, len(body), 9)
    ]
    assert {time for time, _, _ in found} == {600_000}
    assert (600_000, 3, 2) in found  # `recover` succeeded
    assert client.ask(b"t")[1] == b""
    assert len(client.ask(b"r", b"stop")) == 1
    served.server.show(snapshot(60), {})
    assert client.ask(b"t")[1] == b""


def test_a_breakpoint_pauses_is_announced_and_is_unlocked(served, client):
    assert len(client.hook(8)) == 1
    time.sleep(0.2)  # a subscription takes a moment
    assert served.tick(8) is Status.RUNNING
    assert served.control.state.paused
    head, uid = client.notices.recv_multipart()
    assert (head[:2], len(head), uid) == (b"\x02N", 6, b"8")
    assert served.tick(7) is Status.SUCCESS  # the others have none
    client.unlock(8)
    assert not served.control.state.paused
    assert served.tick(8) is Status.SUCCESS
    served.control.resume()
    client.unlock(8, "FAILURE")  # not waiting: nothing to answer
    assert served.tick(8) is Status.RUNNING
    client.unlock(8, "FAILURE", remove=True)
    assert served.tick(8) is Status.FAILURE
    assert served.tick(8) is Status.SUCCESS
    assert json.loads(client.ask(b"D")[1]) == []


def test_a_node_is_replaced(served, client):
    client.hook(8, mode=1, desired_status="FAILURE")
    assert served.tick(8) is Status.FAILURE
    assert not served.control.state.paused
    client.hook(8, mode=1, desired_status="FAILURE", once=True)
    assert served.tick(8) is Status.FAILURE
    assert served.tick(8) is Status.SUCCESS
    wait_for(lambda: json.loads(client.ask(b"D")[1]) == [])


def test_hooks_are_listed_disabled_and_removed(served, client):
    described = [
        {
            "enabled": True,
            "uid": uid,
            "mode": 0,
            "once": False,
            "desired_status": "SKIPPED",
            "position": position,
        }
        for uid, position in ((2, 0), (3, 1))
    ]
    client.ask(b"I", json.dumps(described).encode())
    listed = json.loads(client.ask(b"D")[1])
    assert sorted(listed, key=lambda hook: hook["uid"]) == described
    client.ask(b"X")
    assert [hook["enabled"] for hook in json.loads(client.ask(b"D")[1])] == [False, False]
    assert served.tick(2) is Status.SUCCESS
    client.ask(b"R", json.dumps({"uid": 2, "position": 0}).encode())
    assert [hook["uid"] for hook in json.loads(client.ask(b"D")[1])] == [3]
    client.ask(b"A")
    assert json.loads(client.ask(b"D")[1]) == []


def test_a_silent_client_leaves_no_breakpoints_but_the_robot_stays_paused(served, client):
    client.hook(8)
    client.hook(9)
    served.tick(8)
    served.now += 6.0
    wait_for(lambda: not served.hooks[8].actions)
    assert served.tick(9) is Status.SUCCESS
    assert served.control.state.paused
    client.ask(b"S")
    assert served.tick(9) is Status.RUNNING  # back again, and so are its breakpoints


def test_what_a_person_sets_on_the_page_stays_when_groot_falls_silent(served):
    set_on_page = served.hooks[8].actions
    set_on_page[Side.BEFORE] = HookAction()
    served.now += 6.0
    wait_for(lambda: served.server._client_hooks._silent)
    assert served.hooks[8].actions == {Side.BEFORE: HookAction()}


def test_values_that_are_old_say_so(served, client):
    served.server.show(snapshot(0), {"goal distance [m]": 0.25})
    served.now += 2.0
    board = msgpack.unpackb(client.ask(b"B", b"demo")[1])["demo"]
    assert board == {"goal distance [m]": 0.25, "frozen for [s]": 2.0}


def test_breakpoints_of_the_command_line_outlive_the_client():
    control = Control()
    hooks = [Hook(Nothing(node.name, []), lambda *_: None) for node in TREE]
    hooks[2].actions = {Side.BEFORE: HookAction()}
    with (
        GrootServer("demo", TREE, hooks, control, port=PORT, may_replace=True),
        zmq.Context() as context,
    ):
        client = Client(context)
        client.hook(3, mode=1, desired_status="FAILURE")
        assert hooks[2].actions[Side.BEFORE].replace_with is Status.FAILURE
        client.ask(b"A")
        assert hooks[2].actions == {Side.BEFORE: HookAction()}
        context.destroy(linger=0)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ([b"\x02S"], b"wrong request header"),
        ([b"\x02N\x00\x00\x00\x00"], b"Request not recognized"),
        ([b"\x02R\x00\x00\x00\x00", b'{"uid": 99, "position": 0}'], b"Node ID not found"),
    ],
)
def test_errors_have_the_words_of_behaviortree_cpp(client, parts, message):
    client.socket.send_multipart(parts)
    assert client.socket.recv_multipart() == [b"error", message]
    with pytest.raises(GrootError, match=f"port {PORT} .*--groot2-port"):
        ServedTree()
