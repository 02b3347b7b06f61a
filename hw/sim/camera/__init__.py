"""Simulated depth cameras: images by ray casting, and their noise."""

from hw.sim.camera.noise import D435Noise
from hw.sim.camera.render import DepthRenderer, painted
