"""Runs of the command line in processes of their own, which need not load the libraries first.

A server has loaded them and forks a process for each run. What that does, from reading its
arguments to the end of the interpreter, is what it does when a person starts it.
"""

from __future__ import annotations

import json
import os
import runpy
import select
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

_PATIENCE = 120.0
"""Loading the libraries takes no longer than this [s]."""


class ForkServer:
    """Starts one run at a time."""

    def __init__(self) -> None:
        command = [sys.executable, "-c", f"from {__name__} import serve; serve()"]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0
        )

    def start(self, arguments: Sequence[str], errors: Path) -> int:
        """Start `frankie-task ARGUMENTS`; returns the id of the process.

        Args:
            arguments: of the command line.
            errors: file for its standard error.
        """
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps([list(arguments), str(errors)]).encode() + b"\n")
        pid = self._answer(_PATIENCE)
        if pid is None:
            raise TimeoutError("the server of processes does not answer")
        return pid

    def wait(self, patience: float) -> int | None:
        """The exit code of the run, negative for the signal that ended it.

        Args:
            patience: longest time to wait [s].

        Returns:
            None if it has not ended in that time.
        """
        return self._answer(patience)

    def _answer(self, patience: float) -> int | None:
        assert self._process.stdout is not None
        deadline, line = time.monotonic() + patience, b""
        while not line.endswith(b"\n"):
            left = max(0.0, deadline - time.monotonic())
            if not select.select([self._process.stdout], [], [], left)[0]:
                return None
            line += self._process.stdout.read(1) or b"\n"
        return int(line)


def serve() -> None:
    """Fork a process for every line of standard input; tell its id, and how it ended."""
    import rerun  # noqa: F401
    import torch  # noqa: F401

    while line := sys.stdin.readline():
        arguments, errors = json.loads(line)
        pid = os.fork()
        if pid == 0:
            null = os.open(os.devnull, os.O_RDWR)
            err = os.open(errors, os.O_WRONLY | os.O_CREAT, 0o600)
            for source, target in ((null, 0), (null, 1), (err, 2)):
                os.dup2(source, target)
            sys.argv = ["frankie-task", *arguments]
            runpy.run_module("frankie_task_cli", run_name="__main__")
            sys.exit()
        print(pid, flush=True)
        print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), flush=True)
