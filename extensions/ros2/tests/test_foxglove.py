"""A live run, watched and paused over WebSocket by a client that knows nothing of it."""

import json
import socket
import struct
import threading
from importlib.resources import files
from types import SimpleNamespace

import pytest
from command_line import call
from mcap_ros2.decoder import DecoderFactory
from waiting import until
from websockets.sync.client import connect

from app.choices import Speed
from app.core import RunOptions, run_task
from app.web import choose_port
from extensions.ros2.run_messages import TOPICS

TASK = """\
task: a
poses:
  near: {xyz: [1.2, 0.4, 0.7], rpy_deg: [180, 0, 0]}
tree:
  sequence: [{navigate: {to: near}}, {wait: {duration_s: 600}}]
"""


class Client:
    """Subscribes to everything, and decodes with the definitions that it is sent."""

    def __init__(self, url):
        self.socket = connect(url, subprotocols=["foxglove.sdk.v1"], max_size=None)
        self.channels, self.parameters, self.seen = {}, {}, {}
        while not self.channels:
            self.receive()
        ids = [{"id": one, "channelId": one} for one in self.channels]
        self.send(op="subscribe", subscriptions=ids)

    def send(self, **what):
        self.socket.send(json.dumps(what))

    def set(self, **values):
        wanted = [{"name": name, "value": value} for name, value in values.items()]
        self.parameters = {}
        self.send(op="setParameters", id="x", parameters=wanted)
        while not self.parameters:
            self.receive()
        return self.parameters["paused"]

    def receive(self):
        got = self.socket.recv(timeout=20.0)
        if isinstance(got, bytes):
            _, channel, _ = struct.unpack_from("<BIQ", got)
            topic, decode = self.channels[channel]
            self.seen[topic] = decode(got[13:])
            return
        told = json.loads(got)
        if told["op"] == "advertise":
            for one in told["channels"]:
                schema = SimpleNamespace(
                    id=one["id"],
                    name=one["schemaName"],
                    encoding=one["schemaEncoding"],
                    data=one["schema"].encode(),
                )
                decoder = DecoderFactory().decoder_for(one["encoding"], schema)
                self.channels[one["id"]] = one["topic"], decoder
        elif told["op"] == "parameterValues":
            self.parameters |= {one["name"]: one["value"] for one in told["parameters"]}


@pytest.fixture
def run(tmp_path, capfd):
    """Address and token of a run that waits for a client, and its folder."""
    (tmp_path / "task.yaml").write_text(TASK)
    over = threading.Event()
    options = RunOptions(
        tree=tmp_path / "task.yaml",
        scene="single",
        speed=Speed.REAL,
        record=tmp_path / "runs",
        recording=False,
        observers=(f"foxglove:0.0.0.0:{choose_port()}",),
        paused=True,
    )
    thread = threading.Thread(target=run_task, args=(options,), kwargs={"interrupted": over.is_set})
    thread.start()
    said = ""
    while "without a password" not in said and thread.is_alive():
        over.wait(0.1)
        said += capfd.readouterr().err
    words = said[said.index("ws://") :].split()
    yield words[0], words[words.index("pause:") + 1], tmp_path / "runs"
    over.set()
    thread.join(60.0)


@pytest.mark.realtime
def test_a_foreign_client_decodes_a_run_and_pauses_it_with_the_token(run):
    url, token, folder = run
    client = Client(url)
    until(lambda: list(folder.glob("*/events.jsonl")))
    (events,) = folder.glob("*/events.jsonl")
    until(lambda: events.read_text().count('"pause"') == 1)
    assert client.set(token="no", paused=False) is True
    assert {topic for topic, _ in client.channels.values()} == set(TOPICS)
    assert client.set(token=token, paused=False) is False
    while not {"/joint_states", "/tf", "/scene", "/diagnostics", "/goal_pose"} <= set(client.seen):
        client.receive()
    while not any(one.message[:7] == "RUNNING" for one in client.seen["/diagnostics"].status):
        client.receive()  # what it was told first may be of before the first tick
    assert client.seen["/joint_states"].name[0] == "panda_joint1"
    assert len(client.seen["/scene"].markers) > 20
    assert client.set(paused=True) is True
    until(lambda: events.read_text().count('"pause"') == 2)  # a tick has seen it
    while max(map(abs, client.seen["/joint_states"].velocity[:7])) > 1e-3:
        client.receive()
    assert Client(url).set(paused=False) is True  # another client has not shown the token
    assert client.set(paused=False) is False
    while events.read_text().count('"resume"') < 2:  # at the latest after half a second
        client.receive()


def test_what_cannot_be_served_is_told_before_there_is_a_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "999")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        for words in ("ros2", f"foxglove:{port}"):
            code, _, said = call("run", "pick_one", "--record", tmp_path / "runs", "--with", words)
            assert (code, (tmp_path / "runs").exists()) == (2, False), said


def test_the_layout_shows_topics_that_there_are():
    layout = json.loads((files("extensions.ros2") / "layout.json").read_text())
    panels = layout["configById"]
    placed = json.dumps(layout["layout"])
    assert all(f'"{panel}"' in placed for panel in panels)
    text = json.dumps(panels)
    topics = [word for word in text.split('"') if word.startswith("/")]
    assert {word.partition(".")[0] for word in topics} <= set(TOPICS)
