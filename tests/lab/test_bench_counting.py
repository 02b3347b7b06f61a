"""`bench counting`, and the fit of what cuts things apart: the simulated world is the judge."""

import numpy as np

from lab.bench.choosing_scenes import CLUTTER, as_it_is, make_scene, seen_from_above
from lab.bench.counting import SETS, Counted, count, counting_table, run_counting
from lab.bench.seams import fit, mistakes, scene_seams


def test_every_scene_is_counted_and_a_seed_is_a_scene():
    counted = run_counting(range(3), workers=1, cluster=None)
    assert counted == [one for seed in range(3) for one in count(seed)]
    assert [(one.of, one.clutter) for one in counted] == [(of, c) for c in CLUTTER for of in SETS]
    assert all(5 <= one.objects <= 8 for one in counted)


def test_too_many_and_too_few_count_against_it():
    counted = [Counted("household", "apart", 5, n) for n in (4, 5, 6, 6)]
    columns = counting_table(counted).columns
    first = [next(iter(column.cells)) for column in columns]
    assert first[1] == "4"
    assert first[2].startswith("25.0 ")
    assert first[3:] == ["2", "1"]


def test_the_judge_measures_an_object_where_the_renderer_shows_it():
    world, _, _ = make_scene(0)
    frame, owner = seen_from_above(world, np.random.default_rng(0))
    for number, obj in enumerate(world.objects):
        rows, columns = np.nonzero(owner == number)
        ray = (columns.mean() - frame.intrinsics.cx, rows.mean() - frame.intrinsics.cy)
        depth = frame.wTc.translation[2] - obj.pose.translation[2]
        seen = frame.wTc.act(depth * np.array([*(np.array(ray) / frame.intrinsics.fx), 1.0]))
        assert np.linalg.norm(seen[:2] - as_it_is(obj).middle) < 0.02


def test_the_fit_finds_seams_between_things_and_is_the_same_again():
    seams = [one for seed in range(100_000, 100_024) for one in scene_seams(seed)]
    assert {one.right for one in seams} == {True, False}
    assert not any(one.right for one in seams if not one.many)
    model, again = fit(seams), fit(seams)
    assert all(
        (a == b).all()
        for one, other in zip(model.layers, again.layers, strict=True)
        for a, b in zip(one, other, strict=True)
    )
    pieces = {one.piece: one.many for one in seams}
    never_cut = sum(pieces.values())
    assert min(mistakes(model, seams).values()) < never_cut / 2
