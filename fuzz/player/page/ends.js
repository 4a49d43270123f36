// The start and the target.

import { disc, ring, stroke } from "#player/pen.js";

/**
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawTarget(pen, world) {
  const [x, y, radius] = world.target;
  const shown = Math.max(radius, 4 / pen.scale);
  disc(pen, x, y, shown, pen.colours.target);
  ring(pen, x, y, shown + 2.5 / pen.scale, pen.colours.target, 1.5);
}

/**
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawStart(pen, world) {
  const { context, px, py, colours } = pen;
  const [x, y, heading] = world.start;
  const shown = Math.max(world.radius * 0.35, 4 / pen.scale);
  ring(pen, x, y, shown, colours.start, 2);
  context.beginPath();
  context.moveTo(px(x), py(y));
  context.lineTo(px(x + Math.cos(heading) * shown * 1.8), py(y + Math.sin(heading) * shown * 1.8));
  stroke(pen, colours.start, 2);
}
