// The timed path of a proof, and its clearance: worldgen/reach/still/path.py.

import { add, div, exact, float, fraction, least, mul, root, rootDown, square, sub } from "#player/live/exact.js";
import { UNITS } from "#player/live/lattice.js";
import { ticksPerSecond, ticksPerUnitSq } from "#player/live/query.js";
import { clearanceSq } from "#player/live/walls.js";

/** @typedef {import("#player/live/exact.js").Fraction} Fraction */
/** @typedef {import("#player/live/core.js").Core} Core */
/** @typedef {import("#player/live/query.js").Query} Query */
/** @typedef {import("#player/live/walls.js").Point} Point */
/** @typedef {NonNullable<LiveProof["witness"]>} Witness */

/**
 * Returns the path in an answer of the core: its corners, and as a witness.
 * @param {Core} core
 * @param {LiveWorld} world
 * @param {number} asked a WgStill that has found one
 * @returns {{ points: Point[], witness: Witness }}
 */
export function pathOf(core, world, asked) {
  const { count, room, points, metres, corners } = core.all(asked, "WgStill");
  const whole = (/** @type {number} */ part, /** @type {number} */ length) =>
    Array.from(core.view(points + 8 * part * room, length, "int64_t"));
  const floats = (/** @type {number} */ part) => Array.from(core.view(metres + 8 * part * room, count, "double"));
  const [x, y] = [whole(0, count), whole(1, count)];
  const [sides, lengthsSq] = [whole(2, corners), whole(3, corners)];
  const squares = sides.map((side, k) => fraction(side * side, lengthsSq[k]));
  const nearest = squares.reduce(least, fraction(core.whole(asked, "WgStill", "least")));
  return {
    points: x.map((at, k) => ({ x: fraction(at), y: fraction(y[k]) })),
    witness: { t: floats(2), x: floats(0), y: floats(1), clearance: clearanceOf(world, nearest) },
  };
}

/**
 * @param {LiveWorld} world
 * @param {Fraction} squared lattice units
 */
const clearanceOf = (world, squared) => rootDown(mul(squared, square(div(exact(world.cell_size), UNITS))));

/**
 * Returns a path at the robot's speed. Times are rounded up to ticks, so that no piece is too fast.
 * @param {LiveWorld} world
 * @param {Query} query
 * @param {Point[]} points
 * @returns {Witness}
 */
export function witnessOf(world, query, points) {
  const metre = div(exact(world.cell_size), UNITS);
  return {
    t: timesOf(world, points),
    x: points.map(({ x }) => float(mul(x, metre))),
    y: points.map(({ y }) => float(mul(y, metre))),
    clearance: clearanceOf(world, clearanceSq(query, points)),
  };
}

/**
 * Returns the time of each point of a path, s.
 * @param {LiveWorld} world
 * @param {Point[]} points
 */
export function timesOf(world, points) {
  const perUnitSq = ticksPerUnitSq(world);
  const ticks = ticksPerSecond(world);
  let time = 0n;
  return points.map((q, k) => {
    if (k) {
      const p = points[k - 1];
      const { over, under } = mul(add(square(sub(q.x, p.x)), square(sub(q.y, p.y))), perUnitSq);
      const whole = root(over / under);
      time += whole * whole * under >= over ? whole : whole + 1n;
    }
    return Number(time) / ticks;
  });
}

/** @param {Witness} witness */
export const reached = (witness) =>
  proofOfPath(witness, (length, room) => `a path of ${short(length)} m lets discs of up to ${short(room)} m through`);

/**
 * @param {Witness} witness
 * @param {(length: number, clearance: number) => string} words
 * @returns {LiveProof}
 */
export const proofOfPath = (witness, words) => ({
  reachable: true,
  reason: words(lengthOf(witness), witness.clearance),
  witness,
  cut: null,
});

/** @param {Witness} path */
const lengthOf = ({ x, y }) => x.slice(1).reduce((sum, at, k) => sum + Math.hypot(at - x[k], y[k + 1] - y[k]), 0);

/**
 * Returns a number with some digits, as Python's ``.4g`` does.
 * @param {number} value
 */
export function short(value, count = 4) {
  const [digits, power] = value.toExponential(count - 1).split("e");
  const exponent = Number(power);
  const isPlain = exponent >= -4 && exponent < count;
  const text = isPlain ? value.toFixed(count - 1 - exponent) : digits;
  const trimmed = text.includes(".") ? text.replace(/\.?0+$/, "") : text;
  return isPlain ? trimmed : `${trimmed}e${power[0]}${power.slice(1).padStart(2, "0")}`;
}
