"""`bench kinds`: the judge is the simulated world, and every object is counted once."""

from lab.bench.choosing_scenes import CLUTTER
from lab.bench.kinds import STRANGE, call, kinds_table, run_kinds
from perception import SHAPE_CLASSES


def test_every_object_is_counted_and_a_seed_is_a_scene():
    called = run_kinds(range(4), workers=1, cluster=None)
    assert called == [one for seed in range(4) for one in call(seed)]
    assert {one.scene for one in called} == {*CLUTTER, STRANGE}
    assert 20 <= len(called) <= 32
    assert {one.true for one in called} <= {*SHAPE_CLASSES, ""}
    table = kinds_table(called)
    counts = [int(count) for count in table.columns[1].cells]
    assert sum(counts[: len(SHAPE_CLASSES) + 1]) == len(called)


def test_what_is_called_wrongly_counts_against_it():
    (first, *others) = call(0)
    wrong = first._replace(true="box", called="ball")
    columns = kinds_table([wrong, *others]).columns
    rows = {row: number for number, row in enumerate(columns[0].cells)}
    boxes = sum(one.true == "box" for one in others) + 1
    share = list(columns[2].cells)[rows["box, all"]]
    assert not share.startswith("100.0")
    assert list(columns[1].cells)[rows["box, all"]] == str(boxes)
