// Changes of cells over time: the next change of each cell, and the burnt floor. Hatching shows
// future changes.

import { BURNING, FREE, SOLID, openWorld } from "#player/decode.js";
import { MARKS } from "#player/picture/marks.js";
import { rimOf, stroke } from "#player/picture/pen.js";
import { placeWords, sizeOfWords } from "#player/picture/placed_words.js";

// The next change of a cell: its new state plus one, because 0 means no change.
const CLOSES = SOLID + 1,
  BURNS = BURNING + 1;
const HATCHED = 3; // pixels per cell above which hatching can be told from a plain colour
const MOST_LABELS = 6; // limit on labelled places where a timed path waits for a wall to open

/**
 * Returns the next change of each cell (0: none), which cells become free at some later time, and
 * which have burnt.
 * @param {OpenWorld} open - As cellsAt has left it for the current time
 * @returns {{next: Uint8Array, opens: Uint8Array, burnt: Uint8Array}}
 */
function comingIn(open, width) {
  const { events, done } = open;
  if (open.coming && open.coming.done === done) return open.coming;
  const next = new Uint8Array(open.cells.length),
    opens = new Uint8Array(open.cells.length),
    burnt = new Uint8Array(open.cells.length);
  if (events) {
    const { ix, iy, state } = events;
    // the earliest stays
    for (let k = state.length - 1; k >= done; k -= 1) {
      next[iy[k] * width + ix[k]] = state[k] + 1;
      if (state[k] === FREE) opens[iy[k] * width + ix[k]] = 1;
    }
    for (let k = 0; k < done; k += 1) burnt[iy[k] * width + ix[k]] = state[k] === BURNING ? 1 : burnt[iy[k] * width + ix[k]];
  }
  open.coming = { next, opens, burnt, done };
  return open.coming;
}

/**
 * Draws burnt floor below everything else.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {Uint8Array} cells
 */
export function drawBurnt(pen, world, cells) {
  const { open } = world;
  if (!open?.events || open.done === 0) return;
  const { burnt } = comingIn(open, world.width);
  const { context } = pen;
  context.fillStyle = pen.colours[MARKS.burnt.colour];
  context.beginPath();
  if (pathOf(pen, world, (k) => burnt[k] === 1 && cells[k] === FREE)) context.fill();
}

/**
 * Hatches cells that burn, open or close later.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {Uint8Array} cells
 */
export function drawComing(pen, world, cells) {
  const { open } = world;
  if (!open?.events) return;
  const { next, opens } = comingIn(open, world.width);
  hatch(pen, world, (k) => next[k] === BURNS && cells[k] === FREE, "burns", 1);
  hatch(pen, world, (k) => next[k] === CLOSES && cells[k] !== SOLID, "closes", 1);
  // a wall that burns away opens too
  const frees = (k) => opens[k] === 1 && cells[k] === SOLID;
  wash(pen, world, frees, pen.colours.floor, MARKS.opens.fill); // so that the hatching stands out from walls
  hatch(pen, world, frees, "opens", -1);
}

// Adds the rectangles of visible cells to the path; returns whether there are any.
function pathOf(pen, world, is) {
  const { context, px, py, snap, scale } = pen;
  const first = Math.max(0, Math.floor((0 - px(0)) / scale)),
    beyond = Math.min(world.width, Math.ceil((pen.width - px(0)) / scale));
  const low = Math.max(0, Math.floor((py(0) - pen.height) / scale)),
    high = Math.min(world.height, Math.ceil(py(0) / scale));
  let some = false;
  for (let iy = low; iy < high; iy += 1) {
    const top = snap(py(iy + 1)),
      deep = Math.max(1, snap(py(iy)) - top);
    for (let ix = first; ix < beyond; ix += 1) {
      if (!is(iy * world.width + ix)) continue;
      const from = ix;
      while (ix + 1 < beyond && is(iy * world.width + ix + 1)) ix += 1;
      const left = snap(px(from));
      context.rect(left, top, Math.max(1, snap(px(ix + 1)) - left), deep);
      some = true;
    }
  }
  return some;
}

function wash(pen, world, is, colour, alpha) {
  const { context } = pen;
  context.save();
  context.globalAlpha = alpha;
  context.fillStyle = colour;
  context.beginPath();
  if (pathOf(pen, world, is)) context.fill();
  context.restore();
}

function hatch(pen, world, is, name, slant) {
  const { context, unit, width, height } = pen,
    { colour, fill, opacity, size, width: thick } = MARKS[name];
  const apart = size * unit * Math.SQRT2;
  if (slant > 0) wash(pen, world, is, pen.colours[colour], fill);
  if (pen.scale < HATCHED) return;
  context.save();
  context.beginPath();
  if (pathOf(pen, world, is)) {
    context.clip();
    context.globalAlpha = opacity;
    context.beginPath();
    for (let at = -height; at < width + height; at += apart) {
      context.moveTo(at, slant > 0 ? height : 0);
      context.lineTo(at + height, slant > 0 ? 0 : height);
    }
    stroke(pen, pen.colours[colour], thick * unit);
  }
  context.restore();
}

const WORDS = { [SOLID]: "wall", [BURNING]: "fire", [FREE]: "free" };
const MOST_SINCE = 3; // labels: fires change hundreds of cells, and the first one says enough
const APART = 3; // cells between two of them

/**
 * Says next to cells that change what they first become, and when.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {SceneRobot[]} robots
 */
export function drawChangeLabels(pen, world, robots) {
  const { events, cells } = openWorld(world);
  if (!events) return;
  const { px, py, colours, unit } = pen,
    labelled = [];
  for (let k = 0; k < events.ms.length && labelled.length < MOST_SINCE; k += 1) {
    const [ix, iy, state] = [events.ix[k], events.iy[k], events.state[k]],
      isSolid = cells[iy * world.width + ix] === SOLID;
    if (isSolid === (state === SOLID) && state !== BURNING) continue; // not a change
    if (labelled.some(([x, y]) => Math.max(Math.abs(ix - x), Math.abs(iy - y)) < APART)) continue;
    if (px(ix + 1) <= 0 || px(ix) >= pen.width || py(iy) <= 0 || py(iy + 1) >= pen.height) continue;
    labelled.push([ix, iy]);
    const words = `${WORDS[state]} at ${timeOfLabel(events.ms[k] / 1000)} s`,
      [wide, high] = sizeOfWords(pen, words),
      away = 3 * unit,
      [across, down] = [px(ix + 0.5) - wide / 2, py(iy + 0.5) - high / 2],
      [right, left, above, below] = [px(ix + 1) + away, px(ix) - away - wide, py(iy + 1) - away - high, py(iy) + away];
    const places = [[right, down], [left, down], [across, above], [across, below]],
      corners = [[right, above], [right, below], [left, above], [left, below]];
    placeWords(pen, world, robots[robots.length - 1], words, places, corners, colours[MARKS.since.colour], [[px(ix + 0.5), py(iy + 0.5), 0.4 * pen.scale]]);
  }
}

/**
 * Labels the places where a timed path crosses a cell that is still a wall, with the time at which
 * it opens.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {Uint8Array} cells
 */
export function drawOpenings(pen, world, cells) {
  const { open } = world,
    witness = open?.witness;
  if (!open?.events || !witness) return;
  const { context, px, py, colours } = pen;
  context.save();
  context.font = "600 12px system-ui, sans-serif";
  context.lineWidth = 4;
  context.strokeStyle = colours.floor;
  context.fillStyle = colours[MARKS.witness.colour];
  for (const { x, y, ms } of openingsOn(world, cells).slice(0, MOST_LABELS)) {
    const words = `opens at ${(ms / 1000).toFixed(1)} s`,
      left = Math.min(px(x) + 8, pen.width - rimOf(pen) - context.measureText(words).width - 4);
    context.strokeText(words, left, py(y) - 6);
    context.fillText(words, left, py(y) - 6);
  }
  context.restore();
}

/**
 * Returns where a timed path enters walls that open later, one place per stretch of wall.
 * @param {SceneWorld} world
 * @param {Uint8Array} cells
 * @returns {{x: number, y: number, ms: number}[]}
 */
function openingsOn(world, cells) {
  const { events, witness, done } = /** @type {OpenWorld} */ (world.open);
  const found = [];
  if (!events || !witness) return found;
  /** @type {Map<number, number>} */
  const opens = new Map();
  for (let k = events.ms.length - 1; k >= done; k -= 1)
    if (events.state[k] === FREE) opens.set(events.iy[k] * world.width + events.ix[k], events.ms[k]);
  let within = false;
  for (let k = 0; k + 1 < witness.x.length; k += 1) {
    const dx = witness.x[k + 1] - witness.x[k],
      dy = witness.y[k + 1] - witness.y[k];
    const places = Math.max(1, Math.ceil(4 * Math.hypot(dx, dy)));
    for (let part = 0; part < places; part += 1) {
      const x = witness.x[k] + (dx * part) / places,
        y = witness.y[k] + (dy * part) / places;
      const cell = Math.floor(y) * world.width + Math.floor(x),
        ms = cells[cell] === SOLID ? opens.get(cell) : undefined;
      if (ms !== undefined && !within) found.push({ x, y, ms });
      within = ms !== undefined;
    }
  }
  return found;
}

/**
 * Returns a time with two digits, or in whole seconds if it is longer.
 * @param {number} seconds
 * @returns {number}
 */
function timeOfLabel(seconds) {
  return seconds < 100 ? Number(seconds.toPrecision(2)) : Math.floor(seconds + 0.5);
}
