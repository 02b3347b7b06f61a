"""`python -m hw.emulators.frankie ROBOT WORLD SCENE SEED [WAY ...]`: an emulated robot of a file.

Its parts behave in the reported ways of these names. Words come in, lines of JSON go out; it ends
with its input.
"""

from __future__ import annotations

import sys

from hw.emulators.frankie import FrankieEmulator, serve

if __name__ == "__main__":
    robot, world, scene, seed, *ways = sys.argv[1:]
    emulator = FrankieEmulator.of(robot, world=world, scene=scene, seed=int(seed), as_reported=ways)
    serve(emulator, lines=sys.stdin, say=lambda text: print(text, flush=True))
