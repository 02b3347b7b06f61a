"""Grasp detection from a depth image.

`detector` runs the pipeline: `view` is a frame along an approach, `network_input` crops it, a
network or another source of `candidates` proposes grasps, `refinement` tests them on the
`height_map` with `feasibility`, and `ranking` orders them. `tracker` follows one over frames.
"""
