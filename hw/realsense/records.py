"""What the camera's process tells beside its images."""

from __future__ import annotations

import json
import struct
from dataclasses import asdict, dataclass
from typing import Self

from hw.processes.mailbox import Mailbox

STATUS = struct.Struct("<900s")


@dataclass(frozen=True, kw_only=True)
class Status:
    """What camera is there, or why there is none."""

    trouble: str = ""
    """Why there are no images; empty while there are some."""
    name: str = ""
    serial: str = ""
    firmware: str = ""
    recommended: str = ""
    """Firmware that the vendor's library is made for; empty if it does not tell."""
    usb: str = ""
    intrinsics: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    """fx, fy, cx, cy of the camera itself [px]."""

    def put(self, mailbox: Mailbox) -> None:
        """Tell."""
        told = asdict(self) | {"trouble": self.trouble[:400]}
        mailbox.put(json.dumps(told, ensure_ascii=True).encode()[: STATUS.size])

    @classmethod
    def get(cls, mailbox: Mailbox) -> Self | None:
        """What was told last; None if nothing was."""
        record = mailbox.get()
        if record is None:
            return None
        told = json.loads(record[0].rstrip(b"\0"))
        return cls(**told | {"intrinsics": tuple(told["intrinsics"])})
