// What a run's plots show: speed, distance to the target and clearance,
// one value for each row of the run.

import { FREE, cellsAt, openRun, stateAt } from "#player/decode.js";

const FAR = 4; // largest clearance to look for, cells; anything farther away counts as this far

/**
 * Returns the series of a run, each with its unit, computed once.
 * @param {SceneWorld} world
 * @param {DrawnRun} run
 * @returns {{name: string, unit: string, most: number, values: Float64Array, capped: boolean}[]}
 */
export function seriesOf(world, run) {
  const open = openRun(run);
  if (open.series) return open.series;
  const side = world.cell ?? 1,
    count = open.at.length;
  const speed = new Float64Array(count),
    distance = new Float64Array(count),
    clearance = new Float64Array(count);
  const [targetX, targetY, reach] = world.target;
  for (let row = 0; row < count; row += 1) {
    const x = open.x[row],
      y = open.y[row];
    if (row > 0) speed[row] = speedAt(open, row, run.dt) * side;
    distance[row] = Math.max(0, Math.hypot(x - targetX, y - targetY) - reach) * side;
    clearance[row] = clearanceAt(world, cellsAt(world, open.at[row] * run.dt * 1000), x, y) * side;
  }
  if (count > 1) speed[0] = speed[1];
  const series = (name, unit, values, capped = false) => ({ name, unit, values, capped, most: values.reduce((most, value) => Math.max(most, value), 0) });
  open.series = [series("Speed", "m/s", speed), series("Distance to the target", "m", distance), series("Clearance", "m", clearance, true)];
  return open.series;
}

// Returns the speed up to a row, cells/s, over at least one step, because rounding would distort it
// between two contacts.
function speedAt({ at, x, y }, row, dt) {
  let first = row,
    path = 0;
  do {
    first -= 1;
    path += Math.hypot(x[first + 1] - x[first], y[first + 1] - y[first]);
  } while (first > 0 && at[row] - at[first] < 1);
  const passed = (at[row] - at[first]) * dt;
  return passed > 0 ? path / passed : 0;
}

// Returns the distance in cells from the edge of the robot's disc to the nearest wall
// or fire; negative inside one.
function clearanceAt(world, cells, x, y) {
  const reach = Math.min(40, Math.ceil(world.radius + FAR));
  let least = world.radius + FAR;
  for (let iy = Math.floor(y) - reach; iy <= Math.floor(y) + reach; iy += 1) {
    for (let ix = Math.floor(x) - reach; ix <= Math.floor(x) + reach; ix += 1) {
      if (stateAt(cells, world, ix, iy) === FREE) continue;
      const dx = Math.max(ix - x, 0, x - ix - 1),
        dy = Math.max(iy - y, 0, y - iy - 1);
      least = Math.min(least, Math.hypot(dx, dy));
    }
  }
  return least - world.radius;
}
