// What a run's plots show: speed, distance to the target and clearance,
// one value for each row of the run.

import { FREE, cellsAt, openRun, stateAt } from "#player/decode.js";

const FAR = 4; // largest clearance to look for, cells; anything farther away counts as this far

/**
 * Returns the series of a run, each with its unit, computed once.
 * @param {SceneWorld} world
 * @param {DrawnRun} run
 * @param {Pick<SceneWorld, "target" | "radius" | "footprint">} [robot] - Whose run it is; the
 *   world's first robot if omitted
 * @returns {Series[]}
 */
export function seriesOf(world, run, robot = world) {
  const open = openRun(run);
  if (open.series) return open.series;
  const side = world.cell ?? 1,
    count = open.at.length;
  const speed = new Float64Array(count),
    distance = new Float64Array(count),
    clearance = new Float64Array(count);
  const [targetX, targetY, reach] = robot.target;
  for (let row = 0; row < count; row += 1) {
    const x = open.x[row],
      y = open.y[row];
    if (row > 0) speed[row] = speedAt(open, row, run.dt) * side;
    distance[row] = Math.max(0, Math.hypot(x - targetX, y - targetY) - reach) * side;
    const cells = cellsAt(world, open.at[row] * run.dt * 1000);
    clearance[row] = clearanceAt(world, cells, robot, { x, y, heading: open.heading[row] }) * side;
  }
  if (count > 1) speed[0] = speed[1];
  const series = (name, unit, values, capped = false) => ({ name, unit, values, capped, ...rangeOf(values) });
  open.series = [series("Speed", "m/s", speed), series("Distance to the target", "m", distance), series("Clearance", "m", clearance, true)];
  return open.series;
}

// Returns the least and the greatest value; 0 is always between them.
function rangeOf(values) {
  let least = 0,
    most = 0;
  for (const value of values) {
    least = Math.min(least, value);
    most = Math.max(most, value);
  }
  return { least, most };
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

/**
 * Returns the distance in cells from the edge of the robot's body to the nearest wall or fire;
 * negative by how deep it is in one.
 * @param {SceneWorld} world
 * @param {Uint8Array} cells
 * @param {Pick<SceneWorld, "radius" | "footprint">} robot
 * @param {{x: number, y: number, heading: number}} pose
 */
function clearanceAt(world, cells, { radius, footprint }, pose) {
  const corners = footprint && placed(footprint, pose);
  const reach = Math.min(40, Math.ceil(radius + FAR));
  const { x, y } = pose;
  let least = FAR;
  for (let iy = Math.floor(y) - reach; iy <= Math.floor(y) + reach; iy += 1) {
    for (let ix = Math.floor(x) - reach; ix <= Math.floor(x) + reach; ix += 1) {
      if (stateAt(cells, world, ix, iy) === FREE) continue;
      // In a cell, the disc's centre is as deep as it is away from the nearest side.
      const dx = Math.max(ix - x, x - ix - 1),
        dy = Math.max(iy - y, y - iy - 1);
      const centre = dx > 0 || dy > 0 ? Math.hypot(Math.max(dx, 0), Math.max(dy, 0)) : Math.max(dx, dy);
      // No part of a body is farther from its centre than its radius.
      if (centre - radius >= least) continue;
      least = Math.min(least, corners ? polygonToCell(corners, ix, iy) : centre - radius);
    }
  }
  return least;
}

// Returns the corners of a footprint at a pose.
function placed(footprint, { x, y, heading }) {
  const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
  return footprint.map(([a, b]) => [x + a * cos - b * sin, y + a * sin + b * cos]);
}

// Returns the distance between a convex polygon and a cell; negative by how far one of them would
// have to be moved apart, after the separating axis theorem.
function polygonToCell(corners, ix, iy) {
  const cell = [[ix, iy], [ix + 1, iy], [ix + 1, iy + 1], [ix, iy + 1]];
  let apart = -Infinity;
  for (const shape of [corners, cell])
    for (const [[ax, ay], [bx, by]] of edgesOf(shape)) {
      const length = Math.hypot(bx - ax, by - ay);
      const along = (/** @type {number[]} */ [x, y]) => ((by - ay) * x - (bx - ax) * y) / length;
      const own = corners.map(along),
        other = cell.map(along);
      apart = Math.max(apart, Math.min(...other) - Math.max(...own), Math.min(...own) - Math.max(...other));
    }
  if (apart <= 0) return apart;
  const reaches = (points, shape) => points.flatMap((point) => edgesOf(shape).map((edge) => pointToEdge(point, edge)));
  return Math.min(...reaches(corners, cell), ...reaches(cell, corners));
}

const edgesOf = (shape) => shape.map((corner, k) => [corner, shape[(k + 1) % shape.length]]);

function pointToEdge([x, y], [[ax, ay], [bx, by]]) {
  const [dx, dy] = [bx - ax, by - ay];
  const share = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)));
  return Math.hypot(x - ax - share * dx, y - ay - share * dy);
}
