"""`python -m hw.emulators.frankie ROBOT WORLD SCENE SEED [NAME ...]`: emulators of a robot file.

NAMEs are those of `AS_REPORTED`. Commands on standard input, JSON on standard output.
"""

from __future__ import annotations

import sys

from hw.emulators.frankie import FrankieEmulator, serve

if __name__ == "__main__":
    robot, world, scene, seed, *ways = sys.argv[1:]
    emulator = FrankieEmulator(robot, world=world, scene=scene, seed=int(seed), as_reported=ways)
    serve(emulator, lines=sys.stdin, say=lambda text: print(text, flush=True))
