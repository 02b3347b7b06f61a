"""`main` of a driver's process in a thread of this one; its parent is the test."""

import json
import os
import sys
import threading
from contextlib import contextmanager, suppress
from typing import Any


@contextmanager
def child_in_thread(monkeypatch, module, address: str, settings: Any, memory: int):
    """Yields what asks it, and what gives all that it has told."""
    (reads, asks), (hears, writes), output = os.pipe(), os.pipe(), os.dup(1)
    os.set_blocking(hears, False)
    messages: list[dict[str, Any]] = []

    def ask(**request: Any) -> None:
        os.write(asks, json.dumps(request).encode() + b"\n")

    def told() -> list[dict[str, Any]]:
        with suppress(BlockingIOError):
            messages.extend(map(json.loads, os.read(hears, 65536).splitlines()))
        return messages

    def run() -> None:
        with suppress(SystemExit):
            module.main()

    monkeypatch.setattr("sys.stdin", os.fdopen(reads))
    monkeypatch.setattr("sys.argv", ["", address, json.dumps(settings), str(memory)])
    monkeypatch.setattr("drivers.processes.child.leave", sys.exit)
    monkeypatch.setattr(module, "still_alive", lambda *_: None)
    os.dup2(writes, 1)
    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    try:
        yield ask, told
    finally:
        ask(do="end")
        thread.join(30.0)
        os.dup2(output, 1)
        for descriptor in (asks, hears, writes, output):
            os.close(descriptor)
    assert not thread.is_alive()
