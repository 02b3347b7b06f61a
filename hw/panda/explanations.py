"""What the vendor's library says, as cause and hint for a person."""

from __future__ import annotations

import re

_HINTS = (
    (
        "Connection to FCI refused",
        "it refuses the connection: open its Desk page, unlock the joints and activate FCI",
    ),
    ("not found", "there is no such host: look at the address"),
    ("Connection timeout", "nothing answers there: look at the address, the cable and the power"),
    ("Connection error", "nothing answers there: look at the address, the cable and the power"),
    ("unreachable", "nothing answers there: look at the address, the cable and the power"),
    ("server closed connection", "it has closed the connection: it was switched off, or FCI was"),
    ("UDP receive", "it has stopped answering: look at the cable and the power"),
    (
        "communication_constraints",
        "too few commands arrived in time: the computer was too slow or packets were lost; "
        "a real-time kernel, less load and a cable of its own help",
    ),
    ("joint_reflex", "a joint met resistance: free the arm, then recover"),
    ("cartesian_reflex", "the hand met resistance: free the arm, then recover"),
    ("User Stop", "its stop button was pressed: release it, then recover"),
    (
        "joint_position_limits_violation",
        "a joint is at its end: move it back by hand in Desk, then recover",
    ),
    ("self_collision", "it was about to hit itself: move it by hand in Desk, then recover"),
    ("power_limit", "it needed too much power: move more slowly, then recover"),
    ("manual error recovery", "a person has to correct its position in Desk"),
    (
        "velocity_limits",
        "a command was too fast; that is a mistake of the driver: report it",
    ),
    ("discontinuity", "commands were not smooth enough: packets were lost, or report it"),
    ("current mode", "it is in a mode in which it takes no commands: look at its Desk page"),
    ("motion aborted by reflex", "it stopped by itself: look what is in its way, then recover"),
)
_VERSIONS = re.compile(r"version (\d+).*?(?:library|but this).*?version (\d+)", re.S)


def explain(error: BaseException | str) -> str:
    """One line for what the library says: its names of errors first, then what to do."""
    text = " ".join(str(error).split())
    if versions := _VERSIONS.search(text):
        server, ours = versions.groups()
        return (
            f"it speaks version {server} of the research interface and this driver version {ours}: "
            + ("it is an FR3, or has newer software" if int(server) > int(ours) else "update it")
        )
    named = re.findall(r'"([a-z_]+)"', text)
    cause = ", ".join(named) or text.removeprefix("libfranka: ")
    for mark, hint in _HINTS:
        if mark in text:
            return f"{cause}; {hint}" if named or "refuse" not in hint else hint
    return cause
