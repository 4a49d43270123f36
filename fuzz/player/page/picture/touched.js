// The sides of walls that the robots touch, and the step of the first touch.

import { SOLID, cellsAt, openRun, openWorld, stateAt } from "#player/decode.js";
import { MARKS } from "#player/picture/marks.js";
import { stroke } from "#player/picture/pen.js";

const SAME = 0.03; // cells: walls whose distances differ by less are touched together
const NEAR = 0.5; // cells: a wall farther away is not touched

// Returns the sides of wall cells that the robot touches: of those nearest to its body at a bump
// the sides that face it, each with the first and the last such step.
function touchedSides(world, run) {
  const open = openRun(run);
  if (open.touched) return open.touched;
  open.touched = new Map();
  for (let row = 0; row < open.at.length; row += 1) {
    if (!open.bump[row]) continue;
    const cells = cellsAt(world, open.at[row] * run.dt * 1000);
    for (const [ix, iy] of nearestWalls(cells, world, open.x[row], open.y[row], open.heading[row])) {
      const across = open.x[row] < ix ? -1 : Number(open.x[row] > ix + 1),
        up = open.y[row] < iy ? -1 : Number(open.y[row] > iy + 1);
      for (const [dx, dy] of [[across, 0], [0, up]]) {
        // Between two walls there is nothing to touch.
        if ((dx === 0 && dy === 0) || stateAt(cells, world, ix + dx, iy + dy) === SOLID) continue;
        const key = `${ix},${iy},${dx},${dy}`,
          known = open.touched.get(key);
        if (known) known.last = open.at[row];
        else open.touched.set(key, { ix, iy, dx, dy, step: open.at[row], last: open.at[row] });
      }
    }
  }
  return open.touched;
}

function nearestWalls(cells, world, x, y, heading) {
  const reach = Math.min(40, Math.ceil(world.radius) + 1),
    found = [],
    gapTo = world.footprint ? gapOfBody(world.footprint, x, y, heading) : gapOfDisc(world.radius, x, y);
  let least = NEAR;
  for (let iy = Math.floor(y) - reach; iy <= Math.floor(y) + reach; iy += 1) {
    for (let ix = Math.floor(x) - reach; ix <= Math.floor(x) + reach; ix += 1) {
      if (stateAt(cells, world, ix, iy) !== SOLID) continue;
      const gap = gapTo(ix, iy);
      found.push([ix, iy, gap]);
      least = Math.min(least, gap);
    }
  }
  return found.filter(([, , gap]) => gap <= least + SAME && gap <= NEAR);
}

const gapOfDisc = (radius, x, y) => (ix, iy) => Math.hypot(Math.max(ix - x, 0, x - ix - 1), Math.max(iy - y, 0, y - iy - 1)) - radius;

// Returns a function of a cell: the largest gap between it and a polygon along an axis of either,
// as in the pictures in files.
function gapOfBody(footprint, x, y, heading) {
  const cos = Math.cos(heading),
    sin = Math.sin(heading);
  const corners = footprint.map(([ahead, left]) => [x + ahead * cos - left * sin, y + ahead * sin + left * cos]);
  const sides = corners.map(([a, b], k) => {
    const [c, d] = corners[(k + 1) % corners.length],
      length = Math.hypot(c - a, d - b),
      across = (d - b) / length,
      up = (a - c) / length;
    return [across, up, across * a + up * b];
  });
  const low = [0, 1].map((axis) => Math.min(...corners.map((corner) => corner[axis]))),
    high = [0, 1].map((axis) => Math.max(...corners.map((corner) => corner[axis])));
  return (ix, iy) => Math.max(
    ix - high[0], low[0] - ix - 1, iy - high[1], low[1] - iy - 1,
    ...sides.map(([across, up, offset]) => ix * across + iy * up + Math.min(across, 0) + Math.min(up, 0) - offset),
  );
}

/**
 * Draws a line along each side of a wall that is touched: in a still picture of a loop, of those
 * that it repeats.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {SceneRobot[]} robots
 * @param {boolean} isWhole
 */
export function drawTouched(pen, world, robots, isWhole) {
  const { context, px, py, colours } = pen;
  const width = Math.min(MARKS.touched.width * pen.unit, 0.4 * pen.scale),
    inset = width / 2 / pen.scale,
    reach = 0.5 - inset,
    along = 0.5 - 0.6 * inset;
  for (const { run, step: now, radius, footprint } of robots) {
    const touched = [...touchedSides({ ...world, open: openWorld(world), radius, footprint }, run).values()],
      entry = isWhole && run.loop ? run.loop[0] : 0,
      repeated = touched.filter(({ last }) => last > entry);
    for (const { ix, iy, dx, dy, step } of repeated.length > 0 ? repeated : touched) {
      if (!isWhole && step > now) continue;
      // Just inside the wall, from one of its corners to the next, where a round end of the next begins.
      const [x, y] = [ix + 0.5 + reach * dx, iy + 0.5 + reach * dy];
      context.beginPath();
      context.moveTo(px(x - along * Math.abs(dy)), py(y - along * Math.abs(dx)));
      context.lineTo(px(x + along * Math.abs(dy)), py(y + along * Math.abs(dx)));
      stroke(pen, colours[MARKS.touched.colour], width);
    }
  }
}
