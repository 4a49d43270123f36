"""Boundaries: the value of one number of a scenario at which a controller begins to fail.

Contents:
    AXES, axis_of_field, Axis, Subject: what can be varied.
    index_of: the index of a number of three digits.
    Boundary, nearest_boundary: two neighbouring values, one at which the robot arrives and one at
        which it fails.
    run_subject: one run of a scenario, with a fresh proof.
    is_bounded, subject_of: the failures that can have a boundary.
    with_boundaries, describe_boundaries: the boundaries in a failure's record.
"""

from fuzz.boundary.axes import AXES, Axis, Subject, axis_of_field, index_of
from fuzz.boundary.measured import describe_boundaries, is_bounded, subject_of, with_boundaries
from fuzz.boundary.search import Boundary, BoundaryRun, BoundaryRuns, nearest_boundary, run_subject

__all__ = [
    "AXES",
    "Axis",
    "Boundary",
    "BoundaryRun",
    "BoundaryRuns",
    "Subject",
    "axis_of_field",
    "describe_boundaries",
    "index_of",
    "is_bounded",
    "nearest_boundary",
    "run_subject",
    "subject_of",
    "with_boundaries",
]
