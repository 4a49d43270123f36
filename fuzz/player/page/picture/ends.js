// The starts and the targets.

import { drawNumber } from "#player/picture/numbers.js";
import { disc, ring, robotColour, stroke } from "#player/picture/pen.js";

/**
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawTarget(pen, world) {
  for (const { target, number } of endsOf(world)) {
    const [x, y, radius] = target;
    const shown = Math.max(radius, 4 / pen.scale),
      strong = pen.colours[number ? robotColour(number) : "target"];
    disc(pen, x, y, shown, strong);
    ring(pen, x, y, shown + 2.5 / pen.scale, strong, 1.5);
    if (number) drawNumber(pen, number, pen.px(x + shown) + 5, pen.py(y + shown));
  }
  if (world.goal_heading !== undefined) drawGoalHeading(pen, world.target, world.goal_heading);
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
 * Returns start and target of each robot, with its number if there are several.
 * @param {SceneWorld} world
 */
function endsOf(world) {
  const { start, target, radius, others } = world;
  if (!others?.length) return [{ start, target, radius, number: null }];
  return [{ start, target, radius }, ...others].map((ends, k) => ({ ...ends, number: k + 1 }));
}

/**
 * Draws each robot's disc at its start, true to scale unless that is too small to see.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {boolean} [isNumbered] - Whether to draw the number of each of several robots at its start
 */
export function drawStart(pen, world, isNumbered = false) {
  const { context, px, py, colours } = pen;
  for (const { start, radius, number } of endsOf(world)) {
    const [x, y, heading] = start;
    const shown = Math.max(radius, 4 / pen.scale),
      strong = colours[number ? robotColour(number) : "start"];
    // Paths that cross the disc stay visible.
    context.globalAlpha = 0.2;
    disc(pen, x, y, shown, strong);
    context.globalAlpha = 1;
    ring(pen, x, y, shown, strong, 2);
    // A tick on its rim is its heading.
    context.beginPath();
    for (const share of [0.45, 1])
      context.lineTo(px(x + Math.cos(heading) * shown * share), py(y + Math.sin(heading) * shown * share));
    stroke(pen, strong, 3);
    if (number && isNumbered) drawNumber(pen, number, px(x - shown) - 11, py(y + shown));
  }
}
