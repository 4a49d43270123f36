// The pen: a canvas addressed in cells, the colours of the page, and lines, discs and rings.
// y points up.

import { MARKS, ROBOTS } from "#player/picture/marks.js";

const LEAST_SCALE = 0.05; // pixels per cell, if a canvas has no space left between its edges
const USUAL = 480; // pixels: a smaller picture has thinner marks, as the pictures in files do
const LEAST_UNIT = 0.75;
const CASING = 0.8; // opacity
const RIM = 0.4; // cells of solid ground to draw around a world, unless that is too wide
export const BAR_ROOM = 18; // pixels: the space for the scale bar, below a world that is shown in full

/** @returns {Record<string, string>} */
export function palette() {
  const style = getComputedStyle(document.documentElement);
  return new Proxy({}, { get: (_, name) => style.getPropertyValue(`--${String(name)}`).trim() });
}

/**
 * Returns the view of a whole world, above its scale bar.
 * @param {{width: number, height: number}} world
 * @param {number} width
 * @param {number} height
 * @returns {View}
 */
export function fitView(world, width, height) {
  const edge = 2 * edgeOf(width);
  const scale = Math.max(LEAST_SCALE, Math.min((width - edge) / world.width, (height - edge - BAR_ROOM) / world.height));
  return { x: world.width / 2, y: world.height / 2 - BAR_ROOM / 2 / scale, scale };
}

// Returns the margin in pixels around a world that is shown in full.
function edgeOf(width) {
  return width < 400 ? 9 : 16;
}

/**
 * @param {Pen} pen
 * @returns {number}
 */
export function rimOf(pen) {
  return Math.min(edgeOf(pen.width) - 3, Math.max(2, Math.round(RIM * pen.scale)));
}

/**
 * Fits the canvas to its place on the page and returns a pen that works in cells.
 * @param {HTMLCanvasElement} canvas
 * @param {View | null} view
 * @param {SceneWorld} world
 * @param {Size | null} [size] - If the canvas is not on the page
 * @returns {Pen}
 */
export function penFor(canvas, view, world, size = null) {
  const ratio = size?.ratio ?? (window.devicePixelRatio || 1);
  const { width, height } = size ?? { width: canvas.clientWidth, height: canvas.clientHeight };
  const wide = Math.round(width * ratio),
    high = Math.round(height * ratio);
  if (canvas.width !== wide || canvas.height !== high) {
    canvas.width = wide;
    canvas.height = high;
  }
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.lineJoin = "round";
  context.lineCap = "round";
  const { x, y, scale } = view || fitView(world, width, height);
  return {
    context,
    width,
    height,
    scale,
    unit: Math.min(1, Math.max(LEAST_UNIT, Math.min(width, height) / USUAL)),
    // to the screen's pixels, so that adjacent areas have no seam
    snap: (value) => Math.round(value * ratio) / ratio,
    px: (value) => width / 2 + (value - x) * scale,
    py: (value) => height / 2 - (value - y) * scale,
    colours: palette(),
  };
}

const LEAST = 0.75; // pixels: corners closer than this to the previous one are skipped
const OUT = 20; // pixels beyond the window; pieces entirely outside this margin are not drawn

/**
 * Makes a path from the rows of two columns, with an optional last place.
 * @param {Pen} pen
 * @param {ArrayLike<number>} x
 * @param {ArrayLike<number>} y
 * @param {number} from
 * @param {number} to
 * @param {{x: number, y: number} | null} [last]
 */
export function line(pen, x, y, from, to, last = null) {
  const { context, px, py } = pen;
  context.beginPath();
  corners(pen, x, y, from, to, (across, down, out) => {
    if (out) context.moveTo(across, down);
    else context.lineTo(across, down);
  });
  if (last) context.lineTo(px(last.x), py(last.y));
}

/**
 * Counts the pieces of such a path that are in the window.
 * @param {Pen} pen
 * @param {ArrayLike<number>} x
 * @param {ArrayLike<number>} y
 * @param {number} from
 * @param {number} to
 * @returns {number}
 */
export function seen(pen, x, y, from, to) {
  let count = 0;
  corners(pen, x, y, from, to, (across, down, out) => {
    if (!out) count += 1;
  });
  return count;
}

// Calls `act` with each corner that matters, in pixels, and whether the piece leading to it is out
// of sight.
function corners(pen, x, y, from, to, act) {
  const { scale, width, height } = pen,
    x0 = pen.px(0),
    y0 = pen.py(0);
  let left = NaN,
    top = NaN,
    side = 0;
  for (let row = from; row < to; row += 1) {
    const across = x0 + x[row] * scale,
      down = y0 - y[row] * scale;
    if (Math.abs(across - left) < LEAST && Math.abs(down - top) < LEAST && row < to - 1) continue;
    // One bit for each side of the window; two places beyond the same side have no visible piece
    // between them.
    const now = (across < -OUT ? 1 : across > width + OUT ? 2 : 0) | (down < -OUT ? 4 : down > height + OUT ? 8 : 0);
    act(across, down, (now & side) !== 0);
    left = across;
    top = down;
    side = now;
  }
}

/**
 * @param {Pen} pen
 * @param {string} colour
 * @param {number} width
 * @param {number[]} [dash]
 */
export function stroke(pen, colour, width, dash = []) {
  const { context } = pen;
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.setLineDash(dash);
  context.stroke();
  context.setLineDash([]);
}

/**
 * Strokes the path as a mark of `marks.json`, with its casing below it.
 * @param {Pen} pen
 * @param {string} name
 * @param {string} [colour] - Instead of the mark's own
 * @param {number} [share] - Of its opacity
 */
export function strokeMark(pen, name, colour = pen.colours[MARKS[name].colour], share = 1) {
  const { context, colours, unit } = pen;
  const { width, casing, dash, opacity } = MARKS[name];
  if (casing) {
    context.globalAlpha = CASING;
    stroke(pen, colours[name === "named" ? "named-edge" : "floor"], casing * unit);
  }
  context.globalAlpha = opacity * share;
  stroke(pen, colour, width * unit, dash.map((length) => length * unit));
  context.globalAlpha = 1;
}

/**
 * Fills the path as a mark of `marks.json`.
 * @param {Pen} pen
 * @param {string} name
 * @param {string} [colour]
 */
export function fillMark(pen, name, colour = pen.colours[MARKS[name].colour]) {
  const { context } = pen;
  context.globalAlpha = MARKS[name].fill;
  context.fillStyle = colour;
  context.fill();
  context.globalAlpha = 1;
}

/**
 * Makes a path around a point.
 * @param {Pen} pen
 * @param {number} x
 * @param {number} y
 * @param {number} radius
 */
export function circle(pen, x, y, radius) {
  pen.context.beginPath();
  pen.context.arc(pen.px(x), pen.py(y), radius * pen.scale, 0, 2 * Math.PI);
}

/**
 * @param {Pen} pen
 * @param {number} x
 * @param {number} y
 * @param {number} radius
 * @param {string} colour
 */
export function disc(pen, x, y, radius, colour) {
  circle(pen, x, y, radius);
  pen.context.fillStyle = colour;
  pen.context.fill();
}

/**
 * Makes a path around a robot's body at a pose: its polygon, or its disc.
 * @param {Pen} pen
 * @param {[number, number][] | undefined} footprint - corners in cells; a disc has none
 * @param {{x: number, y: number, heading: number}} pose
 * @param {number} radius - of the disc, in cells
 */
export function bodyPath(pen, footprint, pose, radius) {
  pen.context.beginPath();
  addBody(pen, footprint, pose, radius);
}

/**
 * Adds a robot's body at a pose to the path.
 * @param {Pen} pen
 * @param {[number, number][] | undefined} footprint
 * @param {{x: number, y: number, heading: number}} pose
 * @param {number} radius
 */
function addBody(pen, footprint, { x, y, heading }, radius) {
  const { context, px, py } = pen;
  if (!footprint) {
    context.arc(px(x), py(y), radius * pen.scale, 0, 2 * Math.PI);
    return;
  }
  const cos = Math.cos(heading),
    sin = Math.sin(heading);
  footprint.forEach(([ahead, left], k) => {
    const [across, down] = [px(x + ahead * cos - left * sin), py(y + ahead * sin + left * cos)];
    if (k === 0) context.moveTo(across, down);
    else context.lineTo(across, down);
  });
  context.closePath();
}

/**
 * Returns how far a robot's body reaches ahead of its axle, in cells.
 * @param {[number, number][] | undefined} footprint
 * @param {number} radius
 * @returns {number}
 */
export function frontOf(footprint, radius) {
  return footprint ? Math.max(...footprint.map(([ahead]) => ahead)) : radius;
}

/**
 * Returns the palette colour for a robot's number; after the last colour, the palette starts over.
 * @param {number} number
 * @returns {string}
 */
export const robotColour = (number) => `robot-${(number - 1) % ROBOTS}`;

/**
 * Returns the radius of the largest disc about the axle in a robot's body, which is sure to be in
 * what the body covers.
 * @param {{radius: number, footprint?: [number, number][]}} body
 * @returns {number}
 */
export function innerRadius({ radius, footprint }) {
  if (!footprint) return radius;
  const distances = footprint.map(([x, y], k) => {
    const [u, v] = footprint[(k + 1) % footprint.length];
    return (x * (v - y) - y * (u - x)) / Math.hypot(u - x, v - y);
  });
  return Math.max(0, Math.min(...distances));
}
