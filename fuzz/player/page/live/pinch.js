// Finds a path that the steps over half cells cannot take: through a place as narrow as the disc, or
// to a pose beside a wall. worldgen/reach/single/prove.py, worldgen/reach/still: pinch.py,
// lattice_graph.py, path.py.

import { add, ceil, div, even, float, floor, fraction, isLess, lcm, mul, root, square, sub } from "#player/live/exact.js";
import { UNIT, UNITS } from "#player/live/lattice.js";
import { ROUNDING, isSame } from "#player/live/query.js";
import { isClear } from "#player/live/walls.js";

/** @typedef {import("#player/live/exact.js").Fraction} Fraction */
/** @typedef {import("#player/live/core.js").Core} Core */
/** @typedef {import("#player/live/query.js").Query} Query */
/** @typedef {import("#player/live/walls.js").Point} Point */

/** Nodes in a cell's side, one after another. */
const SIDES = [2, 4, 8, 16];
const MOST_NODES = 40_000_000;
/** Nodes that a flood fills in the time in which a search expands one. */
const LOOK = 32;
/** Targets that a flood checks. */
const MOST_STOPS = 16;
/** Nodes expanded between two looks at whether a newer question has come. */
const PORTION = 200_000n;
/** Gaps to examine, narrowest first; points on either side of a gap's middle. */
const MOST_GAPS = 20_000;
const STEPS = 16;
/** Cells: a gap wider than the disc by this much isn't narrow. */
const WIDE = 2;
/** Consecutive hidden corners before a straight line ends; failed lines of a path. */
const PATIENCE = 6;
const TESTS = 6000;

/**
 * Returns the corners of a path from start to goal; null if none was found.
 * @param {Core} core
 * @param {Query} query with a goal that can be reached
 * @param {() => Promise<void>} pause
 * @returns {Promise<Point[] | null>}
 */
export async function pathThroughPinches(core, query, pause) {
  const found = offGraph(query) ?? (await overGraphs(core, query, pause));
  if (!found) return null;
  const points = shorten(core, query, found);
  return isSame(points[0], query.exactStart) ? points : [query.exactStart, ...points];
}

/**
 * Returns the start if it is in the target, or a path to the goal with at most one corner.
 * @param {Query} query
 */
function offGraph(query) {
  const { start, exactStart, goal, x, y, reach } = query;
  const away = add(square(sub(exactStart.x, x)), square(sub(exactStart.y, y)));
  if (!isLess(square(reach), away)) return [exactStart];
  if (!goal) return null;
  for (const corner of [start, { x: start.x, y: goal.y }, { x: goal.x, y: start.y }]) {
    if (isClear(query, thinner(query), start, corner) && isClear(query, thinner(query), corner, goal)) {
      return [start, corner, goal];
    }
  }
  return null;
}

/**
 * Returns the radius for the path to an irrational goal.
 * @param {Query} query
 */
const thinner = ({ radius }) => mul(radius, sub(fraction(1), ROUNDING));

/**
 * @param {Core} core
 * @param {Query} query
 * @param {() => Promise<void>} pause
 */
async function overGraphs(core, query, pause) {
  for (const isCornered of [false, true]) {
    for (const k of SIDES) {
      if (k > 2 && k * k * query.width * query.height > MOST_NODES) continue;
      const found = await overGraph(core, query, graphOf(core, query, k), isCornered, pause);
      if (found) return found;
    }
  }
  return null;
}

/**
 * @typedef {object} Graph of clear nodes at multiples of 1/k cell
 * @property {number} k
 * @property {Fraction} unit lattice units between two nodes
 * @property {number} rows
 * @property {number} stride nodes in a row
 * @property {number} at a WgGraph
 * @property {number[]} rasters
 * @property {Uint8Array} clear
 */

/**
 * @param {Core} core
 * @param {Query} query
 * @param {number} k
 * @returns {Graph}
 */
function graphOf(core, { solid, width, height, radius }, k) {
  const [rows, stride] = [k * height + 1, k * width + 1];
  const nodes = rows * stride;
  const rasters = [core.zeros(nodes), core.zeros(nodes)];
  if (!isLess(fraction(Math.min(width, height)), mul(fraction(2), radius))) {
    const limit = ceil(square(mul(fraction(2 * k), radius)));
    const cells = core.array(solid, "uint8_t");
    core.check("wg_disc_rasters", cells, BigInt(height), BigInt(width), BigInt(k), limit, rasters[0], rasters[1]);
  }
  const at = core.make("WgGraph", { clear: rasters[0], middle: rasters[1], nodes, stride });
  const clear = core.view(rasters[0], nodes, "uint8_t").slice();
  return { k, unit: fraction(UNIT / k), rows, stride, at, rasters, clear };
}

/**
 * @param {Core} core
 * @param {Query} query
 * @param {Graph} graph
 * @param {boolean} isCornered whether to enter and leave the graph around a corner, too
 * @param {() => Promise<void>} pause
 */
async function overGraph(core, query, graph, isCornered, pause) {
  const { start, goal } = query;
  const none = /** @type {Map<number, Point>} */ (new Map());
  const onto = isCornered ? linksRoundCorners(query, query.radius, graph, start) : none;
  const off = isCornered && goal ? linksRoundCorners(query, thinner(query), graph, goal) : none;
  const sources = [...links(query, query.radius, graph, start), ...onto.keys()];
  const ends = [...(goal ? links(query, thinner(query), graph, goal) : []), ...off.keys()];
  if (!sources.length) return null;
  const spare = nodesWithin(query, graph);
  if (!ends.length && !spare.length) return null;
  const nodes = await findPath(core, graph, sources, ends, spare, query, bridges(query, graph), pause);
  if (!nodes.length) return null;
  const points = [start, onto.get(nodes[0]) ?? start, ...nodes.map((node) => pointOf(graph, node))];
  const last = nodes[nodes.length - 1];
  return goal && ends.includes(last) ? [...points, off.get(last) ?? goal, goal] : points;
}

/**
 * @param {Graph} graph
 * @param {number} node
 * @returns {Point}
 */
const pointOf = ({ unit, stride }, node) => ({
  x: mul(fraction(node % stride), unit),
  y: mul(fraction(Math.floor(node / stride)), unit),
});

/**
 * Yields the clear nodes of some columns and rows.
 * @param {Graph} graph
 * @param {[number, number]} columns from, to
 * @param {[number, number]} rows
 */
function* clearNodes({ clear, rows: height, stride }, columns, rows) {
  for (let j = Math.max(0, rows[0]); j < Math.min(height, rows[1]); j++) {
    for (let i = Math.max(0, columns[0]); i < Math.min(stride, columns[1]); i++) {
      if (clear[j * stride + i]) yield j * stride + i;
    }
  }
}

/**
 * Returns the clear nodes near a point to which a disc may go straight; the point, if it is a node.
 * @param {Query} query
 * @param {Fraction} radius
 * @param {Graph} graph
 * @param {Point} point
 */
function links(query, radius, graph, point) {
  const [i, j] = [point.x, point.y].map((value) => Number(floor(div(value, graph.unit))));
  const isNode = isSame(point, pointOf(graph, j * graph.stride + i));
  const [before, after] = isNode ? [0, 1] : [-1, 3];
  const near = clearNodes(graph, [i + before, i + after], [j + before, j + after]);
  return [...near].filter((node) => isNode || isClear(query, radius, point, pointOf(graph, node)));
}

/**
 * Returns clear nodes that a disc reaches from a point over one corner along the axes, with the corner.
 * @param {Query} query
 * @param {Fraction} radius
 * @param {Graph} graph
 * @param {Point} point
 */
function linksRoundCorners(query, radius, graph, point) {
  /** @type {Map<number, Point>} */
  const found = new Map();
  const wide = 2 + Number(root(ceil(mul(fraction(8 * graph.k), radius))));
  const [i, j] = [point.x, point.y].map((value) => Number(floor(div(value, graph.unit))));
  for (const isAlong of [true, false]) {
    const [across, up] = isAlong ? [wide, 1] : [1, wide];
    for (const node of clearNodes(graph, [i - across, i + across + 2], [j - up, j + up + 2])) {
      const to = pointOf(graph, node);
      const corner = isAlong ? { x: to.x, y: point.y } : { x: point.x, y: to.y };
      if (found.has(node)) continue;
      if (isClear(query, radius, point, corner) && isClear(query, radius, corner, to)) found.set(node, corner);
    }
  }
  return found;
}

/**
 * Returns the clear nodes in the target.
 * @param {Query} query
 * @param {Graph} graph
 */
function nodesWithin({ x, y, reach }, graph) {
  const scale = [x, y, reach].map(({ under }) => under).reduce(lcm);
  const [cx, cy, radius] = [x, y, reach].map(({ over, under }) => over * (scale / under));
  const unit = BigInt(UNIT / graph.k) * scale;
  const [down, up] = [(/** @type {bigint} */ value) => Number(floor(fraction(value, unit))), ceilOf];
  function ceilOf(/** @type {bigint} */ value) {
    return Number(ceil(fraction(value, unit)));
  }
  /** @type {number[]} */
  const found = [];
  for (let j = Math.max(0, up(cy - radius)); j <= Math.min(graph.rows - 1, down(cy + radius)); j++) {
    // Half the chord at this height, rounded down.
    const half = root(radius ** 2n - (BigInt(j) * unit - cy) ** 2n);
    found.push(...clearNodes(graph, [up(cx - half), down(cx + half) + 1], [j, j + 1]));
  }
  return found;
}

/**
 * Returns the nodes of a path from a source to an end, or failing that to a spare end.
 * @param {Core} core
 * @param {Graph} graph
 * @param {number[]} sources
 * @param {number[]} ends
 * @param {number[]} spare
 * @param {Query} query
 * @param {number[]} extra pairs of nodes that are also connected
 * @param {() => Promise<void>} pause
 */
async function findPath(core, graph, sources, ends, spare, query, extra, pause) {
  const list = (/** @type {number[]} */ nodes) => core.array(nodes.map(BigInt), "int64_t");
  const counted = [sources, ends, spare].flatMap((nodes) => [list(nodes), BigInt(nodes.length)]);
  const toward = [query.x, query.y].map((value) => even(div(value, graph.unit)));
  const made = core.zeros(8);
  core.check("wg_search_new", graph.at, ...counted, ...toward, list(extra), BigInt(extra.length / 2), made);
  const [search] = core.view(made, 1, "uint32_t");
  const { WG_GOING, WG_FOUND } = core.constants;
  const advance = (/** @type {bigint} */ most) => {
    core.check("wg_search_advance", search, most, made + 4);
    return core.view(made + 4, 1, "int32_t")[0];
  };
  try {
    // Before searching all of a large world, check whether there is anything to find.
    const nodes = graph.rows * graph.stride;
    let found = advance(BigInt(Math.max(1, Math.floor(nodes / LOOK))));
    if (found === WG_GOING && !extra.length) {
      const stops = ends.length > MOST_STOPS ? [] : ends;
      const seen = core.zeros(nodes);
      const flooded = [...graph.rasters, BigInt(nodes), BigInt(graph.stride), list(sources), BigInt(sources.length)];
      core.check("wg_flood", ...flooded, list(stops), BigInt(stops.length), seen);
      const is = core.view(seen, nodes, "uint8_t");
      if (!ends.some((node) => is[node])) {
        if (!spare.some((node) => is[node])) return [];
        core.call("wg_search_be_content", search);
      }
    }
    while (found === WG_GOING) {
      await pause();
      found = advance(PORTION);
    }
    if (found !== WG_FOUND) return [];
    const count = core.call("wg_search_path_length", search);
    const path = core.zeros(8 * count);
    core.call("wg_search_path", search, path);
    return Array.from(core.view(path, count, "int64_t"), Number);
  } finally {
    core.call("wg_search_free", search);
  }
}

/**
 * Returns pairs of nodes joined by a clear line: a gap's middle and a point on its bisector.
 * @param {Query} query
 * @param {Graph} graph
 */
function bridges(query, graph) {
  const found = [];
  for (const [middleX, middleY, stepX, stepY] of slantingGaps(query, graph)) {
    const middle = middleY * graph.stride + middleX;
    for (const sign of [1, -1]) {
      for (let j = 1; j <= STEPS; j++) {
        const [x, y] = [middleX + sign * j * stepX, middleY + sign * j * stepY];
        const node = y * graph.stride + x;
        if (x < 0 || y < 0 || x >= graph.stride || y >= graph.rows || !graph.clear[node]) break;
        if (!isClear(query, query.radius, pointOf(graph, middle), pointOf(graph, node))) break;
        found.push(middle, node);
      }
    }
  }
  return found;
}

/**
 * Returns clear middles (node x, y) of gaps at odd angles, with the bisector's step.
 * @param {Query} query
 * @param {Graph} graph
 */
function slantingGaps(query, graph) {
  // (0, 0) of the rim is cell (-1, -1) of the grid.
  const { rim, rows, columns } = rimOf(query);
  const wide = mul(fraction(2), query.radius);
  const reach = Number(ceil(wide)) + WIDE + 1;
  const half = Math.floor(graph.k / 2);
  const gaps = [];
  for (let gx = 1; gx < reach; gx++) {
    for (let gy = 1; gy < reach; gy++) {
      const squared = fraction(gx * gx + gy * gy);
      const isNear = !isLess(squared, square(wide)) && !isLess(square(add(wide, fraction(WIDE))), squared);
      if (gx !== gy && isNear) gaps.push([gx, gy]);
    }
  }
  gaps.sort((a, b) => a[0] ** 2 + a[1] ** 2 - b[0] ** 2 - b[1] ** 2);

  // Pairs of cells with such a gap, in both slants, whose middle is clear.
  const found = [];
  for (const [gx, gy] of gaps) {
    const [dx, dy] = [gx + 1, gy + 1];
    const common = gcd(gx, gy);
    if (dx >= columns || dy >= rows) continue;
    for (const sign of [1, -1]) {
      for (let iy = 0; iy < rows - dy; iy++) {
        for (let ix = 0; ix < columns - dx; ix++) {
          const [low, high] = sign > 0 ? [ix, ix + dx] : [ix + dx, ix];
          if (!rim[iy * columns + low] || !rim[(iy + dy) * columns + high]) continue;
          const x = half * (2 * (low - 1) + 1 + sign * dx);
          const y = half * (2 * (iy - 1) + 1 + dy);
          const inside = x >= 0 && x < graph.stride && y >= 0 && y < graph.rows;
          if (inside && graph.clear[y * graph.stride + x]) found.push([x, y, -gy / common, (sign * gx) / common]);
        }
      }
      if (found.length > MOST_GAPS) return found;
    }
  }
  return found;
}

/**
 * @param {number} a
 * @param {number} b
 * @returns {number}
 */
const gcd = (a, b) => (b ? gcd(b, a % b) : a);

/**
 * Returns (height + 2, width + 2) solid cells with a free one next to them.
 * @param {Query} query
 */
function rimOf({ solid, width, height }) {
  const [rows, columns] = [height + 2, width + 2];
  const isFree = (/** @type {number} */ ix, /** @type {number} */ iy) =>
    ix >= 0 && iy >= 0 && ix < width && iy < height && !solid[iy * width + ix];
  const rim = new Uint8Array(rows * columns);
  for (let iy = -1; iy <= height; iy++) {
    for (let ix = -1; ix <= width; ix++) {
      if (isFree(ix, iy)) continue;
      let isRim = false;
      for (let k = 0; k < 9; k++) isRim ||= isFree(ix + (k % 3) - 1, iy + Math.floor(k / 3) - 1);
      rim[(iy + 1) * columns + ix + 1] = Number(isRim);
    }
  }
  return { rim, rows, columns };
}

/**
 * Replaces corners by straight lines that the disc may sweep.
 * @param {Core} core
 * @param {Query} query
 * @param {Point[]} path
 */
function shorten(core, query, path) {
  const points = mergeStraight(path);
  const patience = Math.max(1, Math.min(PATIENCE, Math.floor(TESTS / points.length)));
  const radius = mul(query.radius, UNITS);
  const disc = core.make("WgDisc", { reach: ceil(radius), limit: ceil(square(radius)), radius_sq: float(square(radius)) });
  const whole = points.map(({ x, y }) => Number(x.under === 1n && y.under === 1n));
  const count = BigInt(points.length);
  const inputs = [
    ...[query.walls, disc, core.array(points.map(({ x }) => floor(x)), "int64_t")],
    ...[core.array(points.map(({ y }) => floor(y)), "int64_t"), core.array(whole, "uint8_t"), count, BigInt(patience)],
  ];
  const { WG_UNSURE, WG_CLEAR, WG_MEETS } = core.constants;
  const state = core.array([0, 1, 2, 1, WG_UNSURE].map(BigInt), "int64_t");
  const kept = core.zeros(8 * points.length);
  const done = core.zeros(8);
  for (;;) {
    core.check("wg_shorten", ...inputs, state, kept, done);
    const now = core.view(state, 5, "int64_t");
    if (core.view(done, 1, "int64_t")[0]) {
      const indices = Array.from(core.view(kept, Number(now[3]), "int64_t"), Number);
      return mergeStraight(indices.map((index) => points[index]));
    }
    // Only fractions can decide whether this piece is clear.
    const clear = isClear(query, query.radius, points[Number(now[0])], points[Number(now[2])]);
    now[4] = BigInt(clear ? WG_CLEAR : WG_MEETS);
  }
}

/**
 * Removes repeated points, and points in the middle of a straight line.
 * @param {Point[]} points
 */
function mergeStraight(points) {
  /** @type {Point[]} */
  const kept = [];
  const step = (/** @type {Point} */ p, /** @type {Point} */ q) => ({ x: sub(q.x, p.x), y: sub(q.y, p.y) });
  for (const point of points) {
    const last = kept[kept.length - 1];
    if (last && isSame(last, point)) continue;
    while (kept.length > 1) {
      const u = step(kept[kept.length - 2], kept[kept.length - 1]);
      const v = step(kept[kept.length - 1], point);
      const turns = sub(mul(u.x, v.y), mul(u.y, v.x)).over !== 0n;
      if (turns || add(mul(u.x, v.x), mul(u.y, v.y)).over <= 0n) break;
      kept.pop();
    }
    kept.push(point);
  }
  return kept;
}
