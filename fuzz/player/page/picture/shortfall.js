// How near a robot that repeats itself gets to its target, and what is straight between them, as in
// worldgen/render/shortfall.py.

import { FREE, SOLID, openWorld, stateAt } from "#player/decode.js";
import { drawHead } from "#player/picture/arrows.js";
import { MARKS } from "#player/picture/marks.js";
import { innerRadius, stroke, strokeMark } from "#player/picture/pen.js";
import { placeWords, sizeOfWords } from "#player/picture/placed_words.js";
import { lengthWords } from "#player/picture/scale_bar.js";

const FINENESS = 1 / 16; // cells between two places on the straight line that are examined
const DEPTH = 0.02; // cells: a robot that is less deep in a wall slides along it

/** @typedef {[number, number]} Place */
/** @typedef {{row: number, place: Place, ahead: Place, end: Place, contact: Place | null}} Shortfall */

/**
 * Returns how near a single robot gets; null if it repeats nothing, or has other goals.
 * @param {SceneWorld} world
 * @param {SceneRobot} one
 * @returns {Shortfall | null}
 */
export function shortfallOf(world, one) {
  const { open, entry, run, number } = one,
    [goalX, goalY, radius] = world.target;
  if (entry >= open.at.length || number || run.covers || world.waypoints?.length || world.others?.length) return null;
  let row = entry,
    least = Infinity;
  for (let k = entry; k < open.at.length; k += 1) {
    const away = Math.hypot(open.x[k] - goalX, open.y[k] - goalY);
    if (away < least - 1e-9) [least, row] = [away, k];
  }
  if (least <= radius) return null;
  const found = straightTo(world, one, row, [goalX, goalY]);
  const { witness } = openWorld(world);
  if (!found.contact || !witness?.x.length) return found;
  // The middle of a target at a wall may be out of reach; the end of the witness is not.
  const last = witness.x.length - 1,
    other = straightTo(world, one, row, [witness.x[last], witness.y[last]]);
  return other.contact ? found : other;
}

/**
 * Moves the largest disc in the robot's body straight to a point of the target, up to a wall.
 * @param {SceneWorld} world
 * @param {SceneRobot} one
 * @param {number} row
 * @param {Place} aim
 * @returns {Shortfall}
 */
function straightTo(world, one, row, aim) {
  const { open } = one,
    [goalX, goalY, radius] = world.target;
  /** @type {Place} */
  const place = [open.x[row], open.y[row]];
  const gap = Math.hypot(aim[0] - place[0], aim[1] - place[1]);
  /** @type {Place} */
  const ahead = [(aim[0] - place[0]) / gap, (aim[1] - place[1]) / gap];
  const [x, y] = [place[0] - goalX, place[1] - goalY],
    along = -(x * ahead[0] + y * ahead[1]);
  const missing = along - Math.sqrt(Math.max(0, radius ** 2 - (x * x + y * y) + along ** 2));
  const cells = cellsAtLast(world),
    disc = innerRadius(one),
    count = 1 + Math.ceil(missing / FINENESS);
  const at = (/** @type {number} */ far) => /** @type {Place} */ ([place[0] + far * ahead[0], place[1] + far * ahead[1]]);
  for (let k = 0; k <= count; k += 1) {
    const end = at((missing * k) / count),
      contact = wallIn(cells, world, end, disc);
    if (contact) return { row, place, ahead, end, contact };
  }
  return { row, place, ahead, end: at(missing), contact: null };
}

// Returns the cells after all changes.
function cellsAtLast(world) {
  const { cells, events } = openWorld(world),
    found = cells.slice();
  for (let k = 0; events && k < events.ms.length; k += 1) found[events.iy[k] * world.width + events.ix[k]] = events.state[k] === SOLID ? SOLID : FREE;
  return found;
}

// Returns the place of the wall that a disc is deepest in; null if it fits.
function wallIn(cells, world, [x, y], radius) {
  const reach = Math.ceil(radius) + 1;
  let deepest = DEPTH;
  /** @type {Place | null} */
  let found = null;
  for (let iy = Math.floor(y) - reach; iy <= Math.floor(y) + reach; iy += 1) {
    for (let ix = Math.floor(x) - reach; ix <= Math.floor(x) + reach; ix += 1) {
      if (stateAt(cells, world, ix, iy) !== SOLID) continue;
      /** @type {Place} */
      const near = [Math.min(ix + 1, Math.max(ix, x)), Math.min(iy + 1, Math.max(iy, y))];
      const depth = radius - Math.hypot(near[0] - x, near[1] - y);
      if (depth > deepest + 1e-9) [deepest, found] = [depth, near];
    }
  }
  return found;
}

/**
 * Draws an arrow to the wall that stops the robot on the straight line to its target.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {SceneRobot} one
 */
export function drawBarred(pen, world, one) {
  const short = shortfallOf(world, one);
  if (!short?.contact) return;
  const { px, py } = pen,
    { place, end, contact, ahead } = short;
  // The bar is on the wall's side that the robot's rim would touch.
  const away = [contact[0] - end[0], contact[1] - end[1]],
    [x, y] = Math.hypot(away[0], away[1]) > 0 ? away : ahead;
  drawBarredArrow(pen, [px(place[0]), py(place[1])], [px(contact[0]), py(contact[1])], [y, x]);
}

/**
 * Draws an arrow whose tip is in the middle of a bar.
 * @param {Pen} pen
 * @param {Place} start - Pixels
 * @param {Place} tip
 * @param {Place} along - Direction of the bar, of any length
 */
export function drawBarredArrow(pen, start, tip, along) {
  const { context, unit, colours } = pen,
    { colour, size, width } = MARKS.barred,
    [x, y] = tip,
    angle = Math.atan2(y - start[1], x - start[0]);
  context.beginPath();
  context.moveTo(start[0], start[1]);
  context.lineTo(x, y);
  strokeMark(pen, "barred");
  const half = (1.5 * size * unit) / Math.hypot(along[0], along[1]);
  const bar = () => {
    context.beginPath();
    context.moveTo(x - half * along[0], y - half * along[1]);
    context.lineTo(x + half * along[0], y + half * along[1]);
  };
  bar();
  context.globalAlpha = 0.8;
  stroke(pen, colours.floor, (1.8 * width + 3) * unit);
  context.globalAlpha = 1;
  // The head ends in the bar, and leaves some of a short line.
  const head = Math.min(2 * size * unit, 0.7 * Math.hypot(x - start[0], y - start[1]));
  drawHead(pen, x - 0.6 * head * Math.cos(angle), y - 0.6 * head * Math.sin(angle), angle, head, colours[colour]);
  bar();
  stroke(pen, colours[colour], 1.8 * width * unit);
}

/**
 * Draws a line to the target with a bar at either end, and its length, if nothing is in between.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {SceneRobot} one
 */
export function drawDistance(pen, world, one) {
  const short = shortfallOf(world, one);
  if (!short || short.contact) return;
  const { context, px, py, unit, colours } = pen,
    { colour, size } = MARKS.short,
    { place, end } = short,
    [left, top] = [px(place[0]), py(place[1])],
    [right, bottom] = [px(end[0]), py(end[1])],
    cells = Math.hypot(end[0] - place[0], end[1] - place[1]),
    length = Math.max(Math.hypot(right - left, bottom - top), 1e-9),
    half = size * unit;
  let [across, down] = [(bottom - top) / length, (left - right) / length];
  context.beginPath();
  context.moveTo(left, top);
  context.lineTo(right, bottom);
  for (const [x, y] of [[left, top], [right, bottom]]) {
    context.moveTo(x - half * across, y - half * down);
    context.lineTo(x + half * across, y + half * down);
  }
  strokeMark(pen, "short");
  if (!world.cell) return; // a drawing has no metres
  // The words are next to the middle of the line, above it or on its right.
  const words = lengthWords(Number((cells * world.cell).toPrecision(2)));
  const [wide, high] = sizeOfWords(pen, words);
  if (across < 0 || (across === 0 && down > 0)) [across, down] = [-across, -down];
  const far = 6 * unit + 0.5 * (wide * Math.abs(across) + high * Math.abs(down));
  const places = [1, -1].map((side) => [(left + right) / 2 + side * far * across - wide / 2, (top + bottom) / 2 + side * far * down - high / 2]);
  // If it would hide one of them, the words are next to the robot and the target.
  const aside = Math.max(Math.max(one.radius, world.target[2]) * pen.scale, MARKS.target.size * unit + 5 * unit);
  const [low, beyond] = [Math.min(left, right) - aside, Math.max(left, right) + aside],
    [above, below] = [Math.min(top, bottom) - aside - high, Math.max(top, bottom) + aside],
    [middleX, middleY] = [(left + right - wide) / 2, (top + bottom - high) / 2];
  const around = [[low - wide, middleY], [beyond, middleY], [middleX, above], [middleX, below]];
  placeWords(pen, world, one, words, places, around, colours[colour]);
}
