// Cells that the text next to a picture names, and the numbers of columns and rows to find them by.

import { MARKS } from "#player/picture/marks.js";
import { rimOf, strokeMark } from "#player/picture/pen.js";

const PART = 0.3; // half the diagonal of a mark, in cells
const MOST = 14; // pixels
const FONT = "10px system-ui, sans-serif";
const HIGH = 10; // pixels of the numbers

/**
 * Draws a diamond on each cell that the text names.
 * @param {Pen} pen
 * @param {[number, number][]} cells
 */
export function drawNamed(pen, cells) {
  const { context, px, py, scale } = pen;
  const reach = Math.min(MOST, Math.max(MARKS.named.size * pen.unit, PART * scale));
  for (const [ix, iy] of cells) {
    const x = px(ix + 0.5),
      y = py(iy + 0.5);
    context.beginPath();
    context.moveTo(x, y - reach);
    context.lineTo(x + reach, y);
    context.lineTo(x, y + reach);
    context.lineTo(x - reach, y);
    context.closePath();
    // It is hollow, so that the state of the cell stays visible, and has a dark edge against the floor.
    strokeMark(pen, "named");
  }
}

/**
 * Numbers the columns along the upper edge of the world, and the rows along its left edge; along the window's, if the
 * world's are out of sight.
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawAxisNumbers(pen, world) {
  const { context, px, py, scale, width, height, colours } = pen;
  context.save();
  context.font = FONT;
  context.lineWidth = 3;
  // Light on the wall around the world; an outline in the wall's colour keeps other numbers
  // readable.
  context.strokeStyle = colours.wall;
  context.fillStyle = colours.paper;
  context.textAlign = "center";
  context.textBaseline = "middle";
  const wide = context.measureText(String(Math.max(world.width, world.height) - 1)).width;
  const every = stepOf((wide + 6) / scale);
  const rim = rimOf(pen);
  const top = Math.max(HIGH / 2 + 1, py(world.height) - rim / 2);
  const left = Math.max(wide / 2 + 1, px(0) - rim / 2);
  // A number in the corner could belong to either.
  const seen = (value, from, to) => value > from && value < to;
  for (let ix = 0; ix < world.width; ix += every) if (seen(px(ix + 0.5), left + wide, width)) draw(ix, px(ix + 0.5), top);
  for (let iy = 0; iy < world.height; iy += every) if (seen(py(iy + 0.5), top + HIGH, height)) draw(iy, left, py(iy + 0.5));
  context.restore();

  function draw(number, x, y) {
    context.strokeText(String(number), x, y);
    context.fillText(String(number), x, y);
  }
}

/**
 * Returns the smallest of 1, 2, 5, 10, 20 and so on that is not below a number of cells.
 * @param {number} least
 * @returns {number}
 */
function stepOf(least) {
  const power = 10 ** Math.floor(Math.log10(Math.max(1, least)));
  return power * ([1, 2, 5].find((step) => step * power >= least) ?? 10);
}
