"""`python -m extensions.emulators.panda HOST [VERSION [MEMORY [NAME,...]]]`.

NAMEs are those of `AS_REPORTED`. Commands on standard input, JSON on standard output. MEMORY `-`:
it moves in free air.
"""

import sys

from extensions.emulators.panda import LinkedBody, serve

if __name__ == "__main__":
    host, version, memory, names = [*sys.argv[1:], *("", "5", "-", "")[len(sys.argv) - 1 :]]
    body = None if memory == "-" else LinkedBody(int(memory))
    serve(
        host,
        joints=body,
        fingers=body,
        version=int(version),
        as_reported=[names],
        lines=sys.stdin,
        say=lambda text: print(text, flush=True),
    )
