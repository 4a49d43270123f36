// Arrowheads along a path, so that a still picture shows which way the robot drove.

const APART = 90; // pixels along the path between two heads
const SIZE = 7; // length of an arrowhead, pixels
const MOST = 60; // arrowheads of one path in the window
const LEAST = 3; // pixels: a shorter piece of the path does not show a clear direction

/**
 * Returns where to draw arrowheads on the rows of a path, in pixels, each with its direction.
 * @param {Pen} pen
 * @param {{x: ArrayLike<number>, y: ArrayLike<number>}} open
 * @param {number} from
 * @param {number} to
 * @returns {[number, number, number][]}
 */
function headsOn(pen, { x, y }, from, to) {
  const heads = [];
  let driven = APART / 2,
    left = pen.px(x[from]),
    top = pen.py(y[from]);
  for (let row = from + 1; row < to && heads.length < MOST; row += 1) {
    const across = pen.px(x[row]),
      down = pen.py(y[row]),
      far = Math.hypot(across - left, down - top);
    if (far < LEAST && row < to - 1) continue; // joins short steps
    driven += far;
    const middle = [(across + left) / 2, (down + top) / 2];
    const isSeen = middle[0] > 0 && middle[1] > 0 && middle[0] < pen.width && middle[1] < pen.height;
    if (driven >= APART && far > 0) {
      if (isSeen) heads.push([middle[0], middle[1], Math.atan2(down - top, across - left)]);
      driven = 0;
    }
    left = across;
    top = down;
  }
  return heads;
}

/**
 * Draws the arrowheads on the rows of a path, except those that would cover each other.
 * @param {Pen} pen
 * @param {{x: ArrayLike<number>, y: ArrayLike<number>}} open
 * @param {number} from
 * @param {number} to
 * @param {string} colour
 */
export function drawHeads(pen, open, from, to, colour) {
  const { context, colours } = pen;
  /** @type {[number, number][]} */
  const placed = [];
  context.fillStyle = colour;
  context.strokeStyle = colours.floor;
  context.lineWidth = 1;
  for (const [x, y, angle] of headsOn(pen, open, Math.max(0, from), to)) {
    if (placed.some(([left, top]) => Math.hypot(left - x, top - y) < 2 * SIZE)) continue;
    placed.push([x, y]);
    drawHead(pen, x, y, angle);
    context.stroke();
  }
}

/**
 * Fills an arrowhead with the context's colour.
 * @param {Pen} pen
 * @param {number} x - Its middle, pixels
 * @param {number} y
 * @param {number} angle - rad, in pixel axes
 */
export function drawHead({ context }, x, y, angle) {
  context.beginPath();
  for (const [reach, turn] of [[SIZE, 0], [SIZE, 2.5], [0.45 * SIZE, Math.PI], [SIZE, -2.5]]) context.lineTo(x + reach * Math.cos(angle + turn), y + reach * Math.sin(angle + turn));
  context.closePath();
  context.fill();
}
