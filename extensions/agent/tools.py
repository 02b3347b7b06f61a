"""What a model can do; the docstrings are for it."""

from __future__ import annotations

import asyncio
import json
import re
import socket
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from app.authoring import explained, findings
from app.core import DEFAULT_SCENE
from app.review import explain, find_run, run_folders
from app.terminal import visible
from config import Severity, UserError
from extensions.agent import attended
from extensions.agent.describe import DATA, description
from extensions.agent.workspace import PRODUCT, Workspace
from trees.draw import tree_text
from trees.language import load

_DRY = 60  # for a dry run [s]
_MOST_TEXT = 20_000  # characters of an answer
_MOST_WAITING = 4  # dry runs, and simulations, while one is under way
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
        self._turns = {"run": asyncio.Lock(), "dry": asyncio.Lock()}  # one of a kind at a time
        self._asked = {"run": 0, "dry": 0}

    def describe(self, short: bool = False, scene: _Name = DEFAULT_SCENE) -> str:
        """The task language with parameters and ranges, robots, and what stands in a scene.

        Read it before you write a task; `short` leaves out the meanings of parameters. Give `check`
        and `simulate` the same scene, or name it in the task by `scene:`.
        """
        told = description(self._workspace.scene(scene), short=short)
        places = self._workspace.places
        if places:
            told += f"\n# Places that every task has. {DATA}\n{places.read_text()}"
        return _cut(told, 2 * _MOST_TEXT)

    def check(self, task: _Task, robot: _Name = "frankie", scene: _Name = "") -> dict[str, Any]:
        """Every mistake in a task, for a robot in a scene; without errors it can be run.

        Where a finding has a patch, its text replaces those lines. `explain` explains the codes.
        `scene` is as for `simulate`.
        """
        found, where = self.findings(task, robot, scene)
        told = list(found)
        while len(json.dumps(told)) > _MOST_TEXT:
            told = told[: len(told) // 2]
        form = "{line}:{column}: {severity}: {text}; {hint} [{code}]"
        lines = [form.format_map(one) for one in told]
        if left_out := len(found) - len(told):
            lines.append(f"{left_out} more are not told: correct these first")
        good = "it has errors" if wrong(found) else "good"
        text = "\n".join([f"{good}, in the scene `{where}`", *lines])
        return {"text": text, "result": told, "scene": where, "left_out": left_out}

    def findings(
        self, task: str, robot: str = "frankie", scene: str = ""
    ) -> tuple[list[dict[str, Any]], str]:
        """All that is wrong with a task, and the scene in which it was looked at."""
        with self._workspace.task(task) as path:
            where = self._workspace.scene(scene) or self._workspace.scene_of(path)
            robot, places = self._workspace.robot(robot), self._workspace.places
            found = findings(path, robot, places, scene or where or DEFAULT_SCENE)
            told = [one | {"file": Path(one["file"]).name} for one in found]
            return told, where or DEFAULT_SCENE

    def draw(self, task: _Task) -> str:
        """The tree of a task as indented text."""
        with self._workspace.task(task) as path:
            read = load(path, open_parameters=True, places=self._workspace.places)
            return _cut(tree_text(read.root))

    async def dry(
        self, task: _Task, outcomes: _Values | None = None, parameters: _Values | None = None
    ) -> str:
        """Try the logic of a task without a robot: which node runs after which outcome.

        `outcomes` are what leaves answer in turn, as {"grasp": "failure,success"}.
        """
        given = [*_options("outcome", outcomes), *_options("parameter", parameters)]
        done = await self._child(_DRY, task, "dry", *given, *self._places)
        late = f"\nlimit of {_DRY} s reached" * (done.returncode == attended.LATE)
        return _cut(done.stdout or done.stderr) + late

    async def simulate(
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

        Without `scene` it is in the one that the task names, else in `household`. It is stopped
        after `limit_s` of real time. `faults` are what goes wrong meanwhile, as `reflex@carry` or,
        by a person who takes it, `object pulled@offer`. `explain` tells more.
        """
        given = {"robot": self._workspace.robot(robot), "world": world, "seed": str(seed)}
        if faults:
            given |= {"world": f"faulty:{world}", "with": f"faults:{','.join(faults)}"}
        given |= {"scene": self._workspace.scene(scene), "record": str(self._runs)}
        given |= {"view": "none", "speed": "max"}
        words = [f"--{name}={value}" for name, value in given.items() if value]
        words += ["--json", *_options("parameter", parameters)]
        words += self._places
        done = await self._child(limit_s, task, "run", *words)
        if not done.stdout:
            late = f"it did not begin within {limit_s} s"
            raise UserError(late if done.returncode == attended.LATE else _cut(done.stderr))
        summary, left = (
            json.loads(done.stdout),
            re.findall(r"^left in .*/(.+)/$", done.stderr, re.M),
        )
        folder = self._runs / left[-1]
        why = explain(folder).why
        if done.returncode == attended.LATE:
            why[0] = f"The limit of {limit_s} s of real time was reached. {why[0]}"
        lies = ", ".join(f"{name} on {on or 'nothing'}" for name, on in summary["lies_on"].items())
        head = f"{summary['outcome']} in the scene `{summary['scene']}`, run {folder.name}"
        said = [f"said: {' '.join(text.split())}" for text in summary["messages"]]
        text = _cut("\n".join([head, *why, *said, *([f"in the end: {lies}"] if lies else [])]))
        told = {"text": text, "run": folder.name, "first_cause": why[0]}
        return told | {"details": why[1:], "summary": summary}

    def hidden(self, text: str) -> str:
        """A text without where our folders are on this computer."""
        for folder in (self._workspace.folder, PRODUCT):
            text = text.replace(f"{folder}/", "")
        return text

    @property
    def _places(self) -> list[str]:
        places = self._workspace.places
        return [f"--places={places}"] if places else []

    def explain(self, what: _Name = "last") -> str:
        """A rule by its code, as R201; or how a run ended and why, by its name or `last`."""
        if re.fullmatch(r"R\d+", what):
            return explained(what)
        return _cut(str(explain(find_run(Path(what).name, self._runs))))

    def runs(self) -> str:
        """The names of the last runs, the newest last."""
        return "\n".join(folder.name for folder in run_folders(self._runs)[-_MOST_RUNS:]) or "none"

    def propose(self, name: _Name, task: _Task, why: _Name) -> str:
        """Keep a task without errors for a person, who alone may start it on a real robot."""
        if not re.fullmatch(r"[a-z0-9_]{1,60}", name) or ":" not in task:
            raise UserError("give a name of small letters, digits and `_`, and the text of a task")
        if wrong(self.findings(task)[0]):
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

    async def _child(
        self, seconds: int, task: str, command: str, *words: str
    ) -> subprocess.CompletedProcess[str]:
        """A command about a task that has ended; it ends when we are cancelled, or killed."""
        if self._asked[command] > _MOST_WAITING:
            raise UserError(f"busy: {_MOST_WAITING} others wait for their turn; try again later")
        self._asked[command] += 1
        try:
            async with self._turns[command]:
                ours, theirs = socket.socketpair()
                with ours, theirs, self._workspace.task(task) as path:
                    draft = str(path) if ":" in task else ""
                    line = [sys.executable, "-I", attended.__file__, str(seconds), draft]
                    line += [sys.executable, "-P", "-m", "frankie_task_cli", command, *words]
                    child = subprocess.Popen(
                        [*line, "--", str(path)],
                        cwd=self._workspace.folder,
                        stdin=theirs.fileno(),
                        stdout=subprocess.PIPE,
                        stderr=subprocess.PIPE,
                        text=True,
                        errors="replace",
                        start_new_session=True,  # it outlives us to clean up
                    )
                    theirs.close()
                    out, err = await asyncio.to_thread(child.communicate)
        finally:
            self._asked[command] -= 1
        return subprocess.CompletedProcess(line, child.returncode, out, err)


def wrong(found: Sequence[Mapping[str, Any]]) -> bool:
    """Whether there is an error among `findings`."""
    return any(one["severity"] == Severity.ERROR.value for one in found)


def _cut(text: str, most: int = _MOST_TEXT) -> str:
    """Beginning and end, of at most so many characters, in whole lines, and what is left out."""
    if len(text) <= most:
        return text
    head, tail = text[: most // 2], text[-most // 2 :]
    head, tail = head.rpartition("\n")[0] or head, tail.partition("\n")[2] or tail
    return f"{head}\n... cut here: {len(text) - len(head) - len(tail)} characters ...\n{tail}"


def _options(name: str, values: Mapping[str, str] | None) -> list[str]:
    return [f"--{name}={key}={value}" for key, value in (values or {}).items()]
