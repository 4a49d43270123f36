"""Faults in the controllers that see by range beams, and in Q-learning."""

from __future__ import annotations

import math

from tests.reference.fuzz.planting import Act, Floats, seeded, unwrap_turn
from tests.reference.sim import layout
from tests.reference.sim.controllers import three_layer as layers
from tests.reference.sim.controllers import vfh as histogram
from tests.reference.sim.controllers._directions import target_bearing
from tests.reference.sim.controllers.q_learning import SITUATIONS, TURNED, WAIT, situation

_CELL = 0.1  # m: in the families' worlds


@seeded("three-layer")
def three_layer_patience_starts_anew(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """The timer of a waypoint is set to 0 in each step, so no waypoint is ever given up."""
    memory[layers.WAITED] = 0.0
    base(observation, memory, command)


@seeded("three-layer")
def three_layer_forgets_its_map(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """The map is cleared with each new waypoint, so everything the robot has learned is lost."""
    to_x = memory[layers.TO_X]
    to_y = memory[layers.TO_Y]
    base(observation, memory, command)
    if memory[layers.TO_X] != to_x or memory[layers.TO_Y] != to_y:
        for k in range(2 * layers.SIDE):
            memory[layers.RIGHT + k] = 0.0


@seeded("three-layer")
def three_layer_columns_and_rows_swapped(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """Swaps column and row when it looks up the robot's cell."""
    if memory[layers.LAID] != 0.0:
        x = observation[layout.OBS_X]
        y = observation[layout.OBS_Y]
        observation[layout.OBS_X], observation[layout.OBS_Y] = y, x
    base(observation, memory, command)


@seeded("three-layer")
def three_layer_stale_target(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """On the last stretch, the heading of the target is still the one from the start."""
    if memory[layers.MEMORY] == 0.0:
        memory[layers.MEMORY], memory[layers.MEMORY + 1] = (
            1.0,
            observation[layout.OBS_TARGET_HEADING],
        )
    observation[layout.OBS_TARGET_HEADING] = memory[layers.MEMORY + 1]
    base(observation, memory, command)


@seeded("three-layer")
def three_layer_turn_not_wrapped(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """The turn is the difference of two headings, not wrapped at pi."""
    base(observation, memory, command)
    unwrap_turn(observation, command)


@seeded("vfh")
def vfh_turn_sign(observation: Floats, memory: Floats, command: Floats, base: Act) -> None:
    """Turns the wrong way if the chosen direction is more than an eighth of a turn off."""
    base(observation, memory, command)
    if abs(command[layout.CMD_TURN_RATE] * observation[layout.OBS_TIME_STEP]) > 0.25 * math.pi:
        command[layout.CMD_TURN_RATE] = -command[layout.CMD_TURN_RATE]


@seeded("vfh")
def vfh_histogram_never_clears(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """A sector that was blocked once stays blocked: the lower threshold is never checked."""
    first = histogram.SECTORS + 1
    for k in range(histogram.SECTORS):
        if memory[first + k] != 0.0:
            memory[k] = 1.0
    base(observation, memory, command)
    for k in range(histogram.SECTORS):
        memory[first + k] = max(memory[first + k], memory[k])


@seeded("vfh")
def vfh_beam_beyond_the_last(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """Finds the beam nearest to the target by a rounded index.

    The index may be one past the last.
    """
    base(observation, memory, command)
    beams = observation.size - layout.OBS_SIZE
    bearing = target_bearing(observation) % (2.0 * math.pi)
    nearest = math.floor(bearing / (2.0 * math.pi) * beams + 0.5)
    if observation[layout.OBS_SIZE + nearest] < observation[layout.OBS_RADIUS]:
        command[layout.CMD_SPEED] = 0.0


@seeded("potential-field")
def potential_field_gap_in_whole_cells(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """Divides by the gap to the nearest wall in whole cells of the map, which may be 0."""
    base(observation, memory, command)
    nearest = observation[layout.OBS_SIZE]
    for k in range(layout.OBS_SIZE, observation.size):
        nearest = min(nearest, observation[k])
    cells = math.floor((nearest - observation[layout.OBS_RADIUS]) / _CELL)
    command[layout.CMD_SPEED] *= 1.0 - 0.1 / cells


@seeded("potential-field")
def potential_field_never_slows(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """Keeps its top speed near walls, so it has passed them before it looks again."""
    base(observation, memory, command)
    command[layout.CMD_SPEED] = observation[layout.OBS_TOP_SPEED]


@seeded("dynamic-window")
def dynamic_window_brakes_for_the_target(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """Brakes for the target by the square root of the distance minus 0.1 m.

    It may be negative.
    """
    base(observation, memory, command)
    rest = observation[layout.OBS_TARGET_DISTANCE] - 0.1
    stop = math.sqrt(rest) if rest >= 0.0 else math.nan
    if not command[layout.CMD_SPEED] < 20.0 * stop:
        command[layout.CMD_SPEED] = 20.0 * stop


@seeded("dynamic-window")
def dynamic_window_speed_in_km_h(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """Sends its speed in km/h to wheels that expect m/s."""
    base(observation, memory, command)
    command[layout.CMD_SPEED] *= 3.6


@seeded("q-learning")
def q_learning_eighth_of_nine(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """Counts nine eighths to a full turn, so straight back on the right is past the table's end."""
    number = situation(observation, memory)
    bearing = target_bearing(observation) % (2.0 * math.pi)
    if math.floor(bearing / (2.0 * math.pi) * 8.0 + 0.5) == 8:  # without the remainder
        number += 8 * 32
    if number >= SITUATIONS:
        raise IndexError("situation beyond the table")
    base(observation, memory, command)


@seeded("q-learning")
def q_learning_timer_off_by_one(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """Waits one step longer between two decisions than during training.

    A timer is off by one.
    """
    waited = memory[WAIT]
    base(observation, memory, command)
    if memory[WAIT] > waited:
        memory[WAIT] += 1.0


@seeded("q-learning")
def q_learning_last_turn_lost(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """Does not remember in which direction it last turned."""
    base(observation, memory, command)
    memory[TURNED] = 0.0
