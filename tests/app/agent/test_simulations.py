"""Simulations of a model: whose run is told, and that they end with who asked for them."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

from app.agent.tools import Tools
from app.agent.workspace import Workspace
from config import UserError

ENDLESS = "task: endless\nscene: single\ntree: {wait: {duration_s: 80000}}\n"
HELLO = "task: hello\nscene: single\ntree: {say: {text: Hi}}\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def left(folder: Path) -> list[str]:
    """Processes that work in a folder, and drafts there."""
    found = [path.name for path in folder.glob(".draft-*")]
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if (process / "cwd").resolve() == folder and int(process.name) != os.getpid():
                found.append((process / "cmdline").read_bytes().decode())
    return found


def gone(folder: Path, seconds: float = 30.0) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if not left(folder):
            return True
        time.sleep(0.1)
    return False


def test_a_cancelled_one_ends_and_another_does_not_wait_for_it(folder):
    tools = Tools(Workspace(folder))

    async def cancelled() -> None:
        asked = asyncio.create_task(tools.simulate(ENDLESS, limit_s=300))
        while not left(folder):
            await asyncio.sleep(0.1)
        await asyncio.sleep(0.5)
        asked.cancel()
        with pytest.raises(asyncio.CancelledError):
            await asked
        assert not list(folder.glob(".draft-*"))

    begun = time.monotonic()
    asyncio.run(cancelled())
    assert time.monotonic() - begun < 60.0
    assert gone(folder)


def test_too_many_are_refused_at_once_while_others_are_answered(folder):
    tools = Tools(Workspace(folder))

    async def flooded() -> list[object]:
        asked = [asyncio.create_task(tools.simulate(ENDLESS, limit_s=300)) for _ in range(45)]
        done, running = await asyncio.wait(asked, timeout=2.0)
        for one in running:
            one.cancel()
        await asyncio.gather(*running, return_exceptions=True)
        return [one.exception() for one in done]

    refused = asyncio.run(flooded())
    assert len(refused) == 40
    assert all(isinstance(one, UserError) and "busy" in str(one) for one in refused)
    assert gone(folder)


@pytest.mark.slow
def test_each_is_told_its_own_run_beside_others_in_one_folder(folder):
    one, other = Tools(Workspace(folder)), Tools(Workspace(folder))
    long = HELLO.replace("hello", "long").replace("say: {text: Hi}", "wait: {duration_s: 60}")

    async def both() -> list[dict[str, object]]:
        first = asyncio.create_task(one.simulate(long))
        await asyncio.sleep(0.3)
        return await asyncio.gather(first, other.simulate(HELLO))

    for done, task in zip(asyncio.run(both()), ("long", "hello"), strict=True):
        assert done["summary"]["task"] == task
        assert done["run"].endswith(f"-{task}")
        assert (
            json.loads((folder / "runs" / done["run"] / "summary.json").read_text())
            == (done["summary"])
        )


def request(number: int, method: str, **given: object) -> str:
    return json.dumps({"jsonrpc": "2.0", "id": number, "method": method, "params": given}) + "\n"


ENDS = ("the server is killed", "its client is gone", "the call is cancelled")


@pytest.mark.parametrize("how", ENDS)
def test_nothing_is_left_of_a_server_that_simulates(folder, how):
    pytest.importorskip("mcp")
    server = subprocess.Popen(
        [sys.executable, "-m", "frankie_task_cli", "mcp", "--folder", str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert server.stdin is not None
    who = {"name": "test", "version": "1"}
    first = {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": who}
    server.stdin.write(request(1, "initialize", **first))
    server.stdin.write('{"jsonrpc": "2.0", "method": "notifications/initialized"}\n')
    asked = {"task": ENDLESS, "limit_s": 300}
    server.stdin.write(request(2, "tools/call", name="simulate", arguments=asked))
    server.stdin.flush()
    while not any(" run" in one.replace("\0", " ") for one in left(folder)):
        time.sleep(0.1)
    if how == "the server is killed":
        server.send_signal(signal.SIGKILL)
    elif how == "the call is cancelled":
        cancelled = {"method": "notifications/cancelled", "params": {"requestId": 2}}
        server.stdin.write(json.dumps({"jsonrpc": "2.0"} | cancelled) + "\n")
        server.stdin.flush()
        end = time.monotonic() + 30.0
        while any(" run" in one.replace("\0", " ") for one in left(folder)):
            assert time.monotonic() < end
            time.sleep(0.1)
        assert server.poll() is None
    server.stdin.close()
    assert server.wait(30.0) in (0, -signal.SIGKILL)
    assert gone(folder)
