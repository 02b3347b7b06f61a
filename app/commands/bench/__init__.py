"""`frankie-task bench ...`: the commands of the benches."""

import typer

from app.commands.bench.choosing import choosing, counting, kinds
from app.commands.bench.experiments import moving, poses, reach
from app.commands.bench.faults import faults, signals, soak
from app.commands.bench.obstacles import obstacles
from app.commands.bench.on_the_move import on_the_move
from app.commands.bench.pick_place import pick_place
from app.commands.bench.regenerate import experiments
from app.commands.bench.timings import perception, start, step, tree, watch
from app.commands.bench.worlds import worlds

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
