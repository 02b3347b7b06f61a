"""Reported behaviours of real arms and hands."""

from __future__ import annotations

from collections.abc import Mapping

from hw.emulators.common import Reported

AS_REPORTED: Mapping[str, Reported] = {
    # the hand
    "unhomed": Reported(
        "the hand was not homed: it tells an opening of 0 and refuses to move", "franka_ros #276"
    ),
    "slow-homing": Reported(
        "the hand was not homed, and homing takes 12 s", "fairo #1356 (6.67 s)"
    ),
    "move-blocks": Reported(
        "fingers that something is in the way of go on until they are stopped",
        "libfranka #18, franka_ros #281, fairo #1398, #1418",
    ),
    "stop-unheeded": Reported(
        "the same, and nothing answers a stop before that motion has ended", "libfranka #18, #28"
    ),
    "move-fails": Reported(
        "fingers that something is in the way of end with a failure", "panda-py #12"
    ),
    "second-grasp-fails": Reported(
        "a grasp of what is held already takes 4 s and fails", "libfranka #93"
    ),
    "second-grasp-false": Reported(
        "a grasp of what is held already is unsuccessful at once", "libfranka #108"
    ),
    "wide-grasp-fails": Reported(
        "a grasp of what is nearly as wide as the hand fails", "libfranka #202, franky #58"
    ),
    "strict-grasp": Reported(
        "a grasp outside of its tolerance lets go again", "panda-py #50, franka_ros #16"
    ),
    "never-grasped": Reported("the hand never says that it holds something", "libfranka #13"),
    "slow-hand": Reported(
        "the hand tells its state 10 times a second", "franky #35, franka_ros #127"
    ),
    # the arm
    "stop-needs-recovery": Reported(
        "after its stop button it looks idle, and refuses all until it is recovered",
        "franka_ros #308, #25, #279",
    ),
    "needs-recovery": Reported(
        "the same from the beginning: the button was pressed before", "franka_ros #308, #232"
    ),
    "slow-recovery": Reported("a recovery takes 12 s", "franka_ros #317 (0.4 to 16 s)"),
    "forgets-errors": Reported(
        "once it rests it tells no more what it has stopped for", "franka_ros #32"
    ),
    "late-reflex": Reported("it tells of a reflex 1.5 s after it has stopped", "franka_ros #317"),
    "velocity-violation": Reported(
        "every motion ends with joint_velocity_violation at a low speed", "franka_ros2 #70, #76"
    ),
    "lost-bursts": Reported("every 2 s nothing arrives for 30 ms", "libfranka #60, #163"),
    "slow-line": Reported(
        "the line takes too long for every command", "libfranka #174 (0.8 ms there and back)"
    ),
    "udp-blocked": Reported(
        "a firewall lets the connection through and no state", "libfranka #165, #40, #203"
    ),
    "wrong-version": Reported("an FR3, of interface version 10", "panda-py #41"),
    "locked": Reported("the joints are locked", "libfranka #133"),
    "guided": Reported("a person has it by the hand", "franky #17"),
    "user-stopped": Reported("its stop button is pressed, or a rule says so", "libfranka #128"),
}
"""By name."""
