// Exact distances between points, segments and solid cells: worldgen/reach/still/walls.py.

import { add, div, float, fraction, isLess, least, most, mul, square, sub } from "#player/live/exact.js";
import { UNIT, UNITS } from "#player/live/lattice.js";

/** @typedef {import("#player/live/exact.js").Fraction} Fraction */
/** @typedef {{ x: Fraction, y: Fraction }} Point in lattice units */
/** @typedef {{ solid: Uint8Array, width: number, height: number }} Grid */
/** @typedef {[number, number]} Cell */

/** Share by which a distance of floats may be wrong, and more. */
const ROUGH = 1e-9;

/**
 * Returns the solid cells that may be within a reach of a segment, and those around the grid.
 * @param {Grid} grid
 * @param {Point} p
 * @param {Point} q
 * @param {number} reach lattice units
 */
function near({ solid, width, height }, p, q, reach) {
  const range = (/** @type {number} */ a, /** @type {number} */ b, /** @type {number} */ size) => {
    const first = Math.floor((Math.min(a, b) - reach) / UNIT) - 1;
    const last = Math.floor((Math.max(a, b) + reach) / UNIT) + 1;
    return [Math.max(-1, first), Math.min(size, last)];
  };
  const [left, right] = range(float(p.x), float(q.x), width);
  const [low, high] = range(float(p.y), float(q.y), height);
  /** @type {Cell[]} */
  const cells = [];
  for (let iy = low; iy <= high; iy++) {
    for (let ix = left; ix <= right; ix++) {
      const outside = ix < 0 || iy < 0 || ix >= width || iy >= height;
      if (outside || solid[iy * width + ix]) cells.push([ix, iy]);
    }
  }
  return cells;
}

/**
 * Reports whether a disc may sweep from p to q.
 * @param {Grid} grid
 * @param {Fraction} radius cells
 * @param {Point} p
 * @param {Point} q
 */
export function isClear(grid, radius, p, q) {
  const limit = square(mul(radius, UNITS));
  const rough = float(limit);
  return near(grid, p, q, Math.sqrt(rough) + 1).every((cell) => {
    const about = roughSq(p, q, cell);
    if (Math.abs(about - rough) > ROUGH * (about + rough + 1)) return about > rough;
    return !isLess(segmentBoxSq(p, q, cell), limit);
  });
}

/**
 * Returns the squared distance from a path to the nearest solid cell.
 * @param {Grid} grid
 * @param {Point[]} points
 */
export function clearanceSq(grid, points) {
  const pieces = points.length > 1 ? points.slice(1).map((q, k) => ({ p: points[k], q })) : [{ p: points[0], q: points[0] }];
  for (let reach = UNIT; ; reach *= 2) {
    // Floats leave a few that may be the nearest.
    const found = pieces.flatMap(({ p, q }) =>
      near(grid, p, q, reach).map((cell) => ({ p, q, cell, about: roughSq(p, q, cell) })),
    );
    const nearest = found.reduce((best, { about }) => Math.min(best, about), reach * reach);
    if (nearest >= reach * reach) continue;
    return found
      .filter(({ about }) => about <= nearest + ROUGH * (nearest + 1))
      .map(({ p, q, cell }) => segmentBoxSq(p, q, cell))
      .reduce(least);
  }
}

/**
 * Returns about the squared distance from a segment to a cell.
 * @param {Point} p
 * @param {Point} q
 * @param {Cell} cell
 */
function roughSq(p, q, [ix, iy]) {
  const [px, py, qx, qy] = [p.x, p.y, q.x, q.y].map((value, k) => float(value) - (k % 2 ? iy : ix) * UNIT);
  const ends = [[px, py], [qx, qy]].map(([x, y]) => Math.max(-x, 0, x - UNIT) ** 2 + Math.max(-y, 0, y - UNIT) ** 2);
  let best = Math.min(...ends);
  const [ex, ey] = [qx - px, qy - py];
  const lengthSq = ex * ex + ey * ey;
  if (!best || !lengthSq) return best;
  let [low, high] = [Infinity, -Infinity];
  for (const [cx, cy] of CORNERS) {
    const side = ex * (cy - py) - ey * (cx - px);
    const ahead = ex * (cx - px) + ey * (cy - py);
    [low, high] = [Math.min(low, side), Math.max(high, side)];
    if (ahead > 0 && ahead < lengthSq) best = Math.min(best, (side * side) / lengthSq);
  }
  const apart = Math.max(px, qx) < 0 || Math.min(px, qx) > UNIT || Math.max(py, qy) < 0 || Math.min(py, qy) > UNIT;
  return !apart && low <= 0 && high >= 0 ? 0 : best;
}

const CORNERS = [0, 1, 2, 3].map((k) => [(k & 1) * UNIT, (k >> 1) * UNIT]);

/**
 * @param {Point} p
 * @param {Cell} cell
 */
function pointBoxSq(p, [ix, iy]) {
  const apart = (/** @type {Fraction} */ at, /** @type {number} */ index) => {
    const low = fraction(index * UNIT);
    return most(most(sub(low, at), sub(at, add(low, UNITS))), fraction(0));
  };
  return add(square(apart(p.x, ix)), square(apart(p.y, iy)));
}

/**
 * Returns the squared distance from a segment to a cell.
 * @param {Point} p
 * @param {Point} q
 * @param {Cell} cell
 */
function segmentBoxSq(p, q, cell) {
  const ends = least(pointBoxSq(p, cell), pointBoxSq(q, cell));
  if (!ends.over) return ends;
  const along = { x: sub(q.x, p.x), y: sub(q.y, p.y) };
  const lengthSq = add(square(along.x), square(along.y));
  if (!lengthSq.over) return ends;
  // Otherwise the segment crosses the cell, or a corner of it is nearest.
  const corners = [0, 1, 2, 3].map((k) => {
    const x = sub(fraction((cell[0] + (k & 1)) * UNIT), p.x);
    const y = sub(fraction((cell[1] + (k >> 1)) * UNIT), p.y);
    return {
      side: sub(mul(along.x, y), mul(along.y, x)),
      ahead: add(mul(along.x, x), mul(along.y, y)),
    };
  });
  let best = ends;
  for (const { side, ahead } of corners) {
    if (ahead.over > 0n && isLess(ahead, lengthSq)) best = least(best, div(square(side), lengthSq));
  }
  return meetsBox(p, q, cell, corners.map(({ side }) => side.over)) ? fraction(0) : best;
}

/**
 * @param {Point} p
 * @param {Point} q
 * @param {Cell} cell
 * @param {bigint[]} sides on which the corners are of the segment's line
 */
function meetsBox(p, q, [ix, iy], sides) {
  const apart = (/** @type {Fraction} */ a, /** @type {Fraction} */ b, /** @type {number} */ index) => {
    const low = fraction(index * UNIT);
    return isLess(most(a, b), low) || isLess(add(low, UNITS), least(a, b));
  };
  if (apart(p.x, q.x, ix) || apart(p.y, q.y, iy)) return false;
  return sides.some((side) => side <= 0n) && sides.some((side) => side >= 0n);
}

/**
 * Returns the solid cell that is nearest to a point, the leftmost and lowest of several.
 * @param {Grid} grid
 * @param {Point} p
 */
export function nearestCell(grid, p) {
  for (let reach = UNIT; ; reach *= 2) {
    const found = near(grid, p, p, reach)
      .map((cell) => ({ cell, squared: pointBoxSq(p, cell) }))
      .sort((a, b) => (isLess(a.squared, b.squared) ? -1 : isLess(b.squared, a.squared) ? 1 : order(a.cell, b.cell)));
    if (found.length && !isLess(fraction(reach * reach), found[0].squared)) return found[0];
  }
}

/**
 * @param {Cell} a
 * @param {Cell} b
 */
const order = (a, b) => a[0] - b[0] || a[1] - b[1];
