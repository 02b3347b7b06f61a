"""`python -m hw.emulators.panda HOST [VERSION]`: words come in, lines of JSON go out."""

from __future__ import annotations

import sys

from hw.emulators.panda import serve

if __name__ == "__main__":
    serve(
        sys.argv[1],
        version=int(sys.argv[2]) if len(sys.argv) > 2 else 5,
        lines=sys.stdin,
        say=lambda text: print(text, flush=True),
    )
