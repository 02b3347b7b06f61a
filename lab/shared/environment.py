"""The machine on which figures were measured."""

import os
import platform
from importlib.metadata import version
from pathlib import Path

_CPU_INFO = Path("/proc/cpuinfo")


def machine() -> dict[str, str]:
    """Processor and versions of Python and of the packages that affect speed, by name."""
    packages = {name: version(name) for name in ("numpy", "pin", "piqp")}
    return {
        "machine": f"{os.cpu_count()} x {_processor()}",
        "python": platform.python_version(),
    } | packages


def _processor() -> str:
    if _CPU_INFO.exists():
        for line in _CPU_INFO.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()
