"""What a model can do; the docstrings are for it."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from app.agent.describe import description
from app.agent.workspace import Workspace
from app.authoring import explained, findings
from app.review import explain, find_run, run_folders
from app.terminal import visible
from config import Severity, UserError
from trees.draw import tree_text
from trees.language import load

_DRY, _REST = 60, 20  # for a dry run, and for a simulation to end when it is told to [s]
_TIMED_OUT = 124  # exit code of `timeout`
_MOST_TEXT = 20_000  # characters of an answer
_MOST_PROPOSALS, _MOST_RUNS = 100, 40

_Task = Annotated[
    str, Field(max_length=64_000, description="The YAML of a task, or the name of a file.")
]
_Values = Annotated[dict[str, str], Field(max_length=100)]
_Name = Annotated[str, Field(max_length=200)]


TOOLS = ("describe", "check", "draw", "dry", "simulate", "explain", "runs", "propose")


class Tools:
    """Its methods TOOLS raise UserError with what the model did wrong."""

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        self._runs = workspace.folder / "runs"
        self._simulating = threading.Lock()

    def describe(self, short: bool = False, scene: _Name = "single") -> str:
        """The task language with parameters and ranges, robots, and what stands in a scene.

        Read it before you write a task; `short` leaves out the meanings of parameters.
        """
        told = description(self._workspace.scene(scene), short=short)
        places = self._workspace.places
        return f"{told}\n# Places that every task has\n{places.read_text()}" if places else told

    def check(self, task: _Task, robot: _Name = "frankie") -> list[dict[str, Any]]:
        """Every mistake in a task, for a robot; without errors it can be run.

        Where a finding has a patch, its text replaces those lines. `explain` explains the codes.
        """
        with self._workspace.task(task) as path:
            found = findings(path, self._workspace.robot(robot), self._workspace.places)
            return [one | {"file": Path(one["file"]).name} for one in found]

    def draw(self, task: _Task) -> str:
        """The tree of a task as indented text."""
        with self._workspace.task(task) as path:
            read = load(path, open_parameters=True, places=self._workspace.places)
            return tree_text(read.root)[:_MOST_TEXT]

    def dry(
        self, task: _Task, outcomes: _Values | None = None, parameters: _Values | None = None
    ) -> str:
        """Try the logic of a task without a robot: which node runs after which outcome.

        `outcomes` are what leaves answer in turn, as {"grasp": "failure,success"}.
        """
        with self._workspace.task(task) as path:
            given = [*_options("outcome", outcomes), *_options("parameter", parameters)]
            given += self._places
            done = self._child(_DRY, "dry", *given, "--", str(path))
        return (done.stdout or done.stderr)[-_MOST_TEXT:]

    def simulate(
        self,
        task: _Task,
        robot: _Name = "frankie",
        world: _Name = "kinematic",
        scene: _Name = "",
        seed: Annotated[int, Field(ge=0)] = 0,
        limit_s: Annotated[int, Field(gt=0, le=600)] = 120,
        parameters: _Values | None = None,
        faults: Annotated[list[str], Field(max_length=20)] = [],  # noqa: B006
    ) -> dict[str, Any]:
        """Run a task in a simulated world, `kinematic` or `physics`: the summary and first cause.

        It is stopped after `limit_s` of real time. `faults` are what goes wrong meanwhile, as
        `reflex@carry` or, by a person who takes it, `object pulled@offer`. `explain` tells more.
        """
        given = {"robot": self._workspace.robot(robot), "world": world, "seed": str(seed)}
        given |= {"scene": self._workspace.scene(scene), "record": str(self._runs)}
        given |= {"view": "none", "speed": "max"}
        words = [f"--{name}={value}" for name, value in given.items() if value]
        words += ["--json", *_options("parameter", parameters)]
        words += [*self._places, *(f"--fault={fault}" for fault in faults)]
        with self._simulating, self._workspace.task(task) as path:
            before = run_folders(self._runs)
            done = self._child(limit_s, "run", *words, "--", str(path))
            new = [folder for folder in run_folders(self._runs) if folder not in before]
        if not new or not done.stdout:
            late = f"it did not begin within {limit_s} s"
            raise UserError(late if done.returncode == _TIMED_OUT else done.stderr[-_MOST_TEXT:])
        cause = explain(new[-1]).headline
        return {"run": new[-1].name, "first_cause": cause, "summary": json.loads(done.stdout)}

    @property
    def _places(self) -> list[str]:
        places = self._workspace.places
        return [f"--places={places}"] if places else []

    def explain(self, what: _Name = "last") -> str:
        """A rule by its code, as R201; or how a run ended and why, by its name or `last`."""
        if re.fullmatch(r"R\d+", what):
            return explained(what)
        return str(explain(find_run(Path(what).name, self._runs)))[:_MOST_TEXT]

    def runs(self) -> list[str]:
        """The names of the last runs, the newest last."""
        return [folder.name for folder in run_folders(self._runs)[-_MOST_RUNS:]]

    def propose(self, name: _Name, task: _Task, why: _Name) -> str:
        """Keep a task without errors for a person, who alone may start it on a real robot."""
        if not re.fullmatch(r"[a-z0-9_]{1,60}", name) or ":" not in task:
            raise UserError("give a name of small letters, digits and `_`, and the text of a task")
        if any(one["severity"] == Severity.ERROR.value for one in self.check(task)):
            raise UserError("the task has errors; `check` tells them")
        path = self._workspace.folder / f"proposed_{name}.yaml"
        if len(list(path.parent.glob("proposed_*"))) >= _MOST_PROPOSALS:
            raise UserError(f"{_MOST_PROPOSALS} proposals wait for a person already")
        try:
            with path.open("x", encoding="utf-8", errors="replace") as file:  # never over one read
                file.write(f"# Proposed by a model: {visible(' '.join(why.split()))}\n{task}")
        except FileExistsError:
            raise UserError(f"{path.name}: is there already; choose another name") from None
        return f"{path.name}: a person may read and start it"

    def keep(self, run: str, name: str, text: str) -> None:
        """Keep a text beside the other files of a run, or of all runs; not for the model."""
        path = self._runs / run / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def _child(self, seconds: int, *words: str) -> subprocess.CompletedProcess[str]:
        """A command that has ended; it is interrupted after a time, even if we are gone by then."""
        limit = ["timeout", "--signal=INT", f"--kill-after={_REST}", str(seconds)]
        return subprocess.run(
            [*limit, sys.executable, "-P", "-m", "frankie_task_cli", *words],
            cwd=self._workspace.folder,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        )


def _options(name: str, values: Mapping[str, str] | None) -> list[str]:
    return [f"--{name}={key}={value}" for key, value in (values or {}).items()]
