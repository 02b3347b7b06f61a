"""Errors of the vendor's library as cause and hint."""

import re

from drivers.panda.records import Mode

MODES = {
    Mode.OTHER: "its joints are locked: unlock them on its Desk page and activate FCI",
    Mode.GUIDING: "it is being guided by hand: let go of the buttons at its wrist",
    Mode.USER_STOPPED: "its stop button is pressed: release it, then recover",
    Mode.RECOVERING: "its recovery is under way, which takes up to 16 s",
}
"""Why the arm takes no commands in a mode that only time or a person ends."""
_NO_HOST = "there is no such host: look at the address"
_NO_ANSWER = "nothing answers there: look at the address, the cable and the power"
_HINTS = (
    (
        "Connection to FCI refused",
        "it refuses the connection: open its Desk page, unlock the joints and activate FCI",
    ),
    ("not found", _NO_HOST),
    ("DNS error", _NO_HOST),
    ("Connection timeout", _NO_ANSWER),
    ("Connection error", _NO_ANSWER),
    ("unreachable", _NO_ANSWER),
    ("server closed connection", "it has closed the connection: it was switched off, or FCI was"),
    ("UDP receive", "it has stopped answering: look at the cable and the power"),
    (
        "communication_constraints",
        "too few commands arrived in time: the computer was too slow or packets were lost; "
        "a real-time kernel, less load and a cable of its own help",
    ),
    ("Command failed", "the fingers could not do it: see what is between them, or home the hand"),
    ("Command aborted", "the fingers were stopped on their way"),
    ("joint_reflex", "a joint met resistance: free the arm, then recover"),
    ("cartesian_reflex", "the hand met resistance: free the arm, then recover"),
    ("User Stop", "its stop button was pressed: release it, then recover"),
    (
        "joint_position_limits_violation",
        "a joint is at its end: move it back by hand in Desk, then recover",
    ),
    ("self_collision", "it was about to hit itself: move it by hand in Desk, then recover"),
    (
        "joint_velocity_violation",
        "a joint was faster than it may be: it was pushed, or the masses in Desk are wrong",
    ),
    ("power_limit", "it needed too much power: move more slowly, then recover"),
    ("manual error recovery", "a person has to correct its position in Desk"),
    ("velocity_limits", "a command was too fast; that is a mistake of the driver: report it"),
    ("discontinuity", "commands were not smooth enough: packets were lost, or report it"),
    (
        "current mode",
        "it takes no commands as it is: recover; else press and release its stop button, "
        "and look at its Desk page",
    ),
    ("motion aborted by reflex", "it stopped by itself: look what is in its way, then recover"),
)
UDP_BLOCKED = (
    "it takes the connection, and none of its states (UDP) arrive here: a firewall, NAT or a "
    "second network card of this computer keeps them away"
)
_BY_HAND = ("joint_position_limits_violation", "self_collision", "manual error recovery")
_VERSIONS = re.compile(r"version (\d+).*?(?:library|but this).*?version (\d+)", re.S)


def explain(error: BaseException | str) -> str:
    """One line for an error of the library: its names of errors, then a hint."""
    text = " ".join(str(error).split())
    if versions := _VERSIONS.search(text):
        server, ours = versions.groups()
        return (
            f"it speaks version {server} of the research interface and this driver version {ours}: "
            + ("it is an FR3, or has newer software" if int(server) > int(ours) else "update it")
        )
    named = re.findall(r'"([a-z_]+)"', text)
    cause = ", ".join(named) or re.sub("^libfranka[^:]*: ", "", text)
    for mark, hint in _HINTS:
        if mark in text:
            return f"{cause}; {hint}" if named or "refuse" not in hint else hint
    return cause


def explain_connecting(error: BaseException) -> str:
    """The same while connecting, after the robot has answered over TCP."""
    return UDP_BLOCKED if "UDP receive" in str(error) else explain(error)


def needs_a_person(trouble: str) -> bool:
    """Whether no program can clear this error."""
    return any(mark in trouble for mark in _BY_HAND)
