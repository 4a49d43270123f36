// The ground of a run: floor, walls, flames, the grid and the signal.

import { drawBurnt } from "#player/picture/changes.js";
import { BURNING, SOLID } from "#player/decode.js";
import { drawManyCells } from "#player/picture/many_cells.js";
import { rimOf } from "#player/picture/pen.js";

/**
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {Uint8Array} cells
 * @param {Scene} scene
 */
export function drawGround(pen, world, cells, scene) {
  const { context, px, py, colours } = pen;
  context.fillStyle = colours.panel;
  context.fillRect(0, 0, pen.width, pen.height);
  // Everything outside the grid is solid, so a rim of wall surrounds the floor.
  const rim = rimOf(pen);
  const left = pen.snap(px(0)),
    right = pen.snap(px(world.width));
  const top = pen.snap(py(world.height)),
    bottom = pen.snap(py(0));
  context.fillStyle = colours.wall;
  context.fillRect(left - rim, top - rim, right - left + 2 * rim, bottom - top + 2 * rim);
  context.fillStyle = colours.floor;
  context.fillRect(left, top, right - left, bottom - top);
  drawBurnt(pen, world, cells);
  if (scene.show.signal && scene.sensors && scene.sensors.signal) drawSignal(pen, world, [left, top, right, bottom]);
  if (pen.scale > 9 && scene.show.grid !== false) drawGrid(pen, world);
  if (drawManyCells(pen, world, cells)) return;
  drawCells(pen, world, cells, SOLID, colours.wall);
  context.globalAlpha = 0.6; // so that paths stand out from flames
  drawCells(pen, world, cells, BURNING, colours.fire);
  context.globalAlpha = 1;
}

// The signal's strength is 1 / (1 + squared distance), as the robot senses it.
function drawSignal(pen, world, [left, top, right, bottom]) {
  const { context, px, py, colours } = pen;
  const [x, y] = world.target;
  const reach = 6 * pen.scale;
  const glow = context.createRadialGradient(px(x), py(y), 0, px(x), py(y), reach);
  for (let k = 0; k <= 6; k += 1) {
    const strength = 1 / (1 + k * k) - 1 / 37; // 0 at the edge
    glow.addColorStop(k / 6, `rgb(${colours.signal} / ${(0.4 * strength).toFixed(3)})`);
  }
  context.save();
  context.beginPath();
  context.rect(left, top, right - left, bottom - top);
  context.clip();
  context.fillStyle = glow;
  context.fillRect(px(x) - reach, py(y) - reach, 2 * reach, 2 * reach);
  context.restore();
}

function drawGrid(pen, world) {
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
  context.strokeStyle = colours.grid;
  context.lineWidth = 1;
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
