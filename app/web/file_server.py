"""Serves the Rerun web viewer and a recording from a process of its own.

What browsers ask for then takes no time from the control loop: the processes share no lock.
"""

import shutil
import socket
import subprocess
import sys
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

from app.web.ports import listening
from app.web.viewer_files import ANCESTORS, read_file, viewer_policy

RECORDING = "recording.rrd"
_PATIENCE = 10.0  # a client that says or takes nothing for so long is disconnected [s]


class FileServer:
    """Serves from construction to `close`.

    `recording` is served beside the viewer, whose page may connect to `hosts`. `port` None takes
    the usual one, or a free one if that is taken. Raises OSError: the port is not available, or the
    process cannot be started.
    """

    def __init__(
        self,
        host: str,
        port: int | None,
        usual: int,
        *,
        recording: Path | None = None,
        hosts: str = "'self'",
    ) -> None:
        with listening(host, port, usual) as listener:
            self.port = int(listener.getsockname()[1])
            words = (str(listener.fileno()), hosts, str(recording or ""))
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "app.web.file_server", *words],
                stdin=subprocess.PIPE,
                pass_fds=(listener.fileno(),),
                start_new_session=True,  # Ctrl-C is for this process
            )

    def close(self) -> None:
        """Stop serving."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.terminate()
        self._process.wait()


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, listener: socket.socket, hosts: str, recording: Path | None) -> None:
        super().__init__(listener.getsockname(), _Request, bind_and_activate=False)
        self.socket.close()
        self.socket, self.hosts, self.recording = listener, hosts, recording

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore a browser that disconnects in the middle of a reply."""


class _Request(BaseHTTPRequestHandler):
    server: _Server
    timeout = _PATIENCE

    def do_GET(self) -> None:
        name = self.path.partition("?")[0].partition("#")[0].removeprefix("/") or "index.html"
        recording = self.server.recording
        if name == RECORDING and recording is not None:
            with recording.open("rb") as file:
                self._head("application/octet-stream", recording.stat().st_size)
                shutil.copyfileobj(file, self.wfile)
            return
        try:
            found = read_file(name)
        except Exception:  # whatever it is, the next request is answered
            self.send_error(HTTPStatus.BAD_GATEWAY)
            return
        if found is None:
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        content, kind = found
        self._head(kind, len(content))
        self.wfile.write(content)

    def _head(self, kind: str, length: int) -> None:
        self.send_response(HTTPStatus.OK)
        policy = f"{viewer_policy(self.server.hosts)}; frame-ancestors {ANCESTORS}"
        for name, value in (
            ("Content-Length", str(length)),
            ("Content-Type", kind),
            ("Content-Security-Policy", policy),
            ("X-Content-Type-Options", "nosniff"),
            ("Referrer-Policy", "no-referrer"),
            ("Cache-Control", "no-store"),
        ):
            self.send_header(name, value)
        self.end_headers()

    def log_message(self, format: str, *arguments: object) -> None:
        """Log nothing: the terminal shows the run."""


if __name__ == "__main__":  # serve until standard input ends, as when its parent is gone
    _file, _hosts, _recording = sys.argv[1:]
    _listener = socket.socket(fileno=int(_file))
    _server = _Server(_listener, _hosts, Path(_recording) if _recording else None)
    Thread(target=_server.serve_forever, daemon=True).start()
    sys.stdin.read()
