// The certificate of a world: its witness, or the cut that separates the target from the start.

import { bytesOf, openWorld } from "#player/decode.js";
import { MARKS } from "#player/picture/marks.js";
import { disc, line, strokeMark } from "#player/picture/pen.js";
import { colourOf } from "#player/picture/scene_robots.js";

/**
 * Draws the path that exists for each robot, and a dot at its place at the given time.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {number | null} ms - null for a still picture, without dots
 */
export function drawWitness(pen, world, ms) {
  const { witness, others = [] } = openWorld(world);
  const isOne = others.length === 0;
  [witness, ...others].forEach((path, k) => {
    if (!path) return;
    const colour = colourOf(pen, "witness", isOne ? null : k + 1);
    line(pen, path.x, path.y, 0, path.x.length);
    strokeMark(pen, "witness", colour);
    if (ms === null) return;
    const next = path.ms.findIndex((time) => time > ms),
      last = path.ms.length - 1;
    const row = next < 0 ? last : Math.max(0, next - 1),
      gap = path.ms[Math.min(row + 1, last)] - path.ms[row];
    const share = gap > 0 ? Math.min(1, (ms - path.ms[row]) / gap) : 0;
    const along = (column) => column[row] + (column[Math.min(row + 1, last)] - column[row]) * share;
    disc(pen, along(path.x), along(path.y), Math.max((3.5 * pen.unit) / pen.scale, 0.08), colour);
  });
}

/**
 * Draws the chain of walls that no disc passes: a single cell as its outline, and a ring around a
 * chain that is too small to see.
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawCut(pen, { cut }) {
  if (!cut) return;
  const { context, px, py } = pen,
    least = MARKS.cut.size * pen.unit;
  const inside = cut.length > 1 ? [[0.5, 0.5]] : [[0, 0], [1, 0], [1, 1], [0, 1]];
  const corners = cut.flatMap(([ix, iy]) => inside.map(([x, y]) => [px(ix + x), py(iy + y)]));
  context.beginPath();
  for (const [x, y] of corners) context.lineTo(x, y);
  context.closePath();
  strokeMark(pen, "cut");
  const [[left, right], [top, bottom]] = [0, 1].map((axis) => corners.reduce(([low, high], at) => [Math.min(low, at[axis]), Math.max(high, at[axis])], [Infinity, -Infinity]));
  if (Math.max(right - left, bottom - top) >= 2 * least) return;
  context.beginPath();
  context.arc((left + right) / 2, (top + bottom) / 2, least, 0, 2 * Math.PI);
  strokeMark(pen, "cut");
}

/**
 * Draws the places where a body fits in no heading, striped, and those where it fits in some only.
 * @param {Pen} pen
 * @param {SceneWorld} world
 */
export function drawCutPoses(pen, world) {
  const { cut_poses: poses } = world;
  if (!poses) return;
  const { context, colours, unit } = pen,
    { size, width, fill, opacity, colour } = MARKS["cut-poses"];
  context.save();
  context.fillStyle = context.strokeStyle = colours[colour];
  const path = (bits) => placesPath(pen, typeof bits === "string" ? bytesOf(bits) : bits, world.width * poses.fineness, world.height * poses.fineness, poses.fineness);
  path(poses.some);
  context.globalAlpha = 0.35 * fill;
  context.fill();
  path(poses.all);
  context.globalAlpha = fill;
  context.fill();
  context.clip();
  context.globalAlpha = opacity;
  context.lineWidth = width * unit;
  context.beginPath();
  for (let at = -pen.height; at < pen.width + pen.height; at += size * unit * Math.SQRT2) {
    context.moveTo(at, pen.height);
    context.lineTo(at + pen.height, 0);
  }
  context.stroke();
  context.restore();
}

// Makes a path of the places that are set, row by row, joined.
function placesPath({ context, px, py }, bits, width, height, fineness) {
  context.beginPath();
  const isSet = (k) => (bits[k >> 3] >> (k & 7)) & 1;
  for (let row = 0; row < height; row += 1)
    for (let column = 0; column < width; column += 1) {
      if (!isSet(row * width + column)) continue;
      const from = column;
      while (column + 1 < width && isSet(row * width + column + 1)) column += 1;
      const top = py((row + 1) / fineness);
      context.rect(px(from / fineness), top, px((column + 1) / fineness) - px(from / fineness), py(row / fineness) - top);
    }
}
