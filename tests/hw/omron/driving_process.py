"""Drives an emulated base until it is killed: `driving_process.py PORT`."""

import sys
import time

import numpy as np

from hw import WallClock
from hw.omron import OmronBase, OmronSettings

base = OmronBase(
    OmronSettings(host="127.0.0.1", port=int(sys.argv[1]), user="frankie"), WallClock()
)
base.connect()
print(base.guardian_pid, flush=True)
while True:
    base.read()
    base.send(np.array([0.15, 0.0, 0.0]))
    time.sleep(0.01)
