"""`python -m hw.emulators.frankie ROBOT WORLD SCENE SEED [NAME,...]`: an emulated robot of a file.

Arm and hand behave as reported, by names of `hw.emulators.panda.AS_REPORTED`. Words come in, lines
of JSON go out; it ends with its input.
"""

from __future__ import annotations

import sys

from hw.emulators.frankie import FrankieEmulator, serve

if __name__ == "__main__":
    robot, world, scene, seed = sys.argv[1:5]
    names = sys.argv[5].split(",") if len(sys.argv) > 5 else ()
    emulator = FrankieEmulator.of(
        robot, world=world, scene=scene, seed=int(seed), as_reported=names
    )
    serve(emulator, lines=sys.stdin, say=lambda text: print(text, flush=True))
