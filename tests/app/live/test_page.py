"""The control page over real HTTP: what it serves, what it does, and whom it refuses."""

import http.client
import http.server
import json
import threading
from pathlib import Path

import pytest
from sample_run import TREE, snapshot

from app.live.operator import Control
from app.live.operator.page import ControlPage, PageError, WebViewer
from hw import INJECTABLE


class Client:
    """Talks to one page as a browser would, with headers that a test may spoil."""

    def __init__(self, page: ControlPage) -> None:
        self.port, self.token = page.port, page.token

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


@pytest.fixture
def page(control, faults):
    with ControlPage(
        control, TREE, inject=faults.append, clear=faults.clear, port=_free_port()
    ) as page:
        yield page


def _free_port() -> int:
    with http.server.HTTPServer(("127.0.0.1", 0), http.server.BaseHTTPRequestHandler) as probe:
        return probe.server_port


def test_buttons_do_what_they_say(page, control):
    client = Client(page)
    assert client.state()["paused"] is False
    for path, paused in (("/pause", True), ("/resume", False), ("/step", True), ("/next", False)):
        status, body, _ = client.ask("POST", path)
        assert status == 200
        assert json.loads(body)["paused"] is paused
    client.ask("POST", "/stop")
    assert control.stopped


def test_the_state_tells_what_the_tree_does(page, control):
    control.take_turn()
    page.show(snapshot(100))
    state = Client(page).state()
    assert state["ticks"] == 1
    assert state["time"] == 2.0
    assert state["node"] == "navigate to above_container"
    assert state["message"].startswith("2.00 m to go")


def test_faults_are_injected_and_cleared(page, faults):
    client = Client(page)
    offered = client.state()["injectable"]
    for name in offered:
        assert client.ask("POST", f"/fault/{name.replace(' ', '%20')}")[0] == 200
    assert faults == offered == [name for name, one in INJECTABLE.items() if not one.of_world]
    client.ask("POST", "/clear")
    assert faults == []


@pytest.mark.parametrize(
    "headers",
    [
        {"X-Token": ""},
        {"X-Token": "guessed"},
        {"Host": "evil.example"},
        {"Host": "evil.example:{port}"},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1:1"},
    ],
)
@pytest.mark.parametrize(("method", "path"), [("POST", "/pause"), ("GET", "/state")])
def test_whoever_has_no_token_or_comes_from_elsewhere_is_refused(
    page, control, headers, method, path
):
    spoilt = {name: value.format(port=page.port) for name, value in headers.items()}
    status, body, _ = Client(page).ask(method, path, **spoilt)
    assert status == 403
    assert "ticks" not in body
    assert not control.state.paused


def test_its_own_origin_is_welcome_under_both_names(page):
    for host in page.hosts:
        status, _, _ = Client(page).ask("POST", "/pause", Host=host, Origin=f"http://{host}")
        assert status == 200


def test_an_unknown_action_and_an_unknown_file_are_not_found(page):
    client = Client(page)
    for method, path in (("POST", "/fault/flood"), ("GET", "/page.py"), ("GET", "/viewer/x.js")):
        assert client.ask(method, path)[0] == 404


def test_every_answer_forbids_the_browser_to_go_anywhere_else(page):
    client = Client(page)
    for path in ("/", "/page.js", "/page.css", "/state", "/nothing"):
        _, _, headers = client.ask("GET", path)
        policy = headers["Content-Security-Policy"]
        assert policy.startswith("default-src 'none'")
        assert "connect-src 'self';" in policy
        assert "frame-ancestors 'none'" in policy
        assert headers["X-Content-Type-Options"] == "nosniff"
    assert page.token not in client.ask("GET", "/")[1]


def test_the_viewer_passes_through_and_may_only_talk_to_its_data(control):
    class Files(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            body = f"file {self.path}".encode()
            self.send_response(200 if self.path in ("/", "/viewer.js") else 404)
            self.send_header("Content-Type", "text/javascript")
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_: object) -> None: ...

    server = http.server.HTTPServer(("127.0.0.1", 0), Files)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    viewer = WebViewer(
        files=f"http://127.0.0.1:{server.server_port}", data="rerun+http://127.0.0.1:9876/proxy"
    )
    with ControlPage(
        control, TREE, inject=print, clear=print, viewer=viewer, port=_free_port()
    ) as page:
        client = Client(page)
        path = client.state()["viewer"]
        assert path == "/viewer/?url=rerun%2Bhttp%3A%2F%2F127.0.0.1%3A9876%2Fproxy&" + (
            "hide_welcome_screen=1"
        )
        status, body, headers = client.ask("GET", path)
        assert (status, body) == (200, "file /")
        policy = headers["Content-Security-Policy"]
        assert "connect-src 'self' http://127.0.0.1:9876;" in policy
        assert "https:" not in policy
        assert client.ask("GET", "/viewer/viewer.js")[1] == "file /viewer.js"
        assert client.ask("GET", "/viewer/missing.js")[0] == 502
        assert client.ask("GET", "/viewer/../secret")[0] == 404
    server.shutdown()
    server.server_close()


def test_it_listens_on_loopback_alone_and_says_when_a_port_is_taken(page, control):
    rows = [row.split() for row in Path("/proc/net/tcp").read_text().splitlines()[1:]]
    listening = [row[1] for row in rows if row[3] == "0A" and row[1].endswith(f":{page.port:04X}")]
    assert listening == [f"0100007F:{page.port:04X}"]
    assert f":{page.port:04X} 0" not in Path("/proc/net/tcp6").read_text()
    with pytest.raises(PageError, match=f"--control-port {page.port}.*in use"):
        ControlPage(control, TREE, inject=print, clear=print, port=page.port)
