"""The desk of `serve`: tasks that people start, one at a time, and the runs of a folder."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path
from typing import Annotated
from urllib.parse import quote

from pydantic import Field, ValidationError

from app.choices import Speed, View
from app.core import RECORDING
from app.review import explain, find_run, read_run, run_folders
from app.task_time import task_time
from config import Severity, UserError
from config.reader import StrictModel
from extensions.page.catalogue import at_field, catalogue, mistakes, task_files
from extensions.page.control_page import Told
from extensions.page.explanation_page import explanation_page
from extensions.page.run_process import RunProcess
from extensions.page.saved import saved
from extensions.page.server import Document, PageServer

_MOST_RUNS = 40
_STAMP = "%Y-%m-%d-%H%M%S"
_PLAIN = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; frame-ancestors 'none'"


class Order(StrictModel):
    """What a person wants to run."""

    task: str
    robot: str = "frankie"
    world: str = "kinematic"
    scene: str = ""
    seed: Annotated[int, Field(ge=0)] = 0
    parameters: Mapping[str, str] = {}
    speed: Speed = Speed.REAL
    approve: bool = False


class TaskDesk:
    """Starts tasks of a folder, and the shipped ones; their runs are kept in `runs` there.

    `armed` is whether a real robot may move, `view` how the 3-D viewer is served, and `say` prints
    a line. `server` has to be set before the first request.
    """

    server: PageServer

    def __init__(
        self, folder: Path, *, armed: bool, view: View, say: Callable[[str], None]
    ) -> None:
        self._folder, self._runs = folder, folder / "runs"
        self._armed, self._view, self._say = armed, view, say
        self.banner = "ARMED: a robot file moves the real robot" if armed else "simulated only"
        self._run: RunProcess | None = None
        self._order: Order | None = None
        self._causes: dict[Path, str] = {}
        self._lock = threading.Lock()

    def get(self, path: str) -> Document | None:
        """Tasks and runs as JSON; the explanation and the recording of a run; or why not."""
        try:
            match path.split("/")[1:]:
                case ["tasks"]:
                    return _json(catalogue(self._folder) | {"real": self.banner})
                case ["runs"]:
                    newest = reversed(run_folders(self._runs)[-_MOST_RUNS:])
                    return _json([self._row(folder) for folder in newest])
                case ["runs", name]:
                    folder = find_run(name, self._runs)
                    told = {"recording": self._recording(folder)}
                    return _json(saved(folder, _when(folder.name)) | told)
                case ["runs", name, "explanation"]:
                    page = explanation_page(explain(find_run(name, self._runs)))
                    return Document(page.encode(), "text/html; charset=utf-8", _PLAIN)
                case [self.server.ticket, name, "recording.rrd"]:
                    recording = find_run(name, self._runs) / RECORDING
                    if recording.is_file():
                        return Document(recording, "application/octet-stream")
        except (UserError, OSError) as error:
            return Document(str(error).encode(), "text/plain; charset=utf-8")
        return None

    def post(self, path: str, body: bytes) -> Told | None:
        """Check or start a task, or start the one of the run with a number again."""
        if path.startswith("/again/") and self._order is not None:
            if path != f"/again/{self.server.run}":
                return {"refused": "another task was started since; look which"}
            return self._start(self._order)
        if path not in ("/check", "/start"):
            return None
        try:
            given = json.loads(body, object_hook=_filled)
            order = Order.model_validate(given, strict=False)
        except ValidationError as invalid:
            found = [
                at_field(".".join(map(str, one["loc"])), one["msg"]) for one in invalid.errors()
            ]
            refused = "; ".join(f"{one['field']}: {one['text']}" for one in found)
            return {"refused": refused, "mistakes": found}
        except (ValueError, RecursionError) as error:
            return {"refused": f"this is not JSON ({error})"}
        return self._start(order) if path == "/start" else self._checked(order)

    def close(self) -> None:
        """End what runs; the robot comes to rest."""
        if self._run is not None:
            self._run.end()

    def _checked(self, order: Order) -> Told:
        path = task_files(self._folder).get(order.task)
        if path is None:
            return {"refused": f"{order.task}: there is no such task"}
        return {"mistakes": mistakes(path, order.robot, order.parameters, order.scene)}

    def _start(self, order: Order) -> Told:
        if self._run is not None and not self._run.is_over:
            return {"refused": f"{self._run.about()['task']} runs; stop it first"}
        told = self._checked(order)
        errors = [one for one in told.get("mistakes", ()) if one["severity"] == _ERROR]
        if errors or "refused" in told:
            return told
        with self._lock:
            if self._run is not None and not self._run.is_over:
                return {"refused": "another task was started just now; stop it first"}
            if self._run is not None:
                self._run.end()
            try:
                self._run = RunProcess(order.task, self._arguments(order), self._say)
            except (OSError, RuntimeError) as error:
                return {"refused": f"nothing was started ({error}); end other programs, try again"}
            self._order = order
            self.server.serve(self._run)
        return told | {"started": self.server.run}

    def _arguments(self, order: Order) -> list[str]:
        """The arguments of `frankie-task run`."""
        given = {"robot": order.robot, "world": order.world, "scene": order.scene}
        given |= {"seed": str(order.seed), "speed": order.speed.value, "record": str(self._runs)}
        given |= {"view": self._view.value}
        flags = {"approve": order.approve, "arm-the-robot": self._armed}
        return [
            *(f"--{name}={value}" for name, value in given.items() if value),
            *(f"--parameter={name}={value}" for name, value in order.parameters.items()),
            *(f"--{name}" for name, wanted in flags.items() if wanted),
            "--",
            str(task_files(self._folder)[order.task]),
        ]

    def _row(self, folder: Path) -> Told:
        """A run, for the list of runs."""
        summary = read_run(folder).summary
        done = summary.duration_s
        if folder not in self._causes or done is None:
            try:
                self._causes[folder] = explain(folder).headline
            except UserError as error:
                self._causes[folder] = str(error)
        return {
            "when": _when(folder.name),
            "task": summary.task,
            "outcome": summary.outcome,
            "time": "" if done is None else task_time(done),
            "cause": self._causes[folder],
            "recording": self._recording(folder),
            "explanation": f"/runs/{quote(folder.name)}/explanation",
            "name": folder.name,
        }

    def _recording(self, folder: Path) -> str | None:
        """The path of a run's recording, if it has one."""
        has_one = (folder / RECORDING).is_file()
        return f"/{self.server.ticket}/{quote(folder.name)}/recording.rrd" if has_one else None


_ERROR = Severity.ERROR.value


def _filled(fields: Told) -> Told:
    """Without the empty fields, which mean their defaults."""
    return {name: value for name, value in fields.items() if value != ""}


def _json(told: object) -> Document:
    return Document(json.dumps(told).encode(), "application/json")


def _when(name: str) -> str:
    """The time in the name of a run's folder."""
    try:
        return datetime.strptime(name[:17], _STAMP).strftime("%d %b %H:%M")
    except ValueError:
        return ""
