"""What only a real robot can settle, and how: nobody who wrote the drivers had one."""

from __future__ import annotations

UNSETTLED: tuple[tuple[str, str], ...] = (
    (
        "base: whether a command moves it as fast as it says, and whether it heeds the throttle",
        "`frankie-task doctor --first-metre --arm-the-robot`, along a tape measure; without the "
        "throttle slow motion comes in pulses, or set the dead zones to 0",
    ),
    (
        "base: how old a pose is on arrival",
        "turn on the spot at 30 deg/s and stop: the angle that the pose still turns, by 30 deg/s, "
        "is `pose_delay`",
    ),
    (
        "base: from a command to the velocity (`base_lag`), and its accelerations",
        "`frankie-task delays` on a run that drives and turns",
    ),
    (
        "base: how far it goes when the cable is pulled, and the program killed",
        "both at 0.2 m/s in the open; set `Timeout` to 0.14 s before",
    ),
    (
        "base: how the emergency stop, bumpers and protective fields show",
        "press each at rest, and look at `frankie-task doctor`",
    ),
    (
        "arm: whether `torques` and `forces` fit your hand and camera",
        "push the arm with a spring balance while it stands; wrong masses in Desk look like pushes",
    ),
    (
        "arm: how often commands are late without a real-time kernel",
        "ten minutes at 10 %; `lost` in the readings of the arm, and reflexes for communication",
    ),
    (
        "arm: the lag of its joints (`arm_lag`)",
        "the same, on a run that moves the arm",
    ),
    (
        "hand: whether a grasp and a stop always end, and how wide it says that it is open",
        "close it on nothing, on a block of known width, on something soft; tell it to go to 20 mm "
        "with 40 mm between its fingers: it is stopped after 1.5 s, and holds that",
    ),
    (
        "camera: when an image was captured (`delay`)",
        "turn the wrist at 30 deg/s over an edge: what the edge moves in the world, by 30 deg/s",
    ),
    (
        "both: where the arm stands on the base, and the camera on the hand",
        "`frankie-task calibrate base-arm` and `hand-eye`",
    ),
)
"""What it is, and what to do."""
