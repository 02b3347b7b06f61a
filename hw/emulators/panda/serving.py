"""Run the emulated robot with a console beside it."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterable, Sequence

from hw.emulators.common import PortTakenError, be_prompt
from hw.emulators.panda.console import act, dumps
from hw.emulators.panda.parts import Fingers, FreeFingers, Joints, LaggedJoints
from hw.emulators.panda.server import PandaServer
from hw.emulators.panda.wire import VERSION

_PRIORITY = 10


def serve(
    host: str,
    *,
    joints: Joints | None = None,
    fingers: Fingers | None = None,
    version: int = VERSION,
    as_reported: Sequence[str] = (),
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
        as_reported: how it behaves, of `AS_REPORTED`.
        lines: what is done to it, see `ACTIONS`.
        say: told what has happened, as lines of JSON.

    Raises:
        PortTakenError: somebody listens there already.
        NotReportedError: nobody has reported that it behaves so.
    """
    try:
        body: Joints = LaggedJoints() if joints is None else joints
        hand: Fingers = FreeFingers() if fingers is None else fingers
        server = PandaServer(host, body, hand, version, as_reported)
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
    be_prompt(_PRIORITY)
    say(dumps({"did": "begin"}))
    try:
        server.run(lambda: over, answer)
    finally:
        server.close()
