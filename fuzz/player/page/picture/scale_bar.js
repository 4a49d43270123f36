// The scale of a picture: a bar of a round length with its unit.

import { MARKS } from "#player/picture/marks.js";
import { BAR_ROOM } from "#player/picture/pen.js";

const WIDEST = 0.3; // share of the picture's width that the bar may take
const LEAST = 24; // pixels: a shorter bar is useless
const HIGH = BAR_ROOM - 3; // pixels of the plate behind the bar and its text

/**
 * Returns the longest round length, in metres, that fits into some pixels: 1, 2 or 5 times a power
 * of ten.
 * @param {number} most Pixels.
 * @param {number} perMetre Pixels of a metre.
 * @returns {number}
 */
function roundLength(most, perMetre) {
  const metres = most / perMetre;
  const power = 10 ** Math.floor(Math.log10(metres) + 1e-9);
  const factor = [5, 2, 1].find((one) => one * power <= metres * (1 + 1e-9)) ?? 1;
  return Number((factor * power).toPrecision(3));
}

/**
 * Returns a length in words, in the unit that needs the fewest digits.
 * @param {number} metres
 * @returns {string}
 */
export function lengthWords(metres) {
  if (metres >= 1000) return `${metres / 1000} km`;
  if (metres >= 0.1) return `${metres} m`;
  if (metres >= 0.01) return `${Number((metres * 100).toPrecision(3))} cm`;
  return `${Number((metres * 1000).toPrecision(3))} mm`;
}

/**
 * Draws the bar into the lower left corner of a picture.
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawScaleBar(pen, world) {
  const perMetre = pen.scale / (world.cell ?? NaN); // a drawing has rulers instead of a bar
  const metres = roundLength(Math.max(WIDEST * pen.width, LEAST), perMetre);
  const long = metres * perMetre;
  if (!(long > 4)) return;
  const { context, height } = pen;
  const { colours } = pen;
  const words = lengthWords(metres);
  context.font = `${MARKS.scale.size}px system-ui, sans-serif`;
  const wide = long + 10 + context.measureText(words).width;
  // A plate keeps bar and text legible over walls and paths when the view is zoomed.
  context.globalAlpha = 0.8;
  context.fillStyle = colours.paper;
  context.fillRect(3, height - HIGH - 3, wide + 8, HIGH);
  context.globalAlpha = 1;
  context.strokeStyle = context.fillStyle = colours.ink;
  context.lineWidth = MARKS.scale.width;
  context.setLineDash([]);
  const low = height - 7;
  context.beginPath();
  context.moveTo(7, low - 5);
  context.lineTo(7, low);
  context.lineTo(7 + long, low);
  context.lineTo(7 + long, low - 5);
  context.stroke();
  context.textBaseline = "alphabetic";
  context.textAlign = "left";
  context.fillText(words, 12 + long, low);
}
