"""Rules of the tree language, each with a code; warnings begin with R4."""

from config import MISSING_KEY as MISSING_KEY
from config import UNKNOWN_KEY as UNKNOWN_KEY
from config import VALUE as VALUE
from config import Rule

UNKNOWN_NODE = Rule(
    "R201",
    "A node is a word of the language or the key of a behaviour; `frankie-task nodes` lists them.",
    "{wiat: {duration_s: 1}}",
    "{wait: {duration_s: 1}}",
)
ONE_NODE = Rule(
    "R202",
    "An item has one key that says what the node is; beside it stand its name and modifiers.",
    "{wait: , duration_s: 1}",
    "{wait: {duration_s: 1}}",
)
CHILDREN = Rule(
    "R203",
    "The children of a composite are a list, of as many nodes as it takes.",
    "{sequence: {open_gripper: }}",
    "{sequence: [open_gripper]}",
)
CONDITION = Rule(
    "R204",
    "Guards and questions are conditions: leaves that end at once and move nothing.",
    "{while: open_gripper, wait: {duration_s: 1}}",
    "{while: arm_healthy, wait: {duration_s: 1}}",
)
ARGUMENTS = Rule(
    "R205", "What a node is given fits together.", "{drive: {}}", "{drive: {forward_m: 0.5}}"
)
PLACE = Rule(
    "R206",
    "A place is named in `poses` or `regions`, and is of the kind that is expected.",
    "poses: {home: {base: [0, 0], heading_deg: 0}}\ntree: {drive: {to: hoem}}",
    "poses: {home: {base: [0, 0], heading_deg: 0}}\ntree: {drive: {to: home}}",
)
NAMING = Rule(
    "R207",
    "A name is a word of letters, digits and `_`, and stands for one thing.",
    "poses: {ready: {base: [0, 0], heading_deg: 0}}\ntree: {drive: {to: ready}}",
    "poses: {home: {base: [0, 0], heading_deg: 0}}\ntree: {drive: {to: home}}",
)
REFERENCE = Rule(
    "R208",
    "`$name` is a parameter or a key; nothing is computed, and modifiers take no keys.",
    "params: {times: {default: 2}}\ntree: {retry: $times+1, open_gripper: }",
    "params: {times: {default: 2}}\ntree: {retry: $times, open_gripper: }",
)
SUBTREE_FILE = Rule(
    "R209",
    "A subtree is a task file in the folder of the task, or below; files form no circle.",
    "{subtree: {file: /parts/pick.yaml}}",
    "{sequence: [open_gripper]}",
)
SIZE = Rule(
    "R210",
    "A task has at most 200 subtrees, 1000 nodes of `for_each` and 100 levels of nodes.",
    "{timeout_s: 9, repeat: 1, retry: 2, sequence: [" * 30 + "open_gripper" + "]}" * 30,
    "{timeout_s: 9, repeat: 1, retry: 2, sequence: [open_gripper]}",
)
UNWRITTEN = Rule(
    "R301",
    "A key is written on every way to where it is read.",
    "{compare: {value: $count, least: 1}}",
    "{sequence: [{set: {count: 0}}, {compare: {value: $count, least: 1}}]}",
)
KEY_TYPE = Rule(
    "R302",
    "A key holds values of one type, that of its readers and of what it is compared with.",
    '{sequence: [{set: {n: 1}}, {compare: {value: $n, equals: "1"}}]}',
    "{sequence: [{set: {n: 1}}, {compare: {value: $n, equals: 1}}]}",
)
MOVERS = Rule(
    "R303",
    "Two leaves that move the robot never run at the same time.",
    "{parallel: [{recover: {arm: ready}}, {drive: {forward_m: 0.5}}]}",
    "{sequence: [{recover: {arm: ready}}, {drive: {forward_m: 0.5}}]}",
)
UNUSED = Rule(
    "R401",
    "What has a name is used.",
    "params: {times: {default: 2}}\ntree: {retry: 2, open_gripper: }",
    "params: {times: {default: 2}}\ntree: {retry: $times, open_gripper: }",
)
NO_EFFECT = Rule(
    "R402",
    "A word changes something: nothing limits the time of what ends at once.",
    "{timeout_s: 3, arm_healthy: }",
    "{arm_healthy: }",
)
ENDS_RETRIES = Rule(
    "R403",
    "A guard beside `retry` ends all attempts; put it below to end one of them.",
    "{retry: 3, while: arm_healthy, open_gripper: }",
    "{retry: 3, sequence: [{while: arm_healthy, open_gripper: }]}",
)
UNREACHED = Rule(
    "R404",
    "Every child can be reached.",
    "{fallback: [{force: success, open_gripper: }, {say: {text: hello}}]}",
    "{fallback: [open_gripper, {say: {text: hello}}]}",
)
ASKED_ONCE = Rule(
    "R405",
    "A condition in a `sequence` is asked once; a guard is asked at every tick.",
    "{sequence: [arm_healthy, {wait: {duration_s: 5}}]}",
    "{while: arm_healthy, wait: {duration_s: 5}}",
)
ENDLESS = Rule(
    "R407",
    "A loop can end, or has a `timeout_s`.",
    "{forever: {force: failure, open_gripper: }}",
    "{timeout_s: 60, forever: {force: failure, open_gripper: }}",
)
HAND = Rule(
    "R408",
    "Grasp, hold and let go follow each other in an order in which each can do something.",
    "{sequence: [open_gripper, retreat_check]}",
    "{sequence: [retreat_check, open_gripper]}",
)
TOO_SHORT = Rule(
    "R409",
    "What always takes some time has as much.",
    "{timeout_s: 5, wait: {duration_s: 10}}",
    "{timeout_s: 15, wait: {duration_s: 10}}",
)
FORCED = Rule(
    "R410",
    "A task can fail: one `force: success` is not beside all that may.",
    "{force: success, move_arm: {to: ready}}",
    "{sequence: [{force: success, move_arm: {to: ready}}, arm_healthy]}",
)
_BOX = "scene: single\nregions: {box: {centre: [3, 0, 0.556], size: [0.44, 0.36, 0.2]}}\n"
GUARD = Rule(
    "R411",
    "A guard can hold where the work is: the laser sees furniture too.",
    _BOX + "tree: {while: {not: {obstacle_within: {distance_m: 1}}}, grasp: {within: box}}",
    _BOX + "tree: {while: {not: {obstacle_within: {distance_m: 0.1}}}, grasp: {within: box}}",
)
NO_COUNTERPART = Rule(
    "R601",
    "To be exported, a task has only what BehaviorTree.CPP has a counterpart for.",
    """{set: {text: "it's"}}""",
    "open_gripper",
)

LANGUAGE_RULES = tuple(one for one in list(globals().values()) if isinstance(one, Rule))
