"""Runs a command while somebody waits for it: `python attended.py SECONDS DRAFT COMMAND ...`.

Whoever waits holds standard input open. At its end, as when that process is killed, the file DRAFT
is removed and the command told to end, as it is after SECONDS, of real time. The exit code is that
of the command, or LATE. It imports nothing of ours, to begin soon.
"""

import os
import select
import subprocess
import sys
import threading
from contextlib import suppress

LATE = 124
_REST = 20  # for the command to end when it is told to, before it is killed [s]


def tell_end(child: subprocess.Popen[bytes], pipe: int) -> None:
    """Close a pipe when a process has ended, for who selects among files."""
    child.wait()
    os.close(pipe)


if __name__ == "__main__":
    seconds, draft, *command = sys.argv[1:]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL) as child:
        over, ended = os.pipe()
        threading.Thread(target=tell_end, args=(child, ended), daemon=True).start()
        ready, _, _ = select.select([0, over], [], [], float(seconds))
        if 0 in ready:
            with suppress(OSError):
                os.unlink(draft)
        if over not in ready:
            child.terminate()
            try:
                child.wait(_REST)
            except subprocess.TimeoutExpired:
                child.kill()
    sys.exit(child.returncode if ready else LATE)
