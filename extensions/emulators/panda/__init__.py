"""Emulated Franka Panda with its hand: interface version 5 of the arm and 3 of the hand."""

from extensions.emulators.panda.console import ACTIONS, serve
from extensions.emulators.panda.emulated_arm import EmulatedArm
from extensions.emulators.panda.joints_and_fingers import ArmLink, LaggedJoints, LinkedBody, Wanted
from extensions.emulators.panda.reported import AS_REPORTED
from extensions.emulators.panda.wire import MotionCommand
