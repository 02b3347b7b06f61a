"""What `recover` does with a fault: a pause that grows, the way from what was hit, a memory."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from harness import FOLDED_A_LITTLE, REFLEX, Harness, block, looking_down, table_world
from pinocchio import SE3
from py_trees.common import Status

from behaviours import BasePose, Navigate, Recover
from hw import Fault, FaultKind
from hw.sim import Walker, World
from robots import Box, Geom, Plane

FLOOR = Geom(Plane(), SE3.Identity(), "floor")
BEYOND = BasePose(name="beyond", wTb=SE3(np.eye(3), np.array([2.5, 0.0, 0.0])))
