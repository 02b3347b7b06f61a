"""`frankie-task serve` in a process of its own, for tests."""

import http.client
import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

from browsers import FOLDER


class Served:
    """`frankie-task serve` in a folder, until the end of the `with` statement."""

    def __init__(self, folder: Path) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "frankie_task_cli", "serve", str(folder), "--view", "none"],
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONPATH": str(FOLDER)},
        )
        found = re.search(r"http://127\.0\.0\.1:(\d+)/#(\S+)", self.process.stderr.readline())
        self.url, self._port, self._token = found[0], int(found[1]), found[2]

    def __enter__(self) -> "Served":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.communicate(timeout=60.0)

    def ask(self, method: str, path: str, **body: object) -> dict:
        status, answer = self.answer(method, path, json.dumps(body), self._token)
        assert status == 200, path
        return json.loads(answer)

    def answer(self, method: str, path: str, body: str, token: str) -> tuple[int, bytes]:
        connection = http.client.HTTPConnection("127.0.0.1", self._port, timeout=60.0)
        connection.request(method, path, body, {"X-Token": token})
        reply = connection.getresponse()
        return reply.status, reply.read()

    def wait_for(self, phase: str, press: str = "") -> dict:
        deadline = time.monotonic() + 60.0
        while (state := self.ask("GET", "/state"))["phase"] != phase:
            assert time.monotonic() < deadline, state
            if press:
                self.ask("POST", press)
            time.sleep(0.1)
        return state

    @property
    def run(self) -> int:
        """The process of the run."""
        threads = Path(f"/proc/{self.process.pid}/task").glob("*/children")  # any may start it
        return int(" ".join(one.read_text() for one in threads).split()[0])
