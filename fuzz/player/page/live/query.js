// A question about a static world as the core takes it: worldgen/reach/still/core_calls.py.

import {
  add,
  ceil,
  div,
  even,
  exact,
  float,
  fraction,
  isLess,
  lcm,
  most,
  mul,
  nearest,
  square,
  sub,
} from "#player/live/exact.js";
import { HALF, UNIT, UNITS, inCells, inUnits, solidOf, toLattice } from "#player/live/lattice.js";

/** @typedef {import("#player/live/exact.js").Fraction} Fraction */
/** @typedef {import("#player/live/core.js").Core} Core */

const ONE = fraction(1);
const TWO = fraction(2);
const FOUR = fraction(4);
/** The part of the radius by which a path to an irrational pose may be too close. */
export const ROUNDING = fraction(1n, 1n << 120n);
const LONGEST = 1n << 61n;

/** @typedef {import("#player/live/walls.js").Point} Point */

/**
 * The question, in lattice units.
 * @typedef {object} Query
 * @property {number} walls a WgWalls
 * @property {Uint8Array} solid
 * @property {number} width
 * @property {number} height
 * @property {Fraction} radius cells
 * @property {Point} start on the lattice
 * @property {Point} exactStart
 * @property {Fraction} x of the target
 * @property {Fraction} y
 * @property {Fraction} reach radius of the target
 * @property {Point | null} goal a clear pose of the target, if one is known
 * @property {boolean} isRounded whether the lengths have few digits already
 */

/**
 * @param {Core} core
 * @param {LiveWorld} world
 * @returns {Query}
 */
export function queryOf(core, world) {
  const grid = solidOf(world);
  const side = world.cell_size;
  const [x, y] = world.start;
  const { width, height } = grid;
  return {
    ...grid,
    walls: core.make("WgWalls", { solid: core.array(grid.solid, "uint8_t"), width, height }),
    radius: inCells(world.radius, side),
    start: { x: fraction(toLattice(x, side)), y: fraction(toLattice(y, side)) },
    exactStart: { x: inUnits(x, side), y: inUnits(y, side) },
    x: inUnits(world.target[0], side),
    y: inUnits(world.target[1], side),
    reach: inUnits(world.target[2], side),
    goal: null,
    isRounded: false,
  };
}

/** @param {Query} query */
export const isOffLattice = ({ start, exactStart }) => !isSame(start, exactStart);

/**
 * @param {Point} p
 * @param {Point} q
 */
export const isSame = (p, q) =>
  p.x.over === q.x.over && p.x.under === q.x.under && p.y.over === q.y.over && p.y.under === q.y.under;

/**
 * Returns the fields of a WgDisc, under a name.
 * @param {string} name
 * @param {Fraction} radius cells
 */
export function discFields(name, radius) {
  const units = mul(radius, UNITS);
  const squared = square(units);
  return {
    [`${name}.reach`]: ceil(units),
    [`${name}.limit`]: ceil(squared),
    [`${name}.radius_sq`]: float(squared),
  };
}

/**
 * Returns the smallest squared gap, in cells, that a disc fits through.
 * @param {Fraction} radius cells
 */
export const linkLimit = (radius) => ceil(square(mul(TWO, radius)));

/**
 * Returns how often to halve a lattice unit so that a rounded pose stays on its side of each link.
 * @param {Fraction} radius cells
 */
export function refinement(radius) {
  const widest = fraction(linkLimit(radius) - 1n);
  const away = div(sub(square(radius), div(widest, FOUR)), mul(TWO, radius));
  const parts = ceil(div(ONE, mul(away, UNITS))) - 1n;
  return parts > 0n ? parts.toString(2).length : 0;
}

/**
 * Returns the fields of a WgTarget: lengths as whole numbers of 1 / scale cell, and as floats.
 * @param {Query} query
 */
export function targetOf({ radius, x, y, reach }) {
  const lengths = [div(x, UNITS), div(y, UNITS), radius, div(reach, UNITS)];
  const floats = {
    "target.centre_x": float(lengths[0]),
    "target.centre_y": float(lengths[1]),
    "target.robot_radius": float(radius),
    "target.disc_radius": float(lengths[3]),
    "target.radius": -1n,
  };
  for (const values of [lengths, lengths.slice(0, 3)]) {
    const scale = values.map((value) => value.under).reduce(lcm);
    const whole = values.map((value) => value.over * (scale / value.under));
    if (scale >= LONGEST || whole.some((value) => value >= LONGEST)) continue;
    const [centreX, centreY, robot, own = -1n] = whole;
    const exactly = { "target.x": centreX, "target.y": centreY, "target.reach": robot, "target.radius": own };
    return { ...floats, ...exactly, "target.scale": scale };
  }
  return floats;
}

/**
 * Returns the lattice pose nearest to the target's centre, if it is in the target.
 * @param {Query} query
 */
function latticeCentre({ x, y, reach }) {
  const goal = { x: fraction(nearest(x)), y: fraction(nearest(y)) };
  const away = add(square(sub(goal.x, x)), square(sub(goal.y, y)));
  return isLess(square(reach), away) ? null : goal;
}

/**
 * Returns the resolution of a path's times: a microsecond, or less for a fast robot.
 * @param {LiveWorld} world
 */
export function ticksPerSecond({ cell_size: side, speed }) {
  let ticks = 1e6;
  while ((side / speed) * ticks < 1000 && ticks < 1e12) ticks *= 10;
  return ticks;
}

/**
 * Returns the square of the ticks that a lattice unit takes.
 * @param {LiveWorld} world
 */
export function ticksPerUnitSq(world) {
  const ticks = fraction(ticksPerSecond(world));
  return square(div(mul(exact(world.cell_size), ticks), mul(UNITS, exact(world.speed))));
}

/**
 * Returns a WgStill; null if one of its numbers has too many digits.
 * @param {Core} core
 * @param {LiveWorld} world
 * @param {Query} query
 */
export function askOf(core, world, query) {
  const { radius, start } = query;
  const metre = div(exact(world.cell_size), UNITS);
  const tick = ticksPerUnitSq(world);
  const goal = latticeCentre(query);
  const rounded = isOffLattice(query);
  const unit = rounded ? fraction(1, UNIT) : fraction(0);
  const inner = most(sub(radius, unit), fraction(0));
  /** @type {import("#player/live/core.js").Fields} */
  const fields = {
    start_x: start.x.over,
    start_y: start.y.over,
    ...(goal ? { has_goal: 1, goal_x: goal.x.over, goal_y: goal.y.over } : {}),
    toward_x: even(div(query.x, fraction(HALF))),
    toward_y: even(div(query.y, fraction(HALF))),
    clear_from: ceil(square(mul(FOUR, radius))),
    limit: refinement(radius) ? 0n : linkLimit(radius),
    ...discFields("disc", radius),
    ...discFields("start_disc", add(radius, unit)),
    ...discFields("start_core", inner),
    ...discFields("goal_disc", mul(radius, sub(ONE, ROUNDING))),
    ...discFields("both", add(radius, div(query.reach, UNITS))),
    ...targetOf(query),
    "pace.metre_over": metre.over,
    "pace.metre_under": metre.under,
    "pace.tick_over": tick.over,
    "pace.tick_under": tick.under,
    "pace.ticks": ticksPerSecond(world),
    wants_path: 1,
    wants_cut: 1,
  };
  const isLong = Object.values(fields).some((value) => typeof value === "bigint" && value >= 1n << 63n);
  return isLong || metre.under >= 1n << 53n ? null : core.make("WgStill", fields);
}
