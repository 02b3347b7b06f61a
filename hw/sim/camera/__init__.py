"""Simulated cameras: depth images by ray casting, depth noise, and images of printed pictures."""

from hw.sim.camera.noise import D435Noise
from hw.sim.camera.photograph import Grey, photograph
from hw.sim.camera.render import DepthRenderer, painted
