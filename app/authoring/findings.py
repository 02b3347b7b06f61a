"""Diagnostics for programs: each with its rule, and a patch where one word is certainly meant."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from config import Diagnostic, Hint, UserError, suggest
from trees.site import RULES


def findings(found: Sequence[Diagnostic]) -> list[dict[str, Any]]:
    """What JSON says of diagnostics, in their order.

    The text of a `patch` replaces a line, with every certain mistake in it corrected.
    """
    patches: dict[tuple[Path, int], str] = {}
    for one in reversed(found):  # from the right, so that columns stay
        if one.location and isinstance(one.hint, Hint) and one.hint.meant:
            at = one.path, one.location.line
            line = patches.get(at) or one.path.read_text("utf-8-sig").splitlines()[at[1] - 1]
            before = rf"^.{{{one.location.column - 1}}}[\"'$]*"
            if found_at := re.match(rf"({before}){re.escape(one.hint.given)}(?![\w.])", line):
                patches[at] = found_at[1] + one.hint.meant + line[found_at.end() :]
    return [_finding(one, patches) for one in found]


def _finding(one: Diagnostic, patches: dict[tuple[Path, int], str]) -> dict[str, Any]:
    line = one.location.line if one.location else None
    meant = one.hint.meant if isinstance(one.hint, Hint) else ""
    patch = patches.get((one.path, line)) if line and meant else None
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
