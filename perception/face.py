"""The names of `perception` that need numpy: imported at the first use of one."""

from perception.cloud import DepthCloud
from perception.detected_grasp import Detection, GraspEstimate
from perception.frame import Workspace
from perception.frame_check import FrameChecker, frame_problem
from perception.geometry import disc, world_points
from perception.grasps.candidates import Candidates, CandidateSource, Proposals, SpreadPoints
from perception.grasps.detector import GraspDetector
from perception.grasps.feasibility import assess
from perception.grasps.hand_geometry import hand_sizes
from perception.grasps.height_map import HeightMap, build_height_map
from perception.grasps.network_input import (
    ANGLE_BINS,
    GRID_SIZE,
    OUTPUT_STRIDE,
    WIDTH_SCALE,
    WeightsError,
    prepare,
    scaled_crop,
)
from perception.grasps.patches import (
    FAR_SHAPE,
    NEAR_SHAPE,
    NUMBERS,
    GraspPatches,
    HoldProbability,
)
from perception.grasps.scene_memory import SceneMemory
from perception.grasps.tracker import GraspTracker
from perception.networks.ggcnn import GGCNN, load_ggcnn, subpixel_taps
from perception.networks.hold import (
    HOLD_NUMBERS,
    HoldInputs,
    hold_inputs,
    load_hold,
    shipped_hold,
)
from perception.networks.weights import read_weights
from perception.objects.boundaries import (
    BOUNDARY_FEATURES,
    boundary_features,
    candidate_boundaries,
)
from perception.objects.classes import known_classes, with_classes
from perception.objects.colours import ColourName, colour_name, differ
from perception.objects.recogniser import Labelled, Recogniser, RecogniserError
from perception.objects.segmentation import consensus, raised_regions, segment_objects
from perception.objects.touching_objects import BoundaryModel, blob_of, log_features
from perception.region_map import WALL_MARGIN, RegionMap, Segment
from perception.surface_grid import SurfaceGrid, surface_cells
