// The starts and the targets.

import { drawNumber } from "#player/picture/numbers.js";
import { bodyPath, disc, frontOf, ring, robotColour, stroke } from "#player/picture/pen.js";

/**
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawTarget(pen, world) {
  drawWaypoints(pen, world.waypoints ?? []);
  for (const { target, aim, footprint, number } of endsOf(world)) {
    const [x, y, radius] = target;
    const shown = Math.max(radius, 4 / pen.scale),
      strong = pen.colours[number ? robotColour(number) : "target"];
    disc(pen, x, y, shown, strong);
    ring(pen, x, y, shown + 2.5 / pen.scale, strong, 1.5);
    if (aim !== undefined) drawAim(pen, [x, y, aim], shown, footprint, strong);
    if (number) drawNumber(pen, number, pen.px(x + shown) + 5, pen.py(y + shown));
  }
  if (world.goal_heading !== undefined) drawGoalHeading(pen, world.target, world.goal_heading);
}

// Goals before the target, as the target's ring, with their numbers.
function drawWaypoints(pen, goals) {
  for (const [k, [x, y, radius]] of goals.entries()) {
    const shown = Math.max(radius, 4 / pen.scale);
    ring(pen, x, y, shown, pen.colours.target, 2);
    drawNumber(pen, k + 1, pen.px(x + shown) + 5, pen.py(y + shown), pen.colours.target);
  }
}

// A line out of the target's ring is the heading that the robot must have there.
function drawGoalHeading(pen, [x, y, radius], heading) {
  const rim = Math.max(radius, 4 / pen.scale) + 2.5 / pen.scale;
  pen.context.beginPath();
  for (const away of [rim, rim + 12 / pen.scale])
    pen.context.lineTo(pen.px(x + Math.cos(heading) * away), pen.py(y + Math.sin(heading) * away));
  stroke(pen, pen.colours.target, 3);
}

/**
 * Draws the heading of a goal as a wedge, and a body that stands there, dashed.
 * @param {Pen} pen
 * @param {Triple} goal - x, y in cells and heading in rad
 * @param {number} shown - radius of the target in cells, as drawn
 * @param {[number, number][] | undefined} footprint
 * @param {string} colour
 */
function drawAim(pen, [x, y, heading], shown, footprint, colour) {
  const { context, px, py } = pen;
  if (footprint) {
    context.setLineDash([4, 4]);
    bodyPath(pen, footprint, { x, y, heading }, 0);
    stroke(pen, colour, 1.25);
    context.setLineDash([]);
  }
  const base = shown * pen.scale + 5,
    ahead = [Math.cos(heading), -Math.sin(heading)];
  context.beginPath();
  for (const [far, aside] of [[base + 11, 0], [base, 5], [base, -5]])
    context.lineTo(px(x) + far * ahead[0] - aside * ahead[1], py(y) + far * ahead[1] + aside * ahead[0]);
  context.closePath();
  context.fillStyle = colour;
  context.fill();
}

/**
 * Returns start and target of each robot, with its number if there are several.
 * @param {SceneWorld} world
 */
function endsOf(world) {
  const { start, target, radius, footprint, aim, others } = world;
  const first = { start, target, radius, footprint, aim };
  if (!others?.length) return [{ ...first, number: null }];
  return [first, ...others].map((ends, k) => ({ ...ends, number: k + 1 }));
}

/**
 * Draws each robot's body at its start, true to scale unless that is too small to see.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {boolean} [isNumbered] - Whether to draw the number of each of several robots at its start
 */
export function drawStart(pen, world, isNumbered = false) {
  const { context, px, py, colours } = pen;
  for (const { start, radius, footprint, number } of endsOf(world)) {
    const [x, y, heading] = start;
    const front = frontOf(footprint, Math.max(radius, 4 / pen.scale));
    const shown = Math.max(radius, 4 / pen.scale),
      strong = colours[number ? robotColour(number) : "start"];
    // Paths that cross the disc stay visible.
    context.globalAlpha = 0.2;
    bodyPath(pen, footprint, { x, y, heading }, shown);
    context.fillStyle = strong;
    context.fill();
    context.globalAlpha = 1;
    bodyPath(pen, footprint, { x, y, heading }, shown);
    stroke(pen, strong, 2);
    // A tick on its rim is its heading.
    context.beginPath();
    for (const share of [0.45, 1])
      context.lineTo(px(x + Math.cos(heading) * front * share), py(y + Math.sin(heading) * front * share));
    stroke(pen, strong, 3);
    if (number && isNumbered) drawNumber(pen, number, px(x - shown) - 11, py(y + shown));
  }
}
