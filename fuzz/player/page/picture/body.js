// The robot at a time, where its run ends, and its outlines along the path.

import { drawFront, shownRadius } from "#player/picture/ends.js";
import { bodyPath, disc, fillMark, frontOf, stroke, strokeMark } from "#player/picture/pen.js";
import { colourOf } from "#player/picture/scene_robots.js";
import { MARKS } from "#player/picture/marks.js";
import { shortfallOf } from "#player/picture/shortfall.js";

const MOST_OUTLINES = 6; // of a body along its path
const APART = 1.3; // radii between two of them

/**
 * Draws a robot where it is now.
 * @param {Pen} pen
 * @param {SceneRobot} one
 */
export function drawRobot(pen, one) {
  const { pose, footprint } = one,
    radius = shownRadius(pen, "driving", one.radius),
    colour = colourOf(pen, "driving", one.number);
  bodyPath(pen, footprint, pose, radius);
  if (one.isFront) fillMark(pen, "driving", colourOf(pen, "loop", one.number));
  stroke(pen, colour, (pose.bump ? 1.5 : 1) * MARKS.driving.width * pen.unit);
  const front = frontOf(footprint, radius);
  pen.context.beginPath();
  pen.context.moveTo(pen.px(pose.x), pen.py(pose.y));
  pen.context.lineTo(pen.px(pose.x + Math.cos(pose.heading) * front), pen.py(pose.y + Math.sin(pose.heading) * front));
  stroke(pen, colour, 2 * pen.unit);
}

/**
 * Draws a robot where its run ended, below its path; of a single one that repeats itself, instead
 * where it is nearest to its target.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {SceneRobot} one
 */
export function drawEnd(pen, world, one) {
  if (!shortfallOf(world, one)) drawStanding(pen, one, one.pose, "end");
}

/**
 * Draws a robot that repeats itself where it is nearest to its target.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {SceneRobot} one
 */
export function drawNearest(pen, world, one) {
  const { open } = one,
    row = shortfallOf(world, one)?.row;
  if (row !== undefined) drawStanding(pen, one, { x: open.x[row], y: open.y[row], heading: open.heading[row] }, "nearest");
}

/**
 * @param {Pen} pen
 * @param {SceneRobot} one
 * @param {{x: number, y: number, heading: number}} pose
 * @param {string} name
 */
function drawStanding(pen, { footprint, radius, number }, pose, name) {
  const colour = colourOf(pen, name, number),
    shown = shownRadius(pen, name, radius);
  bodyPath(pen, footprint, pose, shown);
  fillMark(pen, name, colour);
  strokeMark(pen, name, colour);
  pen.bodies = [...(pen.bodies ?? []), [pen.px(pose.x), pen.py(pose.y), shown * pen.scale]];
  if (!footprint) disc(pen, pose.x, pose.y, (2 * pen.unit) / pen.scale, colour); // an arrival depends on this point
  drawFront(pen, pose, footprint, shown, colour);
}

/**
 * Draws a few outlines of a body along its period, or along all of its path.
 * @param {Pen} pen
 * @param {SceneRobot} one
 */
export function drawOutlines(pen, { open, entry, until, footprint, radius, number }) {
  if (!footprint) return;
  const colour = colourOf(pen, "body", number),
    from = entry < until - 1 ? entry : 0;
  for (const row of spreadRows(open, from, until, radius)) {
    bodyPath(pen, footprint, { x: open.x[row], y: open.y[row], heading: open.heading[row] }, 0);
    fillMark(pen, "body", colour);
    strokeMark(pen, "body", colour);
  }
}

// Returns rows at about equal distances along a path, a few of those that a body passes.
function spreadRows({ x, y }, from, to, reach) {
  const lengths = [0];
  for (let row = from + 1; row < to; row += 1) lengths.push(lengths[lengths.length - 1] + Math.hypot(x[row] - x[row - 1], y[row] - y[row - 1]));
  const total = lengths[lengths.length - 1],
    count = Math.max(1, Math.min(MOST_OUTLINES, Math.floor(total / (APART * reach))));
  return Array.from({ length: count }, (_, k) => {
    const at = ((k + 0.5) * total) / count,
      row = lengths.findIndex((length) => length > at);
    return from + (row < 0 ? lengths.length - 1 : Math.max(0, row - 1));
  });
}
