// Arrowheads along a path, so that a still picture shows which way the robot drove.

import { MARKS } from "#player/picture/marks.js";

const APART = 90; // units along a path without a period between two heads
const MOST = 60; // arrowheads of one path in the window
const BESIDE = [0, 0.1, -0.1, 0.2, -0.2, 0.3, -0.3, 0.4, -0.4]; // shares of a step around an even place

/**
 * Returns where the arrowheads of a path are, in pixels, each with its direction: evenly, and on
 * straight pieces, because a head on a corner points nowhere.
 * @param {Pen} pen
 * @param {{x: ArrayLike<number>, y: ArrayLike<number>}} open
 * @param {number} from
 * @param {number} to
 * @param {number} size
 * @param {boolean} isOne - Whether the path has one head only
 * @returns {[number, number, number][]}
 */
function headsOn(pen, { x, y }, from, to, size, isOne) {
  const lengths = [0];
  for (let row = from + 1; row < to; row += 1)
    lengths.push(lengths[lengths.length - 1] + pen.scale * Math.hypot(x[row] - x[row - 1], y[row] - y[row - 1]));
  const total = lengths[lengths.length - 1];
  if (!(total > 2 * size)) return [];
  const count = isOne ? 1 : Math.min(MOST, Math.max(1, Math.round(total / Math.max(APART * pen.unit, total / 6))));
  const step = total / count,
    reach = 0.6 * size;
  /** @type {[number, number, number][]} */
  const heads = [];
  for (let k = 0; k < count; k += 1) {
    const spots = BESIDE.map((share) => {
      const at = (k + 0.5 + share) * step,
        [left, top] = placeAt(at - reach),
        [right, bottom] = placeAt(at + reach);
      return { place: placeAt(at), straight: Math.hypot(right - left, bottom - top) / reach, angle: Math.atan2(bottom - top, right - left) };
    });
    const free = spots.filter(({ place }) => heads.every(([left, top]) => Math.max(Math.abs(left - place[0]), Math.abs(top - place[1])) > 2.5 * reach));
    const best = free.sort((a, b) => Math.round(100 * (b.straight - a.straight)))[0];
    if (best) heads.push([best.place[0], best.place[1], best.angle]);
  }
  return heads;

  /** @param {number} at @returns {[number, number]} */
  function placeAt(at) {
    let low = 0,
      high = lengths.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (lengths[middle] <= at) low = middle;
      else high = middle;
    }
    const gap = lengths[high] - lengths[low],
      share = gap > 0 ? Math.min(1, Math.max(0, (at - lengths[low]) / gap)) : 0;
    const row = from + low;
    return [pen.px(x[row] + share * (x[row + 1] - x[row])), pen.py(y[row] + share * (y[row + 1] - y[row]))];
  }
}

/**
 * Draws the arrowheads of a path: of a period one, of a run without one some.
 * @param {Pen} pen
 * @param {{x: ArrayLike<number>, y: ArrayLike<number>}} open
 * @param {number} from
 * @param {number} to
 * @param {string} name - `loop`, `stay` or `trail`
 * @param {string} colour
 */
export function drawHeads(pen, open, from, to, name, colour) {
  const size = 1.25 * MARKS[name].size * pen.unit;
  for (const [x, y, angle] of headsOn(pen, open, Math.max(0, from), to, size, name !== "trail")) drawHead(pen, x, y, angle, size, colour);
}

/**
 * Draws an arrowhead with a light edge.
 * @param {Pen} pen
 * @param {number} x - Its middle, pixels
 * @param {number} y
 * @param {number} angle - rad, in pixel axes
 * @param {number} size - pixels
 * @param {string} colour
 */
export function drawHead({ context, colours, unit }, x, y, angle, size, colour) {
  const cos = Math.cos(angle),
    sin = Math.sin(angle);
  context.beginPath();
  for (const [ahead, aside] of [[0.6, 0], [-0.5, 0.45], [-0.25, 0], [-0.5, -0.45]])
    context.lineTo(x + size * (ahead * cos - aside * sin), y + size * (ahead * sin + aside * cos));
  context.closePath();
  context.fillStyle = colour;
  context.strokeStyle = colours.floor;
  context.lineWidth = 1.2 * unit;
  context.fill();
  context.stroke();
}
