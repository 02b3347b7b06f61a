"""`python -m extensions.emulators.frankie ROBOT WORLD SCENE SEED LEVEL [NAME ...]`.

Emulators of a robot file. LEVEL is of the localisation, NAMEs are those of `AS_REPORTED`. Commands
on standard input, JSON on standard output.
"""

import sys

from extensions.emulators.frankie import FrankieEmulator, serve

if __name__ == "__main__":
    robot, world, scene, seed, level, *ways = sys.argv[1:]
    emulator = FrankieEmulator(
        robot, world=world, scene=scene, seed=int(seed), localisation=level, as_reported=ways
    )
    serve(emulator, lines=sys.stdin, say=lambda text: print(text, flush=True))
