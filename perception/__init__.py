"""From a depth frame to a tracked grasp.

`GraspDetector` turns one depth frame into ranked grasps in the world: a network proposes
candidates, which are refined and tested for feasibility on the measured depth. `GraspTracker`
tracks one grasp over frames. The networks and their training are in `perception.networks`, a room
with a face of its own, because it imports torch; this one does not.
"""

from typing import TYPE_CHECKING

from config import lazy_face

if TYPE_CHECKING:
    from perception.frame import Workspace
    from perception.frame_check import FrameChecker, frame_problem
    from perception.geometry import disc, points_along_rays, world_points
    from perception.grasp import Detection, GraspEstimate
    from perception.grasps.candidates import WITHOUT_NETWORK, Candidates, Proposals
    from perception.grasps.detector import GraspDetector
    from perception.grasps.feasibility import assess
    from perception.grasps.hand_geometry import hand_sizes
    from perception.grasps.height_map import HeightMap, build_height_map
    from perception.grasps.network_input import (
        ANGLE_BINS,
        OUTPUT_STRIDE,
        WeightsError,
        prepare,
        scaled_crop,
    )
    from perception.grasps.patches import NUMBERS, GraspPatches, HoldProbability, joined_patches
    from perception.grasps.scene_memory import SceneMemory
    from perception.grasps.tracker import GraspTracker
    from perception.objects.boundaries import (
        BOUNDARY_FEATURES,
        boundary_features,
        candidate_boundaries,
    )
    from perception.objects.classes import known_classes, with_classes
    from perception.objects.colours import ColourName, colour_name
    from perception.objects.detected_object import DetectedObject, DetectedObjects
    from perception.objects.recogniser import Labelled, Recogniser, RecogniserError
    from perception.objects.segmentation import consensus, raised_regions, segment_objects
    from perception.objects.touching import BoundaryModel, blob_of, log_features
    from perception.region_map import WALL_MARGIN, RegionMap, Segment
    from perception.surface_grid import SurfaceGrid, surface_cells
    from perception.training_samples import Labels, Sample, Shard
else:
    __getattr__ = lazy_face(__name__)
