"""Files that a task includes, and the values that parameters get from outside.

An included file is named relative to the including one and lies in the folder of the task, or
below; links that lead out of it, and files that include themselves, are refused.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from config import (
    Diagnostics,
    Hint,
    Location,
    YamlEntry,
    YamlScalar,
    YamlValue,
    describe,
    parse_scalar,
    suggest,
)
from trees.language import rules
from trees.language.documents import Document, TaskParameter
from trees.language.mappings import entries_below
from trees.language.named_poses import NamedValues
from trees.language.scope import Scope, read_argument, read_key_name
from trees.language.values import Argument, KeyRead, KeyWrite, MismatchError, convert


def find_file(
    name: object, value: YamlValue, chain: Sequence[Path], diagnostics: Diagnostics
) -> Path | None:
    """The file of this name, if it may be included; None and an error otherwise.

    `name` is as the including file has it, at `value`; `chain` are the files from the first to that
    one.
    """
    if not isinstance(name, str) or not name.isprintable() or not name.strip():
        message = f"`file` cannot be {describe(value)}"
        diagnostics.error(rules.SUBTREE_FILE, value.location, message, "name a file")
        return None
    folder, path = chain[0].parent, chain[-1].parent / name
    try:
        real, inside = path.resolve(), folder.resolve()
        with suppress(FileNotFoundError, NotADirectoryError):
            path.stat()  # raises for links in a circle and names that are too long
        is_there = real.is_file()
        others = () if is_there else tuple(path.parent.glob("*.yaml"))
    except (OSError, RuntimeError):
        message, hint = f"`{name}` leads nowhere", "name a file, or fix the link"
        diagnostics.error(rules.SUBTREE_FILE, value.location, message, hint)
        return None
    around = [other.resolve() for other in chain]
    if Path(name).is_absolute() or not real.is_relative_to(inside):
        message = f"`{name}` leads out of the folder of the task"
        hint = f"keep it in `{folder}` or below"
    elif not is_there:
        known = {other.name for other in others} - {other.name for other in chain}
        message = f"there is no file `{name}` beside this one"
        hint = suggest(path.name, known) if known else "check the path"
        if "\\" in name:
            hint = Hint(f"write `{(slashed := name.replace(chr(92), '/'))}`", name, slashed)
    elif real in around:
        circle = (*chain[around.index(real) :], path)
        names = " > ".join(other.name for other in circle)
        message = f"the files include each other in a circle: {names}"
        hint = "remove one of these subtrees"
    else:
        return path
    diagnostics.error(rules.SUBTREE_FILE, value.location, message, hint)
    return None


def read_with(
    location: Location, entries: Mapping[str, YamlEntry], document: Document, scope: Scope
) -> dict[str, Argument]:
    """Values of the other file's parameters."""
    arguments: dict[str, Argument] = {}
    says, hint = "`with` is a mapping", "write `with: {parameter: value}`"
    given = entries_below(entries.get("with"), says, hint, scope.diagnostics)
    if given is None:
        return arguments
    for name, argument in given.items():
        parameter = document.parameters.get(name)
        if parameter is None:
            message = f"`{document.name}` has no parameter `{name}`"
            hint = suggest(name, document.parameters)
            scope.error(rules.UNKNOWN_KEY, argument.location, message, hint)
            continue
        if parameter.type is None:
            continue
        read = read_argument(name, argument.value, parameter.type, parameter.description, scope)
        value = read.get(name)
        if isinstance(scope.if_known(value), KeyRead) and parameter.type.is_bounded:
            message = f"`{name}` has bounds, and `{value}` has its value only during the run"
            scope.error(rules.REFERENCE, argument.value.location, message, "give a value")
            continue
        arguments |= read
    for name, parameter in document.parameters.items():
        # One that stands beside `file` by mistake is noted there.
        is_needed = parameter.type is not None and parameter.default is None
        if is_needed and name not in {*given, *entries}:
            about = f": {parameter.description}" if parameter.description else ""
            message = f"`{document.name}` lacks `{name}` ({parameter.type}{about})"
            hint = f"write `with: {{{name}: ...}}` below `subtree`"
            scope.error(rules.MISSING_KEY, location, message, hint)
    return arguments


def read_out(entry: YamlEntry | None, document: Document, scope: Scope) -> dict[str, KeyWrite]:
    """Keys of the including file that take the outputs of the other."""
    outputs = {}
    says, hint = "`out` is a mapping", "write `out: {output: key}`"
    given = entries_below(entry, says, hint, scope.diagnostics)
    for name, argument in (given or {}).items():
        if name in document.outputs:
            write = read_key_name(name, argument.value, scope)
            if write is not None:
                outputs[name] = write
        else:
            message = f"`{document.name}` has no output `{name}`"
            hint = suggest(name, document.outputs)
            scope.error(rules.UNKNOWN_KEY, argument.location, message, hint)
    return outputs


def override_values(
    parameters: Mapping[str, TaskParameter],
    overrides: Mapping[str, str],
    entry: YamlEntry | None,
    diagnostics: Diagnostics,
) -> dict[str, YamlScalar]:
    """The values of `-p name=text`; unknown names are errors.

    The texts are as in YAML; a text parameter takes them unchanged.
    """
    values = {}
    for name, text in overrides.items():
        if name not in parameters:
            message = f"`-p {name}={text}`: the task has no parameter `{name}`"
            at = entry.location if entry else Location(line=1, column=1)
            diagnostics.error(rules.UNKNOWN_KEY, at, message, suggest(name, parameters))
            continue
        expected = parameters[name].type
        as_text = expected is not None and str in expected.types
        value = text if as_text else parse_scalar(text.strip())
        values[name] = YamlScalar(location=parameters[name].location, value=value)
    return values


def with_values(
    parameters: Mapping[str, TaskParameter],
    overrides: Mapping[str, YamlScalar],
    named: NamedValues,
    diagnostics: Diagnostics,
) -> dict[str, TaskParameter]:
    """The parameters with values: of a person, else of an including file, else the default."""
    result = dict(parameters)
    for name, parameter in parameters.items():
        source = overrides.get(name) or parameter.default
        if parameter.value is not None or parameter.type is None or source is None:
            continue
        try:
            value = convert(source, parameter.type, named.values)
            result[name] = replace(parameter, value=value)
        except MismatchError as mismatch:
            result[name] = replace(parameter, type=None)
            if not named.is_faulty(source.value):
                is_given = name in overrides
                whose = f"`-p {name}={source.value}`" if is_given else f"the default of `{name}`"
                message = f"{whose}: {mismatch.message}"
                diagnostics.error(mismatch.rule, source.location, message, mismatch.hint)
    return result
