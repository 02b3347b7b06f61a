"""The control page over real HTTP: what it serves, what it does, and whom it refuses."""

import http.client
import json
import socket
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace

import numpy as np
import py_trees
import pytest
from pinocchio import SE3
from py_trees.common import Status
from sample_run import TREE, moment

from app.live import Control, PoseEstimate
from app.live.hooks import insert_hooks
from app.live.nodes import NodeInfo
from extensions.page.control_page import ControlPage
from extensions.page.observer import PageError, RunPage
from extensions.page.server import PageServer


class Client:
    """Talks to one page as a browser would, with headers that a test may spoil."""

    def __init__(self, server: PageServer) -> None:
        self.port, self.token = server.port, server.token

    def ask(
        self, method: str, path: str, **headers: str
    ) -> tuple[int, str, http.client.HTTPMessage]:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60.0)
        connection.request(method, path, headers={"X-Token": self.token, **headers})
        reply = connection.getresponse()
        body = reply.read().decode()
        connection.close()
        return reply.status, body, reply.headers

    def state(self) -> dict[str, object]:
        status, body, _ = self.ask("GET", "/state")
        assert status == 200
        return json.loads(body)

    def events(self, *kinds: str) -> dict[str, object]:
        """The first server-sent event of each kind."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60.0)
        connection.request("GET", "/events", headers={"X-Token": self.token})
        reply = connection.getresponse()
        assert reply.status == 200
        found = {}
        while not found.keys() >= set(kinds):
            kind, data, _ = (reply.readline().decode().partition(": ")[2] for _ in range(3))
            found.setdefault(kind.strip(), json.loads(data))
        connection.close()
        return found

    def about(self) -> dict[str, object]:
        return self.events("about")["about"]


@pytest.fixture
def control():
    return Control()


@contextmanager
def served(control: Control, tree=TREE, **others) -> Iterator[tuple[Client, PageServer]]:
    with PageServer() as server:
        server.serve(ControlPage(control, tree, **others))
        yield Client(server), server


class Faults(list):
    """Those that are injected."""

    names = ("reflex", "frames lost")
    inject = list.append


@pytest.fixture
def faults():
    return Faults()


@pytest.fixture
def server(control, faults):
    with served(control, injector=faults) as (_, server):
        yield server


@pytest.fixture
def page(server):
    return server.page


@pytest.fixture
def client(server):
    return Client(server)


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
    with pytest.raises(PageError, match=f"--port {server.port}.*in use"):
        PageServer(server.port)


def test_faults_are_injected_and_cleared(client, faults):
    offered = client.about()["injectable"]
    for name in offered:
        assert client.ask("POST", f"/fault/{name.replace(' ', '%20')}")[0] == 200
    assert faults == offered == [*Faults.names]
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
def test_whoever_has_no_token_or_comes_from_elsewhere_is_refused(server, control, headers):
    spoilt = {name: value.format(port=server.port) for name, value in headers.items()}
    for method, path in (("POST", "/pause"), ("GET", "/state")):
        status, body, _ = Client(server).ask(method, path, **spoilt)
        assert status == 403
        assert "ticks" not in body
    assert not control.state.paused


def test_what_was_asked_for_long_ago_is_refused_unless_it_stops(server, client, control):
    long_ago = str(server.seconds() - 6.0)
    for seen in (long_ago, "nan", "yesterday"):
        assert client.ask("POST", "/step", **{"X-Seen": seen})[0] == 409
    assert not control.state.paused
    assert client.ask("POST", "/pause", **{"X-Seen": long_ago})[0] == 200
    assert client.ask("POST", "/stop", **{"X-Seen": long_ago})[0] == 200
    assert control.stopped


def test_every_answer_forbids_the_browser_to_go_anywhere_else(client):
    for path in ("/", "/page.js", "/view.js", "/page.css", "/plan.css", "/state", "/nothing"):
        _, _, headers = client.ask("GET", path)
        policy = headers["Content-Security-Policy"]
        assert policy.startswith("default-src 'none'")
        assert "connect-src 'self';" in policy
        assert "frame-ancestors 'none'" in policy
        assert headers["X-Content-Type-Options"] == "nosniff"
    assert client.token not in client.ask("GET", "/")[1]


def test_the_viewer_is_served_at_home_dark_and_may_only_talk_to_its_data(control):
    with served(control, viewer="rerun+http://127.0.0.1:9876/proxy") as (client, _):
        path = client.about()["viewer"]
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


def test_breakpoints_outcomes_and_approvals_reach_the_hooks_of_their_nodes(control):
    leaves = [py_trees.behaviours.Running(name="first"), py_trees.behaviours.Success("b")]
    root = py_trees.composites.Sequence("root", memory=True, children=list(leaves))
    tree = [NodeInfo(name=one.name, kind="", depth=int(one is not root)) for one in (root, *leaves)]
    root, hooks = insert_hooks(root, [root, *leaves], lambda hook: control.pause(hook.name))
    with served(control, tree, hooks=hooks) as (client, _):
        assert client.about()["can_force"] is False
        assert client.ask("POST", "/force/1/success")[0] == 404
    with served(control, tree, hooks=hooks, may_force=True) as (client, _):

        def tick_after(*paths: str) -> dict[str, object]:
            for path in paths:
                client.ask("POST", path)
            root.tick_once()
            return client.state()

        state = tick_after("/break/1")
        assert (state["breaks"], state["waiting"], state["paused"]) == ([1], 1, True)
        state = tick_after("/unbreak/1", "/resume")
        assert (state["breaks"], state["waiting"], state["paused"]) == ([], None, False)
        tick_after("/force/2/failure", "/force/1/success")
        assert leaves[0].feedback_message == "success forced by a person"
        assert [one.status for one in leaves] == [Status.SUCCESS, root.status]
        assert root.status is Status.FAILURE
        root.stop(Status.INVALID)
        hooks[1].asks = True
        assert tick_after()["approve"] == "first"
        assert leaves[0].status is Status.INVALID, "it has not begun"
        tick_after("/approve/1")
        assert leaves[0].status is Status.RUNNING
        root.stop(Status.INVALID)
        root.tick_once()
        assert tick_after("/refuse/1")["paused"] is False
        assert leaves[0].status is Status.FAILURE
        assert leaves[0].feedback_message == "failure chosen by a person"


def test_events_tell_of_the_tree_the_picture_what_happened_and_how_the_run_ended(page, client):
    for tick in (0, 60, 180):
        page.show(moment(tick))
    told = client.events("about", "state", "picture", "log")
    assert [title for title, *_ in told["about"]["nodes"]] == [node.title for node in TREE]
    state = told["state"]
    assert (state["phase"], state["time"], state["placed"]) == ("running", "3 s", 7)
    assert (state["looks"][1], state["looks"][4], state["looks"][8]) == ("r", "n", "s")
    assert state["purpose"] == ["main", "until empty", "pick", "pick once"]
    assert (state["then"][0], state["otherwise"]) == ("navigate to table", "pick once again")
    assert state["spent"][8] == pytest.approx(2.4)
    assert told["picture"]["url"].startswith("data:image/jpeg;base64,")
    assert [text for _, _, _, text, _ in told["log"]][-1].startswith("▶ grasp")
    page.end("toy failed", "because")
    ended = [client.state()[name] for name in ("phase", "outcome", "explanation")]
    assert ended == ["over", "toy failed", "because"]
    assert client.ask("POST", "/pause")[0] == 404


def test_a_browser_that_was_here_needs_no_token_and_another_host_cannot_use_its_cookie(client):
    _, _, headers = client.ask("POST", "/enter")
    cookie = headers["Set-Cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
    known = {"X-Token": "", "Cookie": cookie.partition(";")[0]}
    assert client.ask("POST", "/pause", **known)[0] == 200
    assert client.ask("POST", "/pause", Origin="http://127.0.0.1:1", **known)[0] == 403
    guessed = known | {"Cookie": f"frankie-task-{client.port}=x"}
    assert client.ask("POST", "/pause", **guessed)[0] == 403


def test_a_page_that_is_served_elsewhere_stops_the_run_whatever_happened_before(control):
    class Failing(Faults):
        def inject(self, name: str) -> None:
            raise RuntimeError(name)

    ours, theirs = socket.socketpair()
    with closing(RunPage(ControlPage(control, TREE, injector=Failing()), theirs, control.stop)):
        told = ours.makefile("r")
        assert "nodes" in json.loads(told.readline())["about"]
        ours.sendall(b"/fault/reflex\n/nonsense\n/pause\n")
        while not json.loads(told.readline())["state"]["paused"]:
            pass
        assert not control.stopped
        told.close()
        ours.close()  # as when the other process was killed
        deadline = time.monotonic() + 10.0
        while not control.stopped:
            assert time.monotonic() < deadline


@pytest.mark.parametrize(
    ("sigma", "line"),
    [(0.012, "±24 mm"), (0.3, "not localised")],
)
def test_the_page_says_how_well_it_is_localised(sigma: float, line: str) -> None:
    page = ControlPage(Control(), TREE)
    seen = moment(0)
    covariance = sigma**2 * np.eye(3)
    estimate = PoseEstimate(np.zeros(3), covariance, SE3.Identity())
    page.show(replace(seen, estimate=estimate))
    assert page.state()["figures"]["on the map"] == line
    page.show(seen)
    assert "on the map" not in page.state()["figures"], "it is exact"
