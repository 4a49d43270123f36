// Words in a picture, at the place where they hide the least, as in worldgen/render/placed_words.py.

import { SOLID, openWorld, stateAt } from "#player/decode.js";
import { MARKS } from "#player/picture/marks.js";
import { BAR_ROOM } from "#player/picture/pen.js";

const ROWS = 600; // of a path that are looked at
const ALONG = 0.6; // share of the words' size by which they may be moved into the picture
const BODY = 8; // cost of words that hide all of the robot, or of the target
const FURTHER = 2; // cost of a place that is less clear
const SAMPLES = 5; // places across some words at which walls are looked for

/**
 * Returns the width and the height of some words, pixels.
 * @param {Pen} pen
 * @param {string} words
 * @returns {[number, number]}
 */
export function sizeOfWords({ context, unit }, words) {
  const size = MARKS.since.size * unit;
  context.font = `${size}px system-ui, sans-serif`;
  return [context.measureText(words).width, 1.1 * size];
}

/**
 * Draws words at the place that hides the least of the robot, what it repeats, the target and walls.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {SceneRobot | undefined} one
 * @param {string} words
 * @param {number[][]} places - Upper left corners, pixels; the first of equally good ones is taken
 * @param {number[][]} further - The same, less clear: taken if all `places` hide more
 * @param {string} colour
 * @param {number[][]} [shunned] - Discs that must stay visible, x, y and radius, pixels
 */
export function placeWords(pen, world, one, words, places, further, colour, shunned = []) {
  const { context, colours } = pen,
    [wide, high] = sizeOfWords(pen, words);
  let least = Infinity,
    [left, top] = places[0];
  for (const place of [...places, ...further]) {
    const [x, y] = inPicture(pen, place[0], place[1], wide, high),
      isFar = Math.abs(x - place[0]) > ALONG * wide || Math.abs(y - place[1]) > ALONG * high,
      isMoved = x !== place[0] || y !== place[1];
    const cost = hiddenBy(pen, world, one, shunned, x, y, wide, high) + (isFar ? 3 : 0) + (isMoved ? 0.5 : 0) + (further.includes(place) ? FURTHER : 0);
    if (cost < least - 1e-9) [least, left, top] = [cost, x, y];
  }
  pen.words = [...(pen.words ?? []), [left, top, left + wide, top + high]];
  context.globalAlpha = 0.85;
  context.fillStyle = colours.floor;
  context.fillRect(left - 1, top, wide + 2, high);
  context.globalAlpha = 1;
  context.textAlign = "left";
  context.textBaseline = "alphabetic";
  context.fillStyle = colour;
  context.fillText(words, left, top + 0.8 * high);
}

// Moves a place until its words are in the picture, above its scale bar.
function inPicture({ width, height }, x, y, wide, high) {
  const within = (value, low, beyond) => Math.max(low, Math.min(value, beyond));
  return [
    within(x, 2, width - wide - 2),
    within(y, 0, height - BAR_ROOM - high),
  ];
}

/**
 * Returns how much some words at a place would hide.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {SceneRobot | undefined} one
 * @param {number[][]} shunned
 * @param {number} x
 * @param {number} y
 * @param {number} wide
 * @param {number} high
 */
function hiddenBy({ px, py, scale, unit, words = [], bodies = [] }, world, one, shunned, x, y, wide, high) {
  const covers = (/** @type {number} */ at, /** @type {number} */ down, margin = 0) => at > x - margin && at < x + wide + margin && down > y - margin && down < y + high + margin;
  const [goalX, goalY, radius] = world.target;
  const goal = [px(goalX), py(goalY), Math.max(radius * scale, MARKS.target.size * unit)];
  let cost = 0;
  for (const [at, down, reach] of [goal, ...bodies]) {
    const overlap = (/** @type {number} */ low, /** @type {number} */ size, /** @type {number} */ middle) => Math.max(0, Math.min(low + size, middle + reach) - Math.max(low, middle - reach));
    cost += (BODY * overlap(x, wide, at) * overlap(y, high, down)) / (2 * reach) ** 2;
  }
  for (const [at, down, margin] of shunned) if (covers(at, down, margin)) cost += 5;
  for (const [left, top, right, bottom] of words) if (x < right && x + wide > left && y < bottom && y + high > top) cost += 4;
  if (one) {
    const { open, entry } = one,
      from = entry < open.at.length ? entry : Math.max(0, open.at.length - ROWS),
      step = Math.max(1, (open.at.length - from) / ROWS);
    let hidden = 0,
      near = 0;
    for (let row = from; row < open.at.length; row += step) {
      const [at, down] = [px(open.x[Math.floor(row)]), py(open.y[Math.floor(row)])];
      if (covers(at, down, 2)) hidden += 1;
      if (covers(at, down, 0.5 * one.radius * scale)) near = 1;
    }
    cost += near + (hidden > 0 ? 2 + (4 * hidden * step) / (open.at.length - from) : 0);
  }
  const { cells } = openWorld(world);
  for (let k = 0; k < SAMPLES; k += 1) {
    const ix = Math.floor((x + ((k + 0.5) * wide) / SAMPLES - px(0)) / scale),
      iy = Math.floor((py(0) - y - high / 2) / scale),
      isInside = ix >= 0 && ix < world.width && iy >= 0 && iy < world.height;
    if (stateAt(cells, world, ix, iy) === SOLID) cost += isInside ? 0.5 : 0.25;
  }
  return cost;
}
