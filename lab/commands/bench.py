"""`frankie-task bench ...`: the commands of the benches."""

import typer

from lab.commands.choosing import choosing, counting, kinds
from lab.commands.experiments import moving, poses, reach
from lab.commands.faults import faults, signals, soak
from lab.commands.obstacles import obstacles
from lab.commands.on_the_move import on_the_move
from lab.commands.pick_place import pick_place
from lab.commands.regenerate import experiments
from lab.commands.timings import perception, start, step, tree, watch
from lab.commands.worlds import worlds

bench = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Measure: time of a control step and of the tree, the paper's experiments, the main task.",
)
_GOALS = (reach, poses, moving, obstacles)
_TASKS = (pick_place, on_the_move, worlds, choosing, counting, kinds, experiments)
_TIMINGS = (step, tree, perception, watch, start)
_TROUBLES = (faults, signals, soak)
for command in (*_GOALS, *_TASKS, *_TIMINGS, *_TROUBLES):
    bench.command(command.__name__.replace("_", "-"))(command)

__all__ = ["bench"]
