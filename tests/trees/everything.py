"""A task that uses every word of the language, for the tools that have to know them all."""

from __future__ import annotations

from pathlib import Path

EVERYTHING = """\
task: everything
description: "Every word once: é & <b>"
scene: household
params:
  tries: {type: int, default: 2, min: 1, max: 9, description: how often}
  where: {type: pose, default: above}
  side: {type: [left, right], default: left}
  factor: {default: 0.25}
  loud: {default: false}
  greeting: {type: text, default: "on"}
poses:
  above: {xyz: [1.1, -2, 3], rpy_deg: [180, 0, 33.3]}
  start: {base: [0, 1.5], heading_deg: 45}
  tucked: {joints_deg: [0, 1, 2, -80.5, 4, 90, 6]}
regions:
  table: {centre: [1, 2, 3], size: [1, 1.5, 1], yaw_deg: 30}
  shelf: {centre: [0, 0, 1], size: [0.5, 0.5, 0.25]}
tree:
  name: top
  timeout_s: 10.5
  retry: $tries
  sequence:
    - set: {start_count: 3, word: it is, flag: true, share: 0.5}
    - scan_for_objects: {region: table, count: found}
    - name: go there
      while: {at_least: {value: $found, least: 1}}
      delay_s: 0.0005
      navigate: {to: $where}
    - unless: {any_of: [arm_healthy, {not: arm_healthy}]}
      invert: true
      repeat: 2
      cooldown_s: 3
      fallback:
        - arm_healthy
        - all_of: [at_least: {value: $found, least: 2}, arm_healthy]
        - parallel: [holding_object, arm_healthy]
        - parallel: {policy: any, children: [holding_object, arm_healthy]}
        - parallel: {policy: 2, children: [holding_object, arm_healthy, arm_healthy]}
    - move_arm: {to: tucked}
      once: true
      force_success: true
    - fallback:
        - force_failure: true
          timeout_s: $factor
          recover:
        - equals: {value: $side, to: left}
    - forever:
        reactive_sequence:
          - arm_healthy
          - reactive_fallback:
              - holding_object
              - say: {text: "5"}
    - until:
        - equals: {value: $start_count, to: 3}
        - equals: {value: $word, to: it is}
        - equals: {value: $flag, to: $loud}
        - drive: {to: start}
        - say: {text: "{value} again", value: $greeting}
        - wait: {duration_s: $share}
        - add: {start_count: 2}
    - timeout_s: 5
      wait_until: {not: holding_object}
    - resuming_sequence: [open_gripper, arm_healthy]
    - for_each:
        item: place
        in: [table, shelf]
        do: {region_empty: {region: $place}}
    - switch:
        value: $start_count
        cases:
          "5": {say: {text: five}}
          "6": {say: {text: six}}
        else: {say: {text: other}}
    - name: count the shelf
      subtree: {file: parts/count.yaml, with: {where: shelf, pause_s: $share}, out: {total: more}}
    - at_least: {value: $more, least: 1}
"""

COUNT = """\
task: count
description: Look at a region and count.
params:
  where: {type: region, description: what to look at}
  pause_s: {default: 0.5}
outputs:
  total: how many there are
tree:
  sequence:
    - wait: {duration_s: $pause_s}
    - scan_for_objects: {region: $where, count: total}
"""


def write_everything(folder: Path) -> Path:
    """Write the task and the file that it includes; returns the task."""
    (folder / "parts").mkdir(exist_ok=True)
    (folder / "parts" / "count.yaml").write_text(COUNT, encoding="utf-8")
    path = folder / "everything.yaml"
    path.write_text(EVERYTHING, encoding="utf-8")
    return path
