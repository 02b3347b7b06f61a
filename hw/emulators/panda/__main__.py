"""`python -m hw.emulators.panda HOST [VERSION [MEMORY]]`: words come in, lines of JSON go out."""

from __future__ import annotations

import sys

from hw.emulators.panda import serve
from hw.emulators.panda.linked import LinkedBody

if __name__ == "__main__":
    body = LinkedBody(int(sys.argv[3])) if len(sys.argv) > 3 else None
    serve(
        sys.argv[1],
        joints=body.joints if body else None,
        fingers=body.fingers if body else None,
        version=int(sys.argv[2]) if len(sys.argv) > 2 else 5,
        lines=sys.stdin,
        say=lambda text: print(text, flush=True),
    )
