"""`frankie-task ask`: a model drafts a task until checker and simulator are content."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from app.authoring import patched
from config import UserError, counted
from extensions.agent.describe import DATA
from extensions.agent.endpoint import Endpoint, Message
from extensions.agent.tools import Tools, wrong

_TRANSCRIPT = "transcript.json"
_SYSTEM = """\
You write tasks for a mobile manipulator, in YAML. Answer with one JSON object with the texts \
`task` and `cannot`, and nothing else. `task` is the text of a whole task file that does what the \
person asks, in the scene `{scene}`. If all or a part of it cannot be done, `cannot` says in one \
sentence what and why, and `task` does the nearest that can be, or is empty; else `cannot` is \
empty. What a checker or a simulator finds is told to you: then answer with the whole file again. \
{data}

"""
_KEYS = ("task", "cannot")
_SCHEMA = {
    "type": "object",
    "properties": {key: {"type": "string"} for key in _KEYS},
    "required": list(_KEYS),
    "additionalProperties": False,
}
_FENCED = re.compile(r"```\w*\n(.*?)```", re.DOTALL)


@dataclass(frozen=True)
class Asked:
    """What came of an instruction."""

    cannot: str = ""  # what cannot be done, by the model; empty if nothing
    task: str = ""  # without errors, and it has succeeded in simulation; empty if there is none
    failed: str = ""  # why no draft was any good; empty if one was
    changes: tuple[str, ...] = ()  # what the checker corrected in the draft
    run: str = ""  # the simulated run
    summary: dict[str, Any] | None = None  # of that run


def ask(
    request: str,
    endpoint: Endpoint,
    tools: Tools,
    *,
    scene: str,
    robot: str,
    rounds: int,
    say: Callable[[str], None],
) -> Asked:
    """What a model makes of a request within a number of rounds; the transcript is in the run.

    `say` tells the progress. Raises UserError: the endpoint cannot be used, or there is no such
    scene or robot.
    """
    system = _SYSTEM.format(scene=scene, data=DATA) + tools.describe(scene=scene)
    said: list[Message] = [
        {"role": "system", "content": system},
        {"role": "user", "content": request},
    ]
    tools.findings("wait: {}", robot)  # there is such a robot
    asked = Asked(failed="it answered nothing")
    try:
        for number in range(1, rounds + 1):
            why = " ".join(asked.failed.split()) if number > 1 else ""
            say(f"round {number} of {rounds}{': ' * bool(why)}{why[:200]}")
            text = endpoint.answer(said, _SCHEMA)
            said.append({"role": "assistant", "content": text})
            asked = _tried(text, tools, scene, robot)
            changes = [f"the checker corrected the draft: {one}" for one in asked.changes]
            for change in changes:
                say(change)
            if changes or asked.failed:
                told = tools.hidden("\n".join([*changes, *filter(None, [asked.failed])]))
                said.append({"role": "user", "content": told})
            if not asked.failed:
                return asked
        why = f"{counted(rounds, 'round')} brought no task that works; the last: {asked.failed}"
        return replace(asked, task="", failed=why)
    finally:
        tools.keep(asked.run, _TRANSCRIPT, json.dumps(said, indent=1))


def _tried(text: str, tools: Tools, scene: str, robot: str) -> Asked:
    """What an answer is worth."""
    answer = _read(text)
    if isinstance(answer, str):
        return Asked(failed=answer)
    task, cannot = answer
    if not task.strip():
        return Asked(cannot or "the model gives no reason")
    changes: tuple[str, ...] = ()
    try:
        found, _ = tools.findings(task, robot, scene)
        if wrong(found):
            draft, task = task, patched(task, found)
            if wrong(tools.findings(task, robot, scene)[0]):
                return Asked(failed=str(tools.check(draft, robot, scene)["text"]))
            changes = tuple(_changes(draft, task))
        done = asyncio.run(tools.simulate(task, robot=robot, scene=scene))
    except UserError as error:
        return Asked(failed=str(error), changes=changes)
    succeeded = done["summary"]["outcome"] == "success"
    why = "\n".join([f"in simulation: {done['first_cause']}", *done["details"]])
    failed = "" if succeeded else why
    return Asked(cannot, task, failed, changes, done["run"], done["summary"])


def _read(text: str) -> tuple[str, str] | str:
    """The texts `task` and `cannot` of an answer, or what is wrong with it."""
    decoder, given = json.JSONDecoder(), None
    for begin in (match.start() for match in re.finditer(r"\{", text)):
        try:
            given, _ = decoder.raw_decode(text, begin)
        except (ValueError, RecursionError):
            continue
        if given.keys() & set(_KEYS):
            break
        given = None
    if given is None:
        fenced = [one for one in (*_FENCED.findall(text), text) if re.match(r"\s*task:", one)]
        form = f"answer with one JSON object with the texts {' and '.join(_KEYS)}"
        return (fenced[0], "") if fenced else f"there is no JSON object in your answer; {form}"
    texts = [given.get(key) or "" for key in _KEYS]
    for key, one in zip(_KEYS, texts, strict=True):
        if not isinstance(one, str):
            return f"`{key}` of your answer is a {type(one).__name__}; write it as one text"
    return texts[0], texts[1]


def _changes(draft: str, task: str) -> list[str]:
    """The lines that differ."""
    lines = enumerate(zip(draft.splitlines(), task.splitlines(), strict=False), start=1)
    return [f"line {at}: `{a.strip()}` is now `{b.strip()}`" for at, (a, b) in lines if a != b]


def name_for(request: str, folder: Path) -> str:
    """A name for the proposal of a request that no other one in a folder has."""
    name = re.sub(r"[^a-z0-9]+", "_", request.lower()).strip("_")[:40] or "task"
    names = (name, *(f"{name}_{number}" for number in range(2, 100)))
    return next(one for one in names if not (folder / f"proposed_{one}.yaml").exists())
