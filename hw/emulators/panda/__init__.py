"""Emulated Franka Panda with its hand: interface version 5 of the arm and 3 of the hand."""

from hw.emulators.panda.arm import EmulatedArm
from hw.emulators.panda.console import ACTIONS, serve
from hw.emulators.panda.parts import ArmLink, Fingers, Joints, LaggedJoints, LinkedBody, Wanted
from hw.emulators.panda.reported import AS_REPORTED
from hw.emulators.panda.wire import MotionCommand
