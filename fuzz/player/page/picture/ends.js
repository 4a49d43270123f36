// The starts and the targets.

import { MARKS } from "#player/picture/marks.js";
import { drawNumber } from "#player/picture/numbers.js";
import { bodyPath, circle, disc, fillMark, stroke, strokeMark } from "#player/picture/pen.js";
import { colourOf, endsOf } from "#player/picture/scene_robots.js";

/**
 * Draws each target as a ring and a cross over it, with the heading that its goal asks for.
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawTarget(pen, world) {
  for (const ends of endsOf(world)) {
    const colour = colourOf(pen, "target", ends.number);
    const [x, y, radius] = ends.target;
    drawTargetMark(pen, pen.px(x), pen.py(y), Math.max(radius * pen.scale, MARKS.target.size * pen.unit), colour);
    if (ends.aim !== undefined) drawGoal(pen, ends, colour);
  }
}

/**
 * Draws each waypoint as a ring with room for its number, below the target.
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawWaypoints(pen, world) {
  for (const ends of endsOf(world)) {
    const colour = colourOf(pen, "waypoint", ends.number);
    for (const [k, [x, y, radius]] of (ends.waypoints ?? []).entries()) {
      circle(pen, x, y, shownRadius(pen, "waypoint", radius));
      fillMark(pen, "waypoint", colour);
      strokeMark(pen, "waypoint", colour);
      drawNumber(pen, k + 1, pen.px(x), pen.py(y) + 0.36 * MARKS.number.size * pen.unit, colour);
    }
  }
}

/**
 * @param {Pen} pen
 * @param {number} left - pixels
 * @param {number} top
 * @param {number} radius - pixels
 * @param {string} colour
 */
export function drawTargetMark(pen, left, top, radius, colour) {
  const { context } = pen,
    reach = radius + 5 * pen.unit;
  context.beginPath();
  context.arc(left, top, radius, 0, 2 * Math.PI);
  fillMark(pen, "target", colour);
  for (const [dx, dy] of [[reach, 0], [0, reach]]) {
    context.moveTo(left - dx, top - dy);
    context.lineTo(left + dx, top + dy);
  }
  context.moveTo(left + radius, top);
  context.arc(left, top, radius, 0, 2 * Math.PI);
  strokeMark(pen, "target", colour);
}

/**
 * Draws the heading of a goal as a wedge, and a body that stands there, dashed.
 * @param {Pen} pen
 * @param {SceneEnds} ends
 * @param {string} colour
 */
function drawGoal(pen, { target: [x, y, radius], aim = 0, footprint }, colour) {
  const { context, px, py, unit } = pen;
  if (footprint) {
    bodyPath(pen, footprint, { x, y, heading: aim }, 0);
    strokeMark(pen, "goal", colour);
  }
  const base = Math.max(radius * pen.scale, MARKS.target.size * unit) + 8 * unit;
  const ahead = [Math.cos(aim), -Math.sin(aim)];
  context.beginPath();
  for (const [far, aside] of [[base + MARKS.goal.size * unit, 0], [base, 6 * unit], [base, -6 * unit]])
    context.lineTo(px(x) + far * ahead[0] - aside * ahead[1], py(y) + far * ahead[1] + aside * ahead[0]);
  context.closePath();
  context.fillStyle = colour;
  context.fill();
  stroke(pen, pen.colours.floor, 1.2 * unit);
}

/**
 * Draws each start as a dot: in a still picture of a run, which shows the robot itself elsewhere.
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawBegan(pen, world) {
  for (const { start, number } of endsOf(world)) {
    disc(pen, start[0], start[1], (MARKS.began.size * pen.unit) / pen.scale, colourOf(pen, "began", number));
    stroke(pen, pen.colours.floor, 1.5 * pen.unit);
  }
}

/**
 * Draws each robot's body at its start, true to scale unless that is too small to see.
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawStart(pen, world) {
  for (const { start, radius, footprint, number } of endsOf(world)) {
    const [x, y, heading] = start;
    const colour = colourOf(pen, "start", number);
    drawBody(pen, "start", { x, y, heading }, footprint, radius, colour);
  }
}

/**
 * Draws the tick on each start's rim that is its heading, above the paths.
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawHeadings(pen, world) {
  for (const { start, radius, footprint, number } of endsOf(world)) {
    const [x, y, heading] = start;
    drawFront(pen, { x, y, heading }, footprint, shownRadius(pen, "start", radius), colourOf(pen, "start", number));
  }
}

/**
 * Draws a robot's body as a mark, and makes it stand out from what is below it.
 * @param {Pen} pen
 * @param {string} name
 * @param {{x: number, y: number, heading: number}} pose
 * @param {[number, number][] | undefined} footprint
 * @param {number} radius
 * @param {string} colour
 */
export function drawBody(pen, name, pose, footprint, radius, colour) {
  bodyPath(pen, footprint, pose, shownRadius(pen, name, radius));
  fillMark(pen, name, colour);
  strokeMark(pen, name, colour);
}

/**
 * Draws where a robot is ahead: a tick on a disc's rim; in a polygon a wedge, and a dot at its axle.
 * @param {Pen} pen
 * @param {{x: number, y: number, heading: number}} pose
 * @param {[number, number][] | undefined} footprint
 * @param {number} radius
 * @param {string} colour
 */
export function drawFront(pen, pose, footprint, radius, colour) {
  if (!footprint) {
    drawTick(pen, pose, radius, colour);
    return;
  }
  const ahead = footprint.map(([along]) => along),
    aside = footprint.map(([, across]) => across);
  const extent = (/** @type {number[]} */ values) => Math.max(...values) - Math.min(...values);
  const front = Math.max(...ahead),
    size = 0.38 * Math.min(extent(ahead), extent(aside)),
    ends = aside.filter((_, k) => ahead[k] > front - 1e-9),
    middle = ends.reduce((sum, value) => sum + value, 0) / ends.length;
  /** @type {[number, number][]} */
  const wedge = [[front - 0.25 * size, middle], [front - 1.25 * size, middle + 0.6 * size], [front - 1.25 * size, middle - 0.6 * size]];
  bodyPath(pen, wedge, pose, 0);
  pen.context.fillStyle = colour;
  pen.context.fill();
  disc(pen, pose.x, pose.y, Math.max((1.6 * pen.unit) / pen.scale, 0.07 * size), colour);
}

/**
 * Draws a tick on the rim of a robot, in the direction of its heading.
 * @param {Pen} pen
 * @param {{x: number, y: number, heading: number}} pose
 * @param {number} front - cells
 * @param {string} colour
 */
export function drawTick(pen, { x, y, heading }, front, colour) {
  pen.context.beginPath();
  for (const share of [0.45, 1]) pen.context.lineTo(pen.px(x + Math.cos(heading) * front * share), pen.py(y + Math.sin(heading) * front * share));
  strokeMark(pen, "heading", colour);
}

/**
 * Returns the radius of a disc in cells, or the least that is visible.
 * @param {Pen} pen
 * @param {string} name
 * @param {number} radius
 */
export const shownRadius = (pen, name, radius) => Math.max(radius, (MARKS[name].size * pen.unit) / pen.scale);

