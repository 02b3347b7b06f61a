"""The control page over real HTTP: what it serves, what it does, and whom it refuses."""

import http.client
import http.server
import json
from collections.abc import Iterator
from contextlib import contextmanager

import py_trees
import pytest
from py_trees.common import Status
from sample_run import TREE, snapshot

from app.live.nodes import NodeInfo
from app.live.operator import Control
from app.live.operator.hooks import insert_hooks
from app.live.operator.page import ControlPage, Ending, WebViewer
from app.live.operator.page_server import PageError, PageServer
from hw import INJECTABLE


class Client:
    """Talks to one page as a browser would, with headers that a test may spoil."""

    def __init__(self, server: PageServer) -> None:
        self.port, self.token = server.port, server.token

    def ask(
        self, method: str, path: str, **headers: str
    ) -> tuple[int, str, http.client.HTTPMessage]:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=10.0)
        connection.request(method, path, headers={"X-Token": self.token, **headers})
        reply = connection.getresponse()
        body = reply.read().decode()
        connection.close()
        return reply.status, body, reply.headers

    def state(self) -> dict[str, object]:
        status, body, _ = self.ask("GET", "/state")
        assert status == 200
        return json.loads(body)


@pytest.fixture
def control():
    return Control()


@pytest.fixture
def faults():
    return []


@contextmanager
def served(control: Control, tree=TREE, **others) -> Iterator[tuple[Client, PageServer]]:
    with PageServer(_free_port()) as server:
        others = {"inject": print, "clear": print, "address": server.address} | others
        server.serve(ControlPage(control, tree, **others))
        yield Client(server), server


@pytest.fixture
def server(control, faults):
    with served(control, inject=faults.append, clear=faults.clear) as (_, server):
        yield server


@pytest.fixture
def page(server):
    return server.page


@pytest.fixture
def client(server):
    return Client(server)


def _free_port() -> int:
    with http.server.HTTPServer(("127.0.0.1", 0), http.server.BaseHTTPRequestHandler) as probe:
        return probe.server_port


def test_buttons_do_what_they_say(server, client, control):
    assert client.state()["paused"] is False
    for path, paused in (("/pause", True), ("/resume", False), ("/step", True), ("/next", False)):
        status, body, _ = client.ask("POST", path)
        assert status == 200
        assert json.loads(body)["paused"] is paused
    for host in server.hosts:
        assert client.ask("POST", "/pause", Host=host, Origin=f"http://{host}")[0] == 200
    client.ask("POST", "/stop")
    assert control.stopped
    with pytest.raises(PageError, match=f"--control-port {server.port}.*in use"):
        PageServer(server.port)


def test_faults_are_injected_and_cleared(client, faults):
    offered = client.state()["injectable"]
    for name in offered:
        assert client.ask("POST", f"/fault/{name.replace(' ', '%20')}")[0] == 200
    assert faults == offered == [name for name, one in INJECTABLE.items() if not one.of_world]
    client.ask("POST", "/clear")
    assert faults == []


@pytest.mark.parametrize(
    "headers",
    [
        {"X-Token": "guessed"},
        {"Host": "evil.example:{port}"},
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1:1"},
    ],
)
@pytest.mark.parametrize(("method", "path"), [("POST", "/pause"), ("GET", "/state")])
def test_whoever_has_no_token_or_comes_from_elsewhere_is_refused(
    server, control, headers, method, path
):
    spoilt = {name: value.format(port=server.port) for name, value in headers.items()}
    status, body, _ = Client(server).ask(method, path, **spoilt)
    assert status == 403
    assert "ticks" not in body
    assert not control.state.paused


def test_an_unknown_action_and_an_unknown_file_are_not_found(client):
    for method, path in (("POST", "/fault/flood"), ("GET", "/page.py"), ("GET", "/viewer/x.js")):
        assert client.ask(method, path)[0] == 404


def test_every_answer_forbids_the_browser_to_go_anywhere_else(client):
    for path in ("/", "/page.js", "/view.js", "/page.css", "/state", "/nothing"):
        _, _, headers = client.ask("GET", path)
        policy = headers["Content-Security-Policy"]
        assert policy.startswith("default-src 'none'")
        assert "connect-src 'self';" in policy
        assert "frame-ancestors 'none'" in policy
        assert headers["X-Content-Type-Options"] == "nosniff"
    assert client.token not in client.ask("GET", "/")[1]


def test_the_viewer_is_served_at_home_dark_and_may_only_talk_to_its_data(control):
    viewer = WebViewer(data="rerun+http://127.0.0.1:9876/proxy")
    with served(control, viewer=viewer) as (client, _):
        path = client.state()["viewer"]
        source = "rerun%2Bhttp%3A%2F%2F127.0.0.1%3A9876%2Fproxy"
        assert path == f"/viewer/?url={source}&theme=dark&hide_welcome_screen=1"
        status, body, headers = client.ask("GET", path)
        assert status == 200
        assert "fonts.googleapis.com" not in body
        policy = headers["Content-Security-Policy"]
        assert "connect-src 'self' http://127.0.0.1:9876;" in policy
        assert "https:" not in policy
        assert "wasm_bindgen" in client.ask("GET", "/viewer/re_viewer.js")[1]
        assert client.ask("GET", "/viewer/missing.js")[0] == 404
        assert client.ask("GET", "/viewer/../secret")[0] == 404


class Waiting:
    """A tree with hooks on all nodes, ticked by a test."""

    def __init__(self, control: Control) -> None:
        self.leaves = [py_trees.behaviours.Running(name="first"), py_trees.behaviours.Success("b")]
        root = py_trees.composites.Sequence("root", memory=True, children=list(self.leaves))
        nodes = [root, *self.leaves]
        self.root, self.hooks = insert_hooks(
            root, nodes, lambda hook, side, action: control.pause(hook.name)
        )
        self.tree = [
            NodeInfo(name=node.name, kind="", depth=int(node is not root)) for node in nodes
        ]


@pytest.fixture
def waiting(control):
    return Waiting(control)


@pytest.fixture
def hooked(control, waiting):
    with served(control, waiting.tree, hooks=waiting.hooks, may_force=True) as (client, _):
        yield client


def test_a_breakpoint_is_set_and_removed(hooked, waiting, control):
    client = hooked
    client.ask("POST", "/break/1")
    assert client.state()["breaks"] == [1]
    waiting.root.tick_once()
    assert control.state.paused
    assert client.state()["waiting"] == 1
    client.ask("POST", "/unbreak/1")
    client.ask("POST", "/resume")
    waiting.root.tick_once()
    state = client.state()
    assert (state["breaks"], state["waiting"], state["paused"]) == ([], None, False)


def test_an_outcome_is_forced_on_what_runs_and_on_what_comes(hooked, waiting, control):
    with served(control, waiting.tree, hooks=waiting.hooks) as (client, _):
        assert client.state()["can_force"] is False
        assert client.ask("POST", "/force/1/success")[0] == 404
    client = hooked
    waiting.root.tick_once()
    client.ask("POST", "/force/2/failure")
    client.ask("POST", "/force/1/success")
    waiting.root.tick_once()
    assert [leaf.status for leaf in waiting.leaves] == [Status.SUCCESS, Status.FAILURE]
    assert waiting.leaves[0].feedback_message == "success forced by a person"
    assert waiting.root.status is Status.FAILURE


def test_a_motion_waits_until_a_person_approves_and_fails_if_refused(hooked, waiting, control):
    client = hooked
    waiting.hooks[1].asks = True
    waiting.root.tick_once()
    assert waiting.leaves[0].status is Status.INVALID, "it has not begun"
    assert client.state()["approve"] == "first"
    client.ask("POST", "/approve/1")
    waiting.root.tick_once()
    assert waiting.leaves[0].status is Status.RUNNING
    waiting.root.stop(Status.INVALID)
    waiting.root.tick_once()
    client.ask("POST", "/refuse/1")
    assert not control.state.paused
    waiting.root.tick_once()
    assert waiting.leaves[0].status is Status.FAILURE


def test_the_history_of_a_node_is_told(page, client):
    for tick in (0, 30, 180):
        page.show(snapshot(tick))
    status, body, _ = client.ask("GET", "/history?node=4")
    assert status == 200
    assert [(one["time"], one["status"]) for one in json.loads(body)] == [(0.6, "failure")]
    assert json.loads(client.ask("GET", "/history?node=99")[1]) == []
    titles = [node["title"] for node in json.loads(client.ask("GET", "/tree")[1])["nodes"]]
    assert titles == [node.title for node in TREE]
    looks = client.state()["looks"]
    assert client.state()["time"] == "3.6 s"
    assert (looks[1], looks[4], looks[8]) == ("running", "not yet", "success")


def test_a_run_that_is_over_stays_with_outcome_explanation_and_recording(
    page, client, control, tmp_path
):
    recording = tmp_path / "recording.rrd"
    recording.write_bytes(b"RRF2 and more")
    page.end(Ending(outcome="toy failed", explanation="because", recording=recording))
    over = client.state()["over"]
    assert (over["outcome"], over["explanation"]) == ("toy failed", "because")
    assert "theme=dark" in over["viewer"]
    assert client.ask("GET", page.recording_path)[:2] == (200, "RRF2 and more")
    assert client.ask("POST", "/pause")[0] == 404
    assert not control.state.paused
    recording.unlink()
    assert client.ask("GET", page.recording_path)[0] == 404
