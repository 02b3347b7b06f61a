"""The vendor's library, which is loaded only where a camera is used."""

from __future__ import annotations

import importlib.util


def is_installed() -> bool:
    """Whether the library is there."""
    return importlib.util.find_spec("pyrealsense2") is not None


def missing() -> str:
    """What to tell a person if the library is not there; empty if it is."""
    if is_installed():
        return ""
    return 'the driver of the RealSense is not installed: pip install "frankie-task[hardware]"'
