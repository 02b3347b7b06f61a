"""Rules of diagnostics, each with a code; here those of every YAML file of the project."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Rule:
    """What diagnostics of one kind are about.

    `wrong` breaks it and `right` does not: a `tree`, or the sections of a file without `task`.
    """

    code: str  # never changes
    about: str
    wrong: str
    right: str


FILE = Rule(
    "R101",
    "A file is UTF-8 text of at most 256 kB, with one document.",
    "open_gripper\n---\ntree: open_gripper",
    "open_gripper",
)
SYNTAX = Rule(
    "R102",
    "The text is strict YAML: without anchors, aliases, tags and repeated keys.",
    "{say: {text: hello, text: again}}",
    "{say: {text: hello}}",
)
UNKNOWN_KEY = Rule(
    "R103",
    "A mapping has only keys that its reader knows, as the parameters of a behaviour.",
    "{wait: {duration: 1}}",
    "{wait: {duration_s: 1}}",
)
MISSING_KEY = Rule(
    "R104", "A mapping has every key that is required.", "{say: }", "{say: {text: hello}}"
)
VALUE = Rule(
    "R105",
    "A value has the type that is expected, and is within its range, in the unit of its name.",
    "{wait: {duration_s: soon}}",
    "{wait: {duration_s: 1.5}}",
)
LAYOUT = Rule(
    "R106",
    "What stands in a scene does not stand in something else.",
    "table: {centre: [3, 0]}\ncontainer: {centre: [3, 0]}",
    "table: {centre: [0, 1.6]}\ncontainer: {centre: [3, 0]}",
)
YAML_RULES = (FILE, SYNTAX, UNKNOWN_KEY, MISSING_KEY, VALUE, LAYOUT)
