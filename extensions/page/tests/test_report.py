"""`report`: how a run ended as a page to send and print."""

from html import escape

from command_line import call

from app.core import RunOptions, run_task
from app.review import explain

TASK = """\
task: toy
regions:
  floor: {centre: [0.7, 0.0, 0.3], size: [0.4, 0.4, 0.6]}
tree:
  sequence: [drive: {forward_m: 0.2}, {name: <b>, holding_object: }]
"""


def test_the_page_is_one_light_file_with_the_cause_first_and_a_map_with_the_way(tmp_path):
    task, out = tmp_path / "toy.yaml", tmp_path / "report.html"
    task.write_text(TASK)
    options = RunOptions(tree=task, scene="single", recording=False, record=tmp_path / "runs")
    told = explain(run_task(options).folder)
    assert call("report", told.record.folder, out)[0] == 0
    page = out.read_text()
    assert len(page) < 1_000_000
    assert "<script" not in page
    assert "http" not in page
    assert "<b>" not in page.partition("</style>")[2]
    cause = page.index(f'<p class="cause">{escape(told.headline)}')
    assert cause < page.index('<polyline class="track"') < page.index("What happened")
    assert '<polygon class="furniture"' in page
    assert '<polygon class="region"' in page
