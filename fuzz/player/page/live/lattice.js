// A world on the lattice of poses: worldgen/lattice.py and sim/runners/packing.py, in a page.

import { ceil, div, exact, float, floor, fraction, mul, nearest, root, square } from "#player/live/exact.js";

/** @typedef {import("#player/live/exact.js").Fraction} Fraction */

/** Lattice units in a cell. */
export const UNIT = 1024;
export const UNITS = fraction(UNIT);
export const HALF = UNIT / 2;
/** Heading units in a turn. */
export const TURN = 65536;

/**
 * Returns (height, width) 1 where a cell is solid, the lowest row first.
 * @param {LiveWorld} world
 */
export function solidOf(world) {
  const height = world.cells.length;
  const width = world.cells[0].length;
  const solid = new Uint8Array(height * width);
  for (const [k, row] of world.cells.entries()) {
    for (let ix = 0; ix < width; ix++) solid[(height - 1 - k) * width + ix] = Number(row[ix] === "#");
  }
  return { solid, width, height };
}

/**
 * Returns a length in cells, exactly.
 * @param {number} metres
 * @param {number} cellSize
 */
export const inCells = (metres, cellSize) => div(exact(metres), exact(cellSize));

/**
 * Returns a length in lattice units, exactly.
 * @param {number} metres
 * @param {number} cellSize
 */
export const inUnits = (metres, cellSize) => mul(inCells(metres, cellSize), UNITS);

/**
 * Returns the nearest coordinate of the lattice; halves go up.
 * @param {number} metres
 * @param {number} cellSize
 */
export const toLattice = (metres, cellSize) => nearest(inUnits(metres, cellSize));

/**
 * Returns a coordinate of the lattice in m, rounded once.
 * @param {number | bigint} units
 * @param {number} cellSize
 */
export const toMetres = (units, cellSize) => float(mul(fraction(units, UNIT), exact(cellSize)));

/**
 * Returns heading units from 0, the nearest.
 * @param {number} heading rad
 */
export function headingToLattice(heading) {
  const units = Math.floor((heading % (2 * Math.PI)) * (TURN / (2 * Math.PI)) + 0.5) % TURN;
  return units < 0 ? units + TURN : units;
}

/**
 * Returns a heading in (-pi, pi].
 * @param {number} units
 */
export const headingFromLattice = (units) => (units > TURN / 2 ? units - TURN : units) * ((2 * Math.PI) / TURN);

/**
 * Returns the squared distance that a disc keeps, and its root, rounded up: both in lattice units.
 * @param {Fraction} radius cells
 */
export function discNumbers(radius) {
  const exactly = ceil(square(mul(radius, UNITS)));
  const clear = exactly > 1n ? exactly : 1n;
  return { clear_sq: clear, reach: root(clear - 1n) + 1n };
}

/**
 * Returns the squared radius of the target, lattice units squared, rounded down.
 * @param {LiveWorld} world
 */
export const targetSq = (world) => floor(square(inUnits(world.target[2], world.cell_size)));
