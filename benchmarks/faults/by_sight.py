"""Faults in the controllers that see with range beams, and in Q-learning.

The functions are in ``benchmarks/faults/faults_by_sight.c``.
"""

from __future__ import annotations

from sim.controllers.library.dynamic_window import dynamic_window
from sim.controllers.library.potential_field import potential_field
from sim.controllers.library.q_learning import q_learning
from sim.controllers.library.three_layer import three_layer
from sim.controllers.library.vfh import vfh
from sim.verdict import Verdict

from .planting import planted

three_layer_patience_starts_anew = planted(
    "three-layer-patience-starts-anew",
    three_layer,
    Verdict.LOOP,
    "The timer of a waypoint is reset in each step, so no waypoint is ever given up.",
)
three_layer_forgets_its_map = planted(
    "three-layer-forgets-its-map",
    three_layer,
    Verdict.LOOP,
    "The map is cleared with each new waypoint, so everything the robot has learned is lost.",
)
three_layer_columns_and_rows_swapped = planted(
    "three-layer-columns-and-rows-swapped",
    three_layer,
    Verdict.LOOP,
    "Swaps column and row when it looks up the robot's cell.",
)
three_layer_stale_target = planted(
    "three-layer-stale-target",
    three_layer,
    Verdict.LOOP,
    "On the last stretch, the heading of the target is still the one from the start.",
)
three_layer_turn_not_wrapped = planted(
    "three-layer-turn-not-wrapped",
    three_layer,
    Verdict.STALLED,
    "The turn is the difference of two headings, not wrapped at pi.",
)
vfh_turn_sign = planted(
    "vfh-turn-sign",
    vfh,
    Verdict.LOOP,
    "Turns the wrong way if the chosen direction is more than an eighth of a turn off.",
)
vfh_histogram_never_clears = planted(
    "vfh-histogram-never-clears",
    vfh,
    Verdict.LOOP,
    "A sector that was blocked once stays blocked: the lower threshold is never checked.",
)
vfh_beam_beyond_the_last = planted(
    "vfh-beam-beyond-the-last",
    vfh,
    Verdict.CRASH,
    "Finds the beam nearest to the target by a rounded index, which may be one past the last.",
)
potential_field_gap_in_whole_cells = planted(
    "potential-field-gap-in-whole-cells",
    potential_field,
    Verdict.CRASH,
    "Divides by the gap to the nearest wall in whole cells of the map, which may be 0.",
)
potential_field_never_slows = planted(
    "potential-field-never-slows",
    potential_field,
    Verdict.TUNNEL,
    "Keeps its top speed near walls, so it has passed them before it looks again.",
    variations="+motion=endpoint+time_step=0.3",
)
dynamic_window_brakes_for_the_target = planted(
    "dynamic-window-brakes-for-the-target",
    dynamic_window,
    Verdict.INVALID_COMMAND,
    "Brakes for the target by the square root of the distance minus 0.1 m, which may be negative.",
)
dynamic_window_speed_in_km_h = planted(
    "dynamic-window-speed-in-km-h",
    dynamic_window,
    Verdict.TUNNEL,
    "Sends its speed in km/h to wheels that expect m/s.",
    variations="+motion=endpoint+time_step=0.15",
)
q_learning_eighth_of_nine = planted(
    "q-learning-eighth-of-nine",
    q_learning,
    Verdict.CRASH,
    "Counts nine eighths to a full turn, so straight back on the right is past the table's end.",
)
q_learning_timer_off_by_one = planted(
    "q-learning-timer-off-by-one",
    q_learning,
    Verdict.LOOP,
    "Waits one step longer between two decisions than during training: a timer is off by one.",
)
q_learning_last_turn_lost = planted(
    "q-learning-last-turn-lost",
    q_learning,
    Verdict.LOOP,
    "Does not remember in which direction it last turned.",
)
