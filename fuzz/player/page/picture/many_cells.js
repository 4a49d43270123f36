// Cells of a large world, many of which share a pixel: a picture with one pixel per cell,
// drawn in a single call.

import { MARKS } from "#player/picture/marks.js";
import { BURNING, FREE, SOLID } from "#player/decode.js";

const MANY = 100_000; // visible cells; fewer are drawn individually, with sharp edges
const SMALL = 1; // pixels of the screen per cell below which a wall and a gap share a pixel
const pictures = new WeakMap(); // by the array of cells

/**
 * Draws all cells if many of them are visible; returns whether it did.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {Uint8Array} cells
 * @returns {boolean}
 */
export function drawManyCells(pen, world, cells) {
  const { px, py, scale } = pen;
  const across = Math.min(world.width, pen.width / pen.scale),
    up = Math.min(world.height, pen.height / pen.scale);
  if (across * up < MANY && scale >= 1) return false;
  const { context } = pen;
  const picture = pictureOf(pen, world, cells),
    pixels = scale * ratioOf(context); // of the screen, for each cell
  context.save();
  context.imageSmoothingEnabled = scale < 1;
  if (pixels < SMALL && !world.open?.events) {
    // at whole pixels, so that nothing is blurred again
    const small = shrunk(picture, pixels),
      whole = (place) => Math.round(place * ratioOf(context)) / ratioOf(context);
    context.imageSmoothingEnabled = false;
    context.drawImage(small, whole(px(0)), whole(py(world.height)), small.width / ratioOf(context), small.height / ratioOf(context));
  } else context.drawImage(halved(picture, pixels), px(0), py(world.height), world.width * scale, world.height * scale);
  context.restore();
  return true;
}

// Returns the number of screen pixels per page pixel.
const ratioOf = (context) => context.getTransform?.().a || 1;

/** @type {WeakMap<OffscreenCanvas, {drawn: number, pixels: number, small: OffscreenCanvas}>} */
const smalls = new WeakMap(); // by picture: its last copy in the size of the screen

/**
 * Returns a picture in the size of the screen, each pixel a weighted average of its surroundings.
 * Anything coarser gives a maze a pattern that it does not have.
 * @param {{canvas: OffscreenCanvas, drawn: number}} picture
 * @param {number} pixels - Of the screen, for each cell
 * @returns {OffscreenCanvas}
 */
function shrunk(picture, pixels) {
  const { canvas, drawn } = picture,
    known = smalls.get(canvas);
  if (known && known.drawn === drawn && known.pixels === pixels) return known.small;
  const size = (side) => Math.max(1, Math.round(side * pixels));
  // First scale a copy of at most twice the size to exactly twice the size, then take the average of
  // each four pixels.
  const width = size(canvas.width),
    height = size(canvas.height);
  const small = scaled(scaled(halved(picture, pixels), 2 * width, 2 * height), width, height, true);
  smalls.set(canvas, { drawn, pixels, small });
  return small;
}

/** @type {WeakMap<OffscreenCanvas, {drawn: number, levels: OffscreenCanvas[]}>} */
const halves = new WeakMap(); // by picture: its copies of half size, quarter size and so on

/**
 * Returns a picture with at most two pixels for each pixel of the screen. A browser that shrinks
 * further drops rows and columns, so a maze would show a pattern that it does not have.
 * @param {{canvas: OffscreenCanvas, drawn: number}} picture - `drawn` counts how often it was drawn
 * @param {number} scale - Pixels of the screen for each cell
 * @returns {OffscreenCanvas}
 */
function halved({ canvas, drawn }, scale) {
  let known = halves.get(canvas);
  if (!known || known.drawn !== drawn) halves.set(canvas, (known = { drawn, levels: [canvas] }));
  const level = Math.max(0, Math.floor(Math.log2(1 / scale)));
  while (known.levels.length <= level) {
    const { width, height } = known.levels[known.levels.length - 1];
    // each pixel is the average of four
    known.levels.push(scaled(known.levels[known.levels.length - 1], Math.ceil(width / 2), Math.ceil(height / 2)));
  }
  return known.levels[level];
}

// Returns a picture in another size; a soft one is the average of four, half a pixel apart.
function scaled(picture, width, height, isSoft = false) {
  const canvas = new OffscreenCanvas(width, height);
  const context = /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.imageSmoothingEnabled = true;
  context.globalCompositeOperation = "lighter"; // sums
  const apart = isSoft ? [0, 0.5] : [0];
  context.globalAlpha = 1 / apart.length ** 2;
  for (const x of apart) for (const y of apart) context.drawImage(picture, x, y, width, height);
  return canvas;
}

// changes to draw into the picture individually; if there are more, it is drawn again
const FEW = 20_000;
const FLAMES = Math.round(255 * MARKS.fire.fill); // opacity: makes paths stand out from flames

// Returns the picture of the current cells; `done` counts their changes. The changes since the
// picture was made are either the world's events or, in a world that is being edited,
// `open.boxSince`: a box of cells, null for all.
function pictureOf(pen, world, cells) {
  const { wall, fire } = pen.colours,
    { done } = world.open;
  const known = pictures.get(cells),
    still = known && known.wall === wall && known.done <= done;
  if (still && known.done === done) return known;
  if (still && world.open.events && done - known.done <= FEW) {
    drawChanges(known, world, cells, done, { wall, fire });
    known.drawn += 1;
    return known;
  }
  const canvas = known ? known.canvas : new OffscreenCanvas(world.width, world.height);
  const whole = { x: 0, y: 0, width: world.width, height: world.height };
  const box = (still && world.open.boxSince && world.open.boxSince(known.done)) || whole;
  drawBox(canvas, world, cells, box, { wall, fire });
  const picture = { canvas, done, wall, drawn: (known?.drawn ?? 0) + 1 };
  pictures.set(cells, picture);
  return picture;
}

// Draws a box of cells again.
function drawBox(canvas, world, cells, { x, y, width, height }, { wall, fire }) {
  if (width < 1 || height < 1) return;
  const image = new ImageData(width, height),
    pixels = new Uint32Array(image.data.buffer);
  const colours = { [SOLID]: pixelOf(wall, 255), [BURNING]: pixelOf(fire, FLAMES) };
  for (let row = 0; row < height; row += 1) {
    const from = (y + height - 1 - row) * world.width + x;
    for (let ix = 0; ix < width; ix += 1) if (cells[from + ix] !== 0) pixels[row * width + ix] = colours[cells[from + ix]];
  }
  canvas.getContext("2d").putImageData(image, x, world.height - y - height);
}

// Draws the changes since the picture was made, cell by cell.
function drawChanges(known, world, cells, done, { wall, fire }) {
  const context = known.canvas.getContext("2d"),
    { ix, iy } = world.open.events;
  for (let k = known.done; k < done; k += 1) {
    const state = cells[iy[k] * world.width + ix[k]],
      row = world.height - 1 - iy[k];
    context.clearRect(ix[k], row, 1, 1);
    if (state === FREE) continue;
    context.globalAlpha = state === BURNING ? FLAMES / 255 : 1;
    context.fillStyle = state === BURNING ? fire : wall;
    context.fillRect(ix[k], row, 1, 1);
  }
  context.globalAlpha = 1;
  known.done = done;
}

/**
 * Returns a colour, `#` and six digits, as a little-endian pixel, the byte order of every machine
 * that runs a browser.
 * @param {string} hex
 * @param {number} alpha - Up to 255
 * @returns {number}
 */
export function pixelOf(hex, alpha) {
  const value = parseInt(hex.slice(1), 16);
  const red = value >> 16,
    green = (value >> 8) & 255,
    blue = value & 255;
  return ((alpha << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}
