// Small worlds and runs as the server packs them.

import { emptyWorld } from "#player/edit/model.js";

export function base64(bytes) {
  return btoa(String.fromCharCode(...bytes));
}

/* Packs whole numbers like fuzz/player/streams.py: second differences, zigzag,
   seven bits per byte. */
export function numbers(values) {
  const bytes = [];
  let before = 0,
    rate = 0;
  for (const value of values) {
    const change = value - before - rate;
    rate += change;
    before = value;
    let zigzag = change < 0 ? -2 * change - 1 : 2 * change;
    while (zigzag > 127) {
      bytes.push((zigzag % 128) + 128);
      zigzag = Math.floor(zigzag / 128);
    }
    bytes.push(zigzag);
  }
  return base64(bytes);
}

export function bits(flags) {
  const bytes = new Uint8Array(Math.ceil(flags.length / 8));
  flags.forEach((flag, k) => (bytes[k >> 3] |= Number(Boolean(flag)) << (k & 7)));
  return base64(bytes);
}

/* Makes a world from cells, row by row from the lowest. */
export function worldOf(cells, width, more = {}) {
  const height = cells.length / width;
  const usual = { cell: 0.1, radius: 0.7, start: [1.5, 1.5, 0], target: [width - 1.5, height - 1.5, 0.5], events: null, witness: null };
  return { width, height, cells: bits(cells), ...usual, ...more };
}

/* Makes an empty world with a border of walls, and other walls in it. */
export function roomOf(width, height, walls = [], more = {}) {
  const border = (ix, iy) => ix === 0 || iy === 0 || ix === width - 1 || iy === height - 1;
  const cells = Array.from({ length: width * height }, (_, k) => border(k % width, Math.floor(k / width)));
  for (const [ix, iy] of walls) cells[iy * width + ix] = true;
  return worldOf(cells, width, more);
}

/** Units of packed runs, as parts of a step, a cell and a turn;
 * they may differ from the server's. */
export const PER = { step: 16, cell: 100, turn: 3600 };

/* Makes a run through places in cells, at times in steps. */
export function runOf({ at, x, y = x.map(() => 1), heading = x.map(() => 0), bump = x.map(() => 0), ...more }) {
  const scaled = (values, by) => numbers(values.map((value) => Math.round(value * by)));
  const columns = { per: PER, at: scaled(at, PER.step), x: scaled(x, PER.cell), y: scaled(y, PER.cell), heading: scaled(heading, PER.turn / (2 * Math.PI)), bump: bits(bump) };
  const usual = { steps: Math.floor(at.at(-1)), dt: 0.1, loop: null, marks: [], thinned: 1, tolerance: null, active: null, memory: null };
  return { ...columns, ...usual, ...more };
}

/** Limits as the server sends them. */
export const LIMITS = {
  message: 32 * 2 ** 20, dropped: 16 * 2 ** 20, side: 20_000, cells: 4_194_304, lengths: [0.0001, 10_000], robots: 6,
  seed: "18446744073709551615", steps: 1_000_000, time_steps: [0.001, 10], seconds: 604_800, units: 1_000_000, workers: 256, examples: 100_000, epoch: 100_000, fleet: 100,
};

/** What the server writes into the page. */
export const GIVEN = { protocol: 2, subprotocol: "worldgen-studio", full: 4000, world: { cell_size: 0.1, robot_radius: 0.07, robot_speed: 2 } };

/* A new world. */
export const blank = (width, height) => emptyWorld(width, height, GIVEN.world);
