"""Diagnostics for programs: each with its rule, and a patch where one word is certainly meant."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from config import Diagnostic, Hint, UserError, suggest
from trees.site import RULES, check

_ROUNDS = 5  # of correcting what is certain, and looking again

_BARE = re.compile(r"-?[\d.]+|\{(\w+: .*)?\}")  # what is not written in quotes
_Lines: TypeAlias = dict[tuple[Path, int], str]  # corrected lines


def findings(
    path: Path, robot: str, places: Path | None = None, scene: str = ""
) -> list[dict[str, Any]]:
    """What JSON says of the diagnostics of a file, for a robot, the places of a site and a scene.

    The text of a `patch` replaces a line, with every certain mistake in it corrected: those too
    that show only when others are. The column of such a one is that in the corrected line.
    """
    found = check(path, robot=robot, places=places, scene=scene)
    told, lines = {_identity(one): one for one in found}, _Lines()
    for _ in range(_ROUNDS):
        if not (patches := _patches(found, lines)):
            break
        lines |= patches
        text = (lines.get((path, at), line) for at, line in enumerate(_text(path), start=1))
        now = "\n".join(text)
        found = check(path, robot=robot, places=places, text=now, scene=scene)
        told |= {key: one for one in found if (key := _identity(one)) not in told}
        found = [one for one in found if one.path == path]  # the others stay as they were
    return [_finding(one, lines) for one in told.values()]


def patched(text: str, found: Sequence[Mapping[str, Any]]) -> str:
    """A text with the patches of its `findings`."""
    lines = text.splitlines()
    for patch in (one["patch"] for one in found if one["patch"]):
        lines[patch["first_line"] - 1 : patch["last_line"]] = [patch["text"]]
    return "\n".join([*lines, ""])


def _identity(one: Diagnostic) -> tuple[object, ...]:
    """What two diagnostics of the same mistake have in common, before and after a patch."""
    return one.path, one.location and one.location.line, one.message


def _text(path: Path) -> list[str]:
    return path.read_text("utf-8-sig").splitlines()


def _patches(found: Sequence[Diagnostic], lines: _Lines) -> _Lines:
    """The lines that have a certain mistake, corrected."""
    patches = _Lines()
    for one in reversed(found):  # from the right, so that columns stay
        if one.location and isinstance(one.hint, Hint) and one.hint.meant:
            at = one.path, one.location.line
            line = patches.get(at) or lines.get(at) or _text(one.path)[at[1] - 1]
            # Where it points to; else behind that, as it may point to the node that is given it.
            for way in ("[\"'$]*", r".*?(?<![\w.])"):
                before = rf"^.{{{one.location.column - 1}}}{way}"
                if match := re.match(rf"({before}){re.escape(one.hint.given)}(?!\w|\.\w)", line):
                    head, tail = match[1], line[match.end() :]
                    if _BARE.fullmatch(one.hint.meant) and head[-1:] == tail[:1] in ('"', "'"):
                        head, tail = head[:-1], tail[1:]
                    patches[at] = head + one.hint.meant + tail
                    break
    return patches


def _finding(one: Diagnostic, lines: _Lines) -> dict[str, Any]:
    line = one.location.line if one.location else None
    meant = one.hint.meant if isinstance(one.hint, Hint) else ""
    patch = lines.get((one.path, line)) if line and meant else None
    return {
        "code": one.rule.code,
        "severity": one.severity.value,
        "file": str(one.path),
        "line": line,
        "column": one.location and one.location.column,
        "text": one.message,
        "hint": str(one.hint),
        "suggestion": meant or None,
        "patch": patch and {"first_line": line, "last_line": line, "text": patch},
    }


def explained(code: str) -> str:
    """What a rule is about, with an example; raises UserError if no rule has the code."""
    rule = RULES.get(code.upper())
    if rule is None:
        raise UserError(f"no rule is called `{code}`; {suggest(code.upper(), RULES)}")
    wrong, right = (text.replace("\n", "\n  ") for text in (rule.wrong, rule.right))
    return f"{rule.code}: {rule.about}\nwrong:\n  {wrong}\nright:\n  {right}"
