"""The file that a new task begins with: small, commented, and ready to run."""

from config import UserError
from trees.language import NAMING_HINT, WORD, describe_leaves, known_leaves
from trees.task_schema import SCHEMA_FILE, schema_text

_TASK = """\
# yaml-language-server: $schema={schema}
# The line above lets an editor complete and explain what you write.
# Check it, with line and column:    frankie-task check {name}.yaml
# Try it without a robot:            frankie-task dry {name}.yaml
# All that a task can be made of:    frankie-task nodes
task: {name}
description: Look at the container from above, then come back.

# What a person may choose with `-p patience_s=5`. Below, `$patience_s` stands for the value.
params:
  patience_s: {{default: 2.0, description: how long to stay above the container}}

# Poses in the world, in metres and degrees: of the point between the finger tips (`xyz`,
# `rpy_deg`; roll 180 looks down), or of the base (`base`, `heading_deg`).
poses:
  above_container: {{xyz: [2.935, 0.0, 0.85], rpy_deg: [180, 0, 0]}}
  start: {{base: [0.0, 0.0], heading_deg: 0}}

tree:
  sequence: # its nodes run in order; it stops at the first that fails
    - recover: {{arm: ready}} # clears faults and folds the arm
    - name: look # names show in pictures and messages
      retry: 3 # a modifier: it stands beside the node that it is about
      navigate: {{to: above_container}}
    - wait: {{duration_s: $patience_s}}
    - navigate: {{to: start}}
"""


def new_files(name: str) -> dict[str, str]:
    """The texts of a new task's files by name, the task first, then the schema that it names.

    Raises UserError: a task file cannot have this name; LeafError: an installed leaf class is at
    fault.
    """
    if not WORD.fullmatch(name):
        raise UserError(f"`{name}` cannot name a task; {NAMING_HINT}")
    return {
        f"{name}.yaml": _TASK.format(name=name, schema=SCHEMA_FILE.name),
        SCHEMA_FILE.name: schema_text(describe_leaves(known_leaves())),
    }
