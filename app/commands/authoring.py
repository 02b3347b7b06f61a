"""Commands for authors of tasks: nodes, draw, schema, new, teach, reach, dry."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.choices import Form
from app.commands.refuse import find_tree, refuse, task_parameters, write
from app.terminal import Terminal, visible

authoring = typer.Typer()

Tree = Annotated[str, typer.Argument(help="A task file, or the name of a shipped task.")]
Output = Annotated[
    Path | None, typer.Option("--output", "-o", help="A file, instead of the screen.")
]


_TILTS = (0, 20, 40, 60, 90)  # of a hand, in the table of what it reaches [deg]
_HEIGHTS = (0.1, 0.3, 0.5, 0.7, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4)  # [m]


@authoring.command()
def nodes(name: Annotated[str | None, typer.Argument(help="One of them, in full.")] = None) -> None:
    """What a task can be made of: leaves, composites, modifiers, with their parameters."""
    from app.authoring import all_words, one_word

    lines = one_word(name) if name else all_words(about=True, parameters=False)
    Terminal().say("\n".join(lines))


@authoring.command()
def draw(tree: Tree, output: Output = None) -> None:
    """The tree of a task as indented text."""
    from trees.draw import tree_text
    from trees.language import load

    task = load(find_tree(tree), open_parameters=True)
    _deliver(visible(tree_text(task.root)), output)


@authoring.command()
def schema(output: Output = None) -> None:
    """The JSON Schema of task files, for an editor: completion, help, diagnostics underlined."""
    from trees import schema_text
    from trees.language import describe_leaves, known_leaves

    text = schema_text(describe_leaves(known_leaves()))
    _deliver(text, output)


@authoring.command()
def new(
    name: Annotated[str, typer.Argument(help="The name of the task.")],
    folder: Annotated[Path, typer.Option("--folder", help="Where to put it.")] = Path("."),
) -> None:
    """Begin a task: a commented file that runs as it is, and the schema for the editor."""
    from trees import new_files

    files = new_files(name)
    task, *helpers = [folder / file for file in files]
    if task.exists():
        refuse(f"{task}: already exists; choose another name, or remove it first")
    for path, text in zip((task, *helpers), files.values(), strict=True):
        if path == task or not path.exists():
            write(path, text)
    typer.echo(f"{task}: change it, then: frankie-task check {task}; frankie-task run {task}")


@authoring.command()
def teach(
    name: Annotated[str, typer.Argument(help="Of the pose.")],
    places: Annotated[Path, typer.Option(help="The file that takes it.")] = Path("places.yaml"),
    robot: Annotated[str, typer.Option(help="Whose pose: a shipped robot or a robot file.")] = (
        "frankie"
    ),
    world: Annotated[str, typer.Option(help="What moves it, if it is not real.")] = "kinematic",
    form: Annotated[Form, typer.Option("--of", help="What of it.")] = Form.HAND,
    path: Annotated[
        bool, typer.Option("--path", help="Several poses, one each time that Enter is pressed.")
    ] = False,
    replace: Annotated[bool, typer.Option("--replace", help="The pose of this name.")] = False,
    armed: Annotated[
        bool, typer.Option("--arm-the-robot", help="A real robot is connected only with this.")
    ] = False,
) -> None:
    """Write where the robot is now, or a path, into a file of places; nothing moves."""
    from app.authoring import teach as write
    from app.core import End
    from hw import HardwareError

    def more() -> bool:
        question = "Enter where the next pose is, q after the last"
        return str(typer.prompt(question, default="", show_default=False)) != "q"

    try:
        line = write(
            name,
            places,
            robot=robot,
            world=world,
            form=form,
            replace=replace,
            armed=armed,
            more=more if path else None,
        )
    except HardwareError as error:
        Terminal(stderr=True).say(str(error))
        raise typer.Exit(End.HARDWARE.exit_code) from None
    typer.echo(f"{places}: {line}")


@authoring.command()
def reach(
    robot: Annotated[str, typer.Option(help="Whose: a shipped robot or a robot file.")] = "frankie",
    height: Annotated[
        float | None, typer.Option(help="Of the point between the finger tips [m].", min=0.0)
    ] = None,
) -> None:
    """How far from the middle of the base the hand gets, by its height and tilt."""
    import numpy as np
    from rich.table import Table

    from controller import farthest
    from robots import load_robot

    description = load_robot(robot)
    heights = _HEIGHTS if height is None else (height,)
    table = Table("height [m]", *(f"{tilt}°" for tilt in _TILTS), box=None, pad_edge=False)
    for up in heights:
        far = (farthest(description, up, float(np.deg2rad(tilt))) for tilt in _TILTS)
        table.add_row(f"{up:.2f}", *(f"{most:.2f}" if most > 0.0 else "-" for most in far))
    front = description.base.size[0] / 2.0
    terminal = Terminal()
    terminal.print(table)
    terminal.say(
        f"Metres from the middle of the base of {description.name} to the point between the finger "
        f"tips; the hand is tilted outwards by 0° (straight down) to 90° (level). The base itself "
        f"reaches {front:.2f} m forwards."
    )


def _deliver(text: str, output: Path | None) -> None:
    if output is None:
        typer.echo(text, nl=False)
    else:
        write(output, text)
        typer.echo(f"{output}: written")


def dry(
    tree: Annotated[str, typer.Argument(help="A task file, or the name of a shipped task.")],
    outcome: Annotated[
        list[str] | None,
        typer.Option(help="What a leaf answers in turn, as grasp=failure,failure,success."),
    ] = None,
    key: Annotated[
        list[str] | None, typer.Option(help="What leaves write to a key, as found=3.")
    ] = None,
    parameter: Annotated[
        list[str] | None, typer.Option("--parameter", "-p", help="A task parameter, key=value.")
    ] = None,
    places: Annotated[Path | None, typer.Option(help="Poses and regions of a site.")] = None,
    watch: Annotated[
        bool, typer.Option("--watch", help="Do it anew whenever the task is saved.")
    ] = False,
) -> None:
    """Try the logic of a task without a robot: leaves end at once, as you say."""
    from app.authoring import again_on_save, dry_run

    path, parameters = find_tree(tree), task_parameters(parameter or [])
    codes: list[int] = []

    def act() -> None:
        result = dry_run(
            path, outcomes=outcome or [], keys=key or [], overrides=parameters, places=places
        )
        typer.echo(visible(result.to_text()))
        codes.append(result.outcome.end.exit_code)

    if watch:
        again_on_save(path, parameters, places, act=act, say=Terminal(stderr=True).say)
    else:
        act()
    raise typer.Exit(codes[-1] if codes else 2)
