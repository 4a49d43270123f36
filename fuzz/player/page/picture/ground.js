// The ground of a run: floor, walls, flames, the grid and the signal.

import { BURNING, SOLID } from "#player/decode.js";
import { drawManyCells } from "#player/picture/many_cells.js";
import { MARKS } from "#player/picture/marks.js";
import { rimOf, stroke } from "#player/picture/pen.js";

const STOPS = 12; // of the floor's gradient: it is logarithmic, and a canvas's is linear between stops
const APART = 12; // units: rings of the signal nearer to each other are left out

/**
 * Draws the floor, and the wall around it: everything outside the grid is solid.
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawFloor(pen, world) {
  const { context, px, py, colours } = pen;
  context.fillStyle = colours.panel;
  context.fillRect(0, 0, pen.width, pen.height);
  const rim = rimOf(pen);
  const left = pen.snap(px(0)),
    right = pen.snap(px(world.width));
  const top = pen.snap(py(world.height)),
    bottom = pen.snap(py(0));
  context.fillStyle = colours.wall;
  context.fillRect(left - rim, top - rim, right - left + 2 * rim, bottom - top + 2 * rim);
  context.fillStyle = colours.floor;
  context.fillRect(left, top, right - left, bottom - top);
}

/**
 * Draws walls and flames.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {Uint8Array} cells
 */
export function drawWalls(pen, world, cells) {
  if (drawManyCells(pen, world, cells)) return;
  const { context, colours } = pen;
  drawCells(pen, world, cells, SOLID, colours[MARKS.wall.colour]);
  context.globalAlpha = MARKS.fire.fill; // so that paths stand out from flames
  drawCells(pen, world, cells, BURNING, colours[MARKS.fire.colour]);
  context.globalAlpha = 1;
}

/**
 * Tints the floor by the logarithm of the distance from the target, with a ring wherever the signal
 * halves: it falls with the square of the distance.
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawSignal(pen, world) {
  const { context, px, py, colours, scale, unit } = pen;
  const [x, y, radius] = world.target,
    near = Math.max(radius * scale, 2 * unit),
    far = Math.max(1.01 * near, scale * Math.hypot(Math.max(x, world.width - x), Math.max(y, world.height - y)));
  const { fill, opacity, width, colour } = MARKS.signal;
  const glow = context.createRadialGradient(px(x), py(y), 0, px(x), py(y), far);
  for (let k = 0; k <= STOPS; k += 1)
    glow.addColorStop((near * (far / near) ** (k / STOPS)) / far, faint(colours[colour], fill * (1 - k / STOPS)));
  context.save();
  context.beginPath();
  context.rect(px(0), py(world.height), world.width * scale, world.height * scale);
  context.clip();
  context.fillStyle = glow;
  context.fillRect(px(0), py(world.height), world.width * scale, world.height * scale);
  context.globalAlpha = opacity;
  for (let ring = near * Math.SQRT2; ring < far; ring *= Math.SQRT2) {
    if (ring * (1 - Math.SQRT1_2) < APART * unit) continue;
    context.beginPath();
    context.arc(px(x), py(y), ring, 0, 2 * Math.PI);
    stroke(pen, colours[colour], width * unit);
  }
  context.restore();
}

// Returns a colour with an opacity.
function faint(hex, alpha) {
  return `${hex}${Math.round(255 * alpha).toString(16).padStart(2, "0")}`;
}

/**
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawGrid(pen, world) {
  const { context, px, py, colours } = pen;
  context.save();
  context.lineCap = "butt";
  context.beginPath();
  const [left, right] = [0, world.width].map((x) => Math.round(px(x)));
  const [bottom, top] = [0, world.height].map((y) => Math.round(py(y)));
  for (let ix = 1; ix < world.width; ix += 1) {
    context.moveTo(Math.round(px(ix)) + 0.5, bottom);
    context.lineTo(Math.round(px(ix)) + 0.5, top);
  }
  for (let iy = 1; iy < world.height; iy += 1) {
    context.moveTo(left, Math.round(py(iy)) + 0.5);
    context.lineTo(right, Math.round(py(iy)) + 0.5);
  }
  context.strokeStyle = colours[MARKS.grid.colour];
  context.lineWidth = MARKS.grid.width;
  context.stroke();
  context.restore();
}

// Draws the visible part row by row, joining neighbouring cells into one rectangle.
function drawCells(pen, world, cells, state, colour) {
  const { context, px, py, snap } = pen;
  const first = Math.max(0, Math.floor((0 - px(0)) / pen.scale)),
    beyond = Math.min(world.width, Math.ceil((pen.width - px(0)) / pen.scale));
  const low = Math.max(0, Math.floor((py(0) - pen.height) / pen.scale)),
    high = Math.min(world.height, Math.ceil(py(0) / pen.scale));
  context.fillStyle = colour;
  for (let iy = low; iy < high; iy += 1) {
    const top = snap(py(iy + 1)),
      deep = snap(py(iy)) - top;
    for (let ix = first; ix < beyond; ix += 1) {
      if (cells[iy * world.width + ix] !== state) continue;
      const from = ix;
      while (ix + 1 < beyond && cells[iy * world.width + ix + 1] === state) ix += 1;
      const left = snap(px(from));
      context.fillRect(left, top, Math.max(1, snap(px(ix + 1)) - left), Math.max(1, deep));
    }
  }
}
