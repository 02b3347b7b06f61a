"""Faults on request: what a task does when robot, camera or world do not do what they should.

The world `faulty` is a robot of another world that can be given faults; the observer `faults` gives
them at times or in phases of the task.
"""

from extensions.faults.injection import INJECTABLE, with_faults
from extensions.faults.schedule import PHASES
