"""The answers of every HTTP server of this process: files of the viewer, and a recording."""

from __future__ import annotations

import shutil
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from pathlib import Path

from app.live.web.viewer_files import at_home, read_file, viewer_policy


class Replies(BaseHTTPRequestHandler):
    """Answers under a policy that says whom the browser may ask in turn."""

    policy = "default-src 'none'"
    """Of what is not the viewer's."""

    @property
    def asked(self) -> str:
        """What is asked for, without the query."""
        return self.path.partition("?")[0].partition("#")[0]

    def log_message(self, format: str, *arguments: object) -> None:
        """Log nothing: the terminal shows the run."""

    def answer(
        self, body: bytes, kind: str, policy: str = "", status: HTTPStatus = HTTPStatus.OK
    ) -> None:
        """Send a whole answer."""
        self._head(status, kind, len(body), policy or self.policy)
        self.wfile.write(body)

    def refuse(self, status: HTTPStatus) -> None:
        """Say no."""
        self.answer(status.phrase.encode(), "text/plain", status=status)

    def send_viewer(self, name: str, hosts: str, more: str = "") -> None:
        """A file of the viewer, under a policy that keeps it on this machine."""
        try:
            found = read_file(name)
        except Exception:  # whatever it is, the run goes on
            self.refuse(HTTPStatus.BAD_GATEWAY)
            return
        if found is None:
            self.refuse(HTTPStatus.NOT_FOUND)
            return
        content, kind = found
        if name == "index.html":
            content = at_home(content, hosts)
        self.answer(content, kind, viewer_policy(hosts) + more)

    def send_recording(self, path: Path) -> None:
        """A recording, as long as it is there."""
        try:
            with path.open("rb") as file:
                size = path.stat().st_size
                self._head(HTTPStatus.OK, "application/octet-stream", size, self.policy)
                shutil.copyfileobj(file, self.wfile)
        except FileNotFoundError:
            self.refuse(HTTPStatus.NOT_FOUND)

    def _head(self, status: HTTPStatus, kind: str, length: int, policy: str) -> None:
        self.send_response(status)
        for name, value in {
            "Content-Type": kind,
            "Content-Length": str(length),
            "Content-Security-Policy": policy,
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Cache-Control": "no-store",
        }.items():
            self.send_header(name, value)
        self.end_headers()
