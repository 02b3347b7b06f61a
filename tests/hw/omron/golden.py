"""Frames that a reference server accepted or produced, or that its verified encoder gives."""

GOLDEN = {
    "connected": (5, "", "0f0c080005000005"),
    "shutdown": (1, "", "0f0c080001000001"),
    "rejected": (6, "010000", "0f0c0b0006000100000007"),
    "request every 100 ms": (129, "080164000000", "0f0c0e00810008016400000001ed"),
    "request every 30 ms": (129, "54031e000000", "0f0c0e00810054031e00000003f3"),
    "request on change": (129, "d301ffffffff", "0f0c0e008100d301ffffffff03ad"),
    "request no more": (130, "5403", "0f0c0a008200540300d5"),
    "drive": (278, "3530002d3230003130300030 00", "0f0c150016013530002d323000313030003000ef9d"),
    "drive slowly": (
        534,
        "31322e35002d332e3235003130300030 00",
        "0f0c1900160231322e35002d332e3235003130300030005b3a",
    ),
    "stop": (277, "", "0f0c080015010014"),
    "stop by another number": (537, "", "0f0c08001902001b"),
    "localise": (443, "e803000030f8ffff5a000000", "0f0c1400bb01e803000030f8ffff5a000000fe2c"),
    "numbers": (
        466,
        "6603d2040000d2e9ffff84fffa00f6ff000080",
        "0f0c1b00d2016603d2040000d2e9ffff84fffa00f6ff000080f44f",
    ),
    "localisation": (442, "006a03", "0f0c0b00ba01006a0301d0"),
    "battery once": (266, "", "0f0c08000a01000b"),
}
"""By name: command, payload and frame (hex)."""

GREETING = "0f0c21000200616c70686100000044332211887766554b337900354d545800678d"
"""INTRODUCTION of a server: key "K3y", protocol "5MTX"."""
INTRODUCTION = (
    "0f0c2600020000006f6d726f6e00257b5b9c239f23cc4477ab030969e7c3354d54580000ad7f0f0c080005000005"
)
"""The answer of user "omron", password "pw", and that no UDP is wanted."""
LIST = "0f0c2a00810002001602726174696f447269766500647269766500190273746f700073746f707300f4f9"
"""LIST of 534 `ratioDrive` and 537 `stop`."""

RATIOS = [
    ((9, 4, 100), (0.0, 0.0)),
    ((10, 5, 100), (0.0, 2.5)),
    ((10.1, 4.99, 100), (0.101, 0.0)),
    ((100, 100, 5), (0.05, 2.5)),
    ((-100, 0, 100), (-0.25, 0.0)),
    ((-50, 50, 50), (-0.0625, 12.5)),
    ((0, 100, 100), (0.0, 50.0)),
]
"""Measured on the reference server: translation, rotation, throttle [%] to v, w [m/s, deg/s], from
rest, with turning at full speed as at rest."""
