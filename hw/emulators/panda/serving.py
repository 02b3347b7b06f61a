"""Run the emulated robot with a console beside it."""

from __future__ import annotations

import gc
import os
import queue
import threading
from collections.abc import Callable, Iterable
from contextlib import suppress

from config import UserError
from hw.emulators.panda.console import act, dumps
from hw.emulators.panda.parts import Fingers, FreeFingers, Joints, LaggedJoints
from hw.emulators.panda.server import PandaServer
from hw.emulators.panda.wire import VERSION

_PRIORITY = 10


class PortTakenError(UserError):
    """The ports of the emulated robot are not free."""


def serve(
    host: str,
    *,
    joints: Joints | None = None,
    fingers: Fingers | None = None,
    version: int = VERSION,
    lines: Iterable[str] = (),
    say: Callable[[str], None] = lambda _: None,
) -> None:
    """Be a Panda at an address of this computer until the lines of words end.

    It asks for real-time priority and goes on without where it is not granted.

    Args:
        host: its address; every address 127.x.y.z can be a robot of its own.
        joints: behind the arm; None for some in free air.
        fingers: behind the hand; None for some with nothing between them.
        version: of the research interface that it claims to speak.
        lines: what is done to it, see `ACTIONS`.
        say: told what has happened, as lines of JSON.

    Raises:
        PortTakenError: somebody listens there already.
    """
    try:
        body: Joints = LaggedJoints() if joints is None else joints
        server = PandaServer(host, body, FreeFingers() if fingers is None else fingers, version)
    except OSError as error:
        raise PortTakenError(f"no robot can be emulated at {host}: {error.strerror}") from None
    asked: queue.SimpleQueue[str | None] = queue.SimpleQueue()

    def listen() -> None:
        for line in lines:
            asked.put(line)
        asked.put(None)

    over = False

    def answer() -> None:
        nonlocal over
        if asked.empty():
            return
        line = asked.get()
        if line is None:
            over = True
        else:
            say(dumps(act(server, line)))

    threading.Thread(target=listen, daemon=True).start()
    with suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
    gc.collect()
    gc.freeze()
    say(dumps({"did": "begin"}))
    try:
        server.run(lambda: over, answer)
    finally:
        server.close()
