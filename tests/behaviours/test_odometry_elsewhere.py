"""Odometry begins anywhere: hand and base go where things truly are."""

import numpy as np
from pinocchio import SE3, utils

from app.core import Instruments, RunOptions, run_task
from app.core.outcome import End
from hw.sim.localisation_errors import LocalisationProcess

OFF = SE3(utils.rotate("z", 0.3), np.array([0.4, -0.3, 0.0]))
"""Half a metre between odometry and map."""
TASK = """\
task: fetch
poses:
  above: {xyz: [2.935, 0.0, 0.85], rpy_deg: [180, 0, 0]}
  home: {base: [1.0, 0.6], heading_deg: 90}
regions:
  box: {centre: [3.0, 0.0, 0.556], size: [0.44, 0.36, 0.20]}
tree:
  sequence:
    - navigate: {to: above}
    - open_gripper
    - grasp: {within: box}
    - retreat_check
    - drive: {to: home}
"""


class Witness(Instruments):
    """Keeps the true world."""

    def begin(self, setup, nodes) -> None:
        self.truth = setup.truth


def test_a_grasp_and_a_drive_end_where_the_map_has_them(tmp_path, monkeypatch):
    begin, read = LocalisationProcess._begin, LocalisationProcess.read
    true, witness = [], Witness()

    def begin_elsewhere(self, stamp, oTb):
        begin(self, stamp, oTb)
        self._grid_oTb = OFF * oTb

    def noted(self, stamp, wTb):
        true.append(wTb)
        return read(self, stamp, wTb)

    monkeypatch.setattr(LocalisationProcess, "_begin", begin_elsewhere)
    monkeypatch.setattr(LocalisationProcess, "read", noted)
    task = tmp_path / "fetch.yaml"
    task.write_text(TASK)
    quiet = {"recording": False, "record": tmp_path / "runs"}
    options = RunOptions(tree=task, scene="single", localisation="good", **quiet)
    result = run_task(options, instruments=witness)
    assert result.outcome.end is End.SUCCESS, result.outcome.reason
    assert witness.truth.held is not None
    off = SE3(utils.rotate("z", np.pi / 2), np.array([1.0, 0.6, 0.0])).actInv(true[-1])
    assert np.linalg.norm(off.translation) < 0.1
    assert off.rotation[0, 0] > 0.99
