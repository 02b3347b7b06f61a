"""`frankie-task bench ...`: the commands of the benches."""

import typer

from lab.bench.commands.measures import experiments, perception, step
from lab.bench.commands.motions import moving, obstacles, poses, reach
from lab.bench.commands.whole_tasks import faults, on_the_move, pick_place, uncertainty, untruth

app = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Measure: the paper's experiments, obstacles, whole tasks, faults, times of the parts.",
)
_MOTIONS = (reach, poses, moving, obstacles)
_TASKS = (pick_place, on_the_move, uncertainty, faults, untruth)
for command in (*_MOTIONS, *_TASKS, step, perception, experiments):
    app.command(command.__name__.replace("_", "-"))(command)
