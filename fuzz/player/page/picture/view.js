// The part of a world that a small picture shows: all of it, or what happens at a visible size.
// worldgen/render/event_window.py chooses the same for contact sheets.

import { CARD, MARKS } from "#player/picture/marks.js";
import { drivenIn } from "#player/picture/scene_robots.js";
import { BAR_ROOM, fitView } from "#player/picture/pen.js";

const LAST = 12; // radii: the last part of a path without a period that is part of the event

/**
 * Returns the view of what happens in a run, or null for the whole world.
 * @param {RunScene} scene - A whole run
 * @param {number} width - pixels
 * @param {number} height
 * @param {number} [least] - Diameter of the robot, pixels, from which on the whole world is shown
 * @returns {View | null}
 */
export function eventView(scene, width, height, least = CARD.robot) {
  const { world } = scene;
  const robots = drivenIn(scene),
    radius = Math.max(...robots.map((one) => one.radius));
  const whole = fitView(world, width, height);
  const named = new Set(robots.flatMap(({ run }) => run.blocked_by ?? []));
  const involved = robots.filter(({ run, number }) => run.blocked_by?.length || (number && named.has(number)));
  // The box of the period, or of the last part of the path.
  let [left, low, right, high] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const { open, entry } of involved.length > 0 ? involved : robots) {
    const { x, y } = open;
    let rest = LAST * radius;
    const repeats = entry < x.length;
    for (let row = x.length - 1; row >= (repeats ? entry : 0) && rest >= 0; row -= 1) {
      left = Math.min(left, x[row]);
      right = Math.max(right, x[row]);
      low = Math.min(low, y[row]);
      high = Math.max(high, y[row]);
      if (!repeats && row > 0) rest -= Math.hypot(x[row] - x[row - 1], y[row] - y[row - 1]);
    }
  }
  const around = CARD.around * radius,
    room = height - BAR_ROOM;
  [left, low, right, high] = [left - around, low - around, right + around, high + around];
  const scaleOf = (wide, tall) => Math.min(width / wide, room / tall);
  // With the target, unless the robot would be too small to see.
  let hasTarget = false;
  if (!world.others?.length) {
    const [x, y, size] = world.target,
      far = size + 1,
      box = [Math.min(left, x - far), Math.min(low, y - far), Math.max(right, x + far), Math.max(high, y + far)];
    hasTarget = 2 * radius * scaleOf(box[2] - box[0], box[3] - box[1]) >= least;
    if (hasTarget) [left, low, right, high] = box;
  }
  // Where everything is visible, only what is small enough is worth losing sight of the rest.
  const needed = Math.max(right - left, high - low);
  if (2 * radius * whole.scale >= least && !(hasTarget && needed <= CARD.small * Math.max(world.width, world.height))) return null;
  const scale = scaleOf(right - left, high - low);
  if (scale <= whole.scale) return null;
  // Within the world, so that no space is lost on what is outside.
  const within = (middle, size, side) => (size >= side ? side / 2 : Math.min(side - size / 2, Math.max(size / 2, middle)));
  return {
    x: within((left + right) / 2, width / scale, world.width),
    y: within((low + high) / 2, room / scale, world.height) - BAR_ROOM / 2 / scale,
    scale,
  };
}

/**
 * Points to a target that is out of the picture, with a triangle at the picture's edge.
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawOff(pen, world) {
  const { context, width, height, unit, colours } = pen,
    [x, y] = world.target,
    left = pen.px(x),
    top = pen.py(y),
    size = MARKS.off.size * unit,
    beyond = height - BAR_ROOM;
  if (left >= 0 && left <= width && top >= 0 && top <= beyond) return;
  const across = Math.min(width - size, Math.max(size, left)),
    down = Math.min(beyond - size, Math.max(size, top));
  const angle = Math.atan2(top - down, left - across);
  context.beginPath();
  for (const [ahead, aside] of [[0.9, 0], [-0.6, 0.7], [-0.6, -0.7]])
    context.lineTo(across + size * (ahead * Math.cos(angle) - aside * Math.sin(angle)), down + size * (ahead * Math.sin(angle) + aside * Math.cos(angle)));
  context.closePath();
  context.fillStyle = colours[MARKS.off.colour];
  context.fill();
  context.strokeStyle = colours.floor;
  context.lineWidth = 1.5 * unit;
  context.stroke();
}
