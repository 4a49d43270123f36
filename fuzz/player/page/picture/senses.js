// The robot's senses: range beams, straight from its centre to the first wall and without sensor
// noise, and the bearing of the target.
// Source: John Amanatides and Andrew Woo, "A fast voxel traversal algorithm for ray tracing",
// Eurographics 1987.

import { SOLID, stateAt } from "#player/decode.js";
import { strokeMark } from "#player/picture/pen.js";

function beamHeadings(heading, sensors) {
  const { beams, field } = sensors;
  const turn = 2 * Math.PI;
  return Array.from({ length: beams }, (_, k) => {
    if (field === 0 || field >= turn) return heading + (k * turn) / beams;
    return beams === 1 ? heading : heading + (k / (beams - 1) - 0.5) * field;
  });
}

function castBeam(cells, world, x, y, heading, longest) {
  const dx = Math.cos(heading),
    dy = Math.sin(heading);
  const stepX = dx > 0 ? 1 : -1,
    stepY = dy > 0 ? 1 : -1;
  const perX = dx === 0 ? Infinity : Math.abs(1 / dx),
    perY = dy === 0 ? Infinity : Math.abs(1 / dy);
  let ix = Math.floor(x),
    iy = Math.floor(y);
  let toX = dx === 0 ? Infinity : (dx > 0 ? ix + 1 - x : x - ix) * perX;
  let toY = dy === 0 ? Infinity : (dy > 0 ? iy + 1 - y : y - iy) * perY;
  // Go from cell to cell, always across the nearer of the next two cell borders.
  let distance = 0;
  while (distance < longest) {
    if (toX < toY) {
      distance = toX;
      ix += stepX;
      toX += perX;
    } else {
      distance = toY;
      iy += stepY;
      toY += perY;
    }
    if (stateAt(cells, world, ix, iy) === SOLID) break;
  }
  distance = Math.min(distance, longest);
  return [x + dx * distance, y + dy * distance];
}

/**
 * @param {Pen} pen
 * @param {RunScene & {sensors: Sensors}} scene
 * @param {Uint8Array} cells
 * @param {Pose} pose
 */
export function drawBeams(pen, { world, sensors }, cells, pose) {
  const { context, px, py } = pen;
  if (!(sensors.beams > 0)) return;
  context.beginPath();
  for (const heading of beamHeadings(pose.heading, sensors)) {
    const [x, y] = castBeam(cells, world, pose.x, pose.y, heading, sensors.range);
    context.moveTo(px(pose.x), py(pose.y));
    context.lineTo(px(x), py(y));
  }
  strokeMark(pen, "beam");
}

/**
 * @param {Pen} pen
 * @param {RunScene} scene
 * @param {Pose} pose
 */
export function drawBearing(pen, { world }, pose) {
  const bearing = Math.atan2(world.target[1] - pose.y, world.target[0] - pose.x);
  const from = Math.max(world.radius, 5 / pen.scale) + 3 / pen.scale;
  pen.context.beginPath();
  for (const away of [from, from + 9 / pen.scale])
    pen.context.lineTo(pen.px(pose.x + Math.cos(bearing) * away), pen.py(pose.y + Math.sin(bearing) * away));
  strokeMark(pen, "bearing");
}
