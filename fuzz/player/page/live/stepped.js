// Runs the thesis's own robot under `stepped`, as sim/thesis/run.py does. Its frame has pixels, ten
// in a cell, y down, and headings that grow clockwise from -x.

import { Trail, keptSteps } from "#player/live/drawn.js";
import { add, div, exact, float, floor, fraction, mul, sub } from "#player/live/exact.js";
import { discNumbers, inCells, solidOf, toLattice } from "#player/live/lattice.js";
import { RECORDED_AT_ONCE, endingOf, evidenceOf, fnv1a, multipleOf, verdictOf } from "#player/live/verdict.js";

/** @typedef {import("#player/live/core.js").Core} Core */

const CELL = 10;
/** Pixels that one call steps through, about. */
const WORK = 1 << 22;
/** Random numbers that a run of the random rule gets at first. */
const FIRST_DRAWS = 256;
const GAMMA = 0x9e3779b97f4a7c15n;
const MASK = (1n << 64n) - 1n;
/** Poses that differ by less, in pixels and rad, count as the same: sim/thesis/run.py. */
const DRIFT = 1e-6;
/** Periods that must be seen before a drift is reported: sim/runners/drifting.py. */
const PERIODS = 4;

/** @typedef {[number, number, number]} Place in the thesis's frame: x, y, heading */
/**
 * @typedef {object} Recorded
 * @property {Trail} trail
 * @property {(step: number) => boolean} isKept whether to draw a step
 * @property {number} half step from which places are kept
 * @property {Place[]} late
 */

/**
 * Runs a recipe in a world until the verdict is certain.
 * @param {Core} core the simulator
 * @param {LiveWorld} world
 * @param {LiveRecipe} recipe of `stepped`
 * @param {LiveProof["witness"]} witness
 * @param {number} budget steps
 * @param {() => Promise<void>} pause throws if a newer question has come
 * @returns {Promise<LiveRun | string>} the run, or why it cannot start
 */
export async function runStepped(core, world, recipe, witness, budget, pause) {
  const frame = frameOf(core, world, recipe);
  if (typeof frame === "string") return frame;
  const { constants } = core;
  const seeks = recipe.finds_loops ? constants.WG_SEEK_LOOP : constants.WG_NO_LOOP;

  // A recurrence that is found is proved by another run; if that fails, the budget decides.
  let found = await frame.run({ steps: budget, find_loop: seeks, digest: 1 }, null, pause);
  if (endingOf(core, found.all.ending) === "loop") {
    const { entry, period } = found.all;
    const proved = { steps: entry + period, find_loop: constants.WG_PROVE_LOOP, loop_entry: entry, digest: 1 };
    found = await frame.run(proved, null, pause);
    if (endingOf(core, found.all.ending) !== "loop") {
      found = await frame.run({ steps: budget, find_loop: constants.WG_NO_LOOP, digest: 1 }, null, pause);
    }
  }
  const ended = found.all;

  // The verdict. In a run that walls do not end, they do not decide it either.
  const ends = recipe.setup.stop_at_tunnel === 1;
  const overlap = ends ? ended["overlap.step"] : -1;
  const { steps, last_new_cell } = ended;
  const verdict = verdictOf(endingOf(core, ended.ending), { steps, last_new_cell, overlap_step: overlap });
  const isLoop = verdict === "loop";
  const place = { tunnel: "tunnel", overlap: "overlap", burned: "hit" }[verdict];
  const judged = {
    verdict,
    steps,
    entry: isLoop ? ended.entry : -1,
    period: isLoop ? ended.period : 0,
    last_new_cell,
    hit: place ? frame.placeOf(ended, place) : null,
  };
  const entered = place === "tunnel" || place === "overlap" ? causeOf(core, ended, place) : {};
  const { WG_SOLID } = constants;

  // Again, for the path, and for the second half of a run that stalls.
  const trail = new Trail();
  const half = verdict === "stalled" ? Math.floor(steps / 2) : Infinity;
  /** @type {Place[]} */
  const late = [];
  const recorded = { trail, isKept: keptSteps(judged), half, late };
  await frame.run({ steps, find_loop: constants.WG_NO_LOOP, digest: 0 }, recorded, pause);
  const evidence = evidenceOf(judged, {
    stateDigest: () => fnv1a(found.state),
    entered,
    burned: ended["hit.state"] === WG_SOLID ? "solid" : "burning",
    multiple: multipleOf(recipe, steps, witness),
    confined: late.length ? confinedIn(late, half) : {},
  });
  return {
    ...judged,
    evidence,
    time: Number((steps * recipe.time_step).toFixed(9)),
    budget,
    digest: found.digest.toString(16).padStart(16, "0"),
    path_length: ended.path_length * (world.cell_size / CELL),
    collisions: ended.collisions,
    error: "",
    start: world.start,
    drawn: trail.drawn(judged, recipe),
  };
}

/**
 * Lays a world out in the thesis's frame.
 * @param {Core} core
 * @param {LiveWorld} world
 * @param {LiveRecipe} recipe
 */
function frameOf(core, world, recipe) {
  // A world with an open border gets a wall around it.
  const side = world.cell_size;
  const { solid, width: columns, height: rows } = solidOf(world);
  const isWall = (/** @type {number} */ ix, /** @type {number} */ iy) =>
    ix < 0 || iy < 0 || ix >= columns || iy >= rows || solid[iy * columns + ix] === 1;
  let closed = true;
  for (let ix = 0; ix < columns; ix++) closed &&= isWall(ix, 0) && isWall(ix, rows - 1);
  for (let iy = 0; iy < rows; iy++) closed &&= isWall(0, iy) && isWall(columns - 1, iy);
  const pad = closed ? 0 : 1;
  const width = columns + 2 * pad;
  const height = rows + 2 * pad;
  const rowOf = (/** @type {number} */ row) => height - 1 - pad - row;

  // Start and target.
  const radius = inCells(world.radius, side);
  if (radius.over > radius.under) return "Under stepped, a robot can be at most two cells wide.";
  const targetX = Number(floor(inCells(world.target[0], side))) + pad;
  const targetY = rowOf(Number(floor(inCells(world.target[1], side))));
  const inside = targetX > 0 && targetX < width - 1 && targetY > 0 && targetY < height - 1;
  if (!inside || isWall(targetX - pad, rowOf(targetY))) return "The target is in a wall, which has no signal.";
  const disc = core.make("WgSettings", { ...discNumbers(radius) });
  const grid = core.make("WgGrid", { cells: core.array(solid, "uint8_t"), width: columns, height: rows });
  const at = [toLattice(world.start[0], side), toLattice(world.start[1], side), 0n];
  if (!core.call("wg_robot_is_clear", grid, core.constants.WG_SOLID, 0, disc, ...at)) {
    return "The robot overlaps a wall at its start.";
  }
  const ten = fraction(CELL);
  const startX = float(add(mul(inCells(world.start[0], side), ten), fraction(CELL * pad)));
  const startY = float(mul(sub(fraction(height - pad), inCells(world.start[1], side)), ten));
  const heading = modulo(Math.PI - world.start[2], 2 * Math.PI);

  // The signal, stored column by column, and how it is without walls.
  const light = new Int32Array(width * height);
  const signal = new Int32Array(width * height);
  const { WG_THESIS_WALL: wall } = core.constants;
  for (let ix = 0; ix < width; ix++) {
    for (let iy = 0; iy < height; iy++) {
      const isRim = ix === 0 || iy === 0 || ix === width - 1 || iy === height - 1;
      const away = (ix - targetX) ** 2 + (iy - targetY) ** 2;
      light[ix * height + iy] = isRim ? wall : away;
      signal[ix * height + iy] = isRim || isWall(ix - pad, rowOf(iy)) ? wall : away;
    }
  }
  const lights = core.array(light, "int32_t");
  const signals = core.array(signal, "int32_t");
  if (recipe.noise) core.check("wg_thesis_add_noise", signals, lights, BigInt(width), BigInt(height));
  const events = recipe.events.flatMap(([step, ix, iy, state]) => [step, ix + pad, rowOf(iy), state].map(BigInt));
  const perMetre = div(ten, exact(side));
  const robot = {
    ...recipe.setup,
    target_x: targetX,
    target_y: targetY,
    radius: float(mul(radius, ten)),
    speed: float(div(mul(exact(world.speed), perMetre), fraction(1000))),
  };
  const draws = drawsOf(recipe);

  /**
   * Runs from the start.
   * @param {Record<string, number>} setup fields of the settings that differ
   * @param {Recorded | null} recorded
   * @param {() => Promise<void>} pause
   */
  async function run(setup, recorded, pause) {
    const settings = core.make("WgThesisSettings", { ...robot, ...setup });
    const arena = core.make("WgThesisArena", {
      width,
      height,
      cells: core.array(core.view(signals, width * height, "int32_t"), "int32_t"),
      light: lights,
      events: core.array(events, "int64_t"),
      event_count: recipe.events.length,
      visited: core.zeros(width * height),
    });
    const seeks = setup.find_loop === core.constants.WG_SEEK_LOOP;
    const logged = seeks ? setup.steps + 1 : 1;
    const words = core.constants.WG_THESIS_WORDS;
    const search = core.make("WgSearch", {
      log: core.zeros(8 * logged),
      log_size: logged,
      known: core.zeros(8 * words),
      words,
    });
    const state = core.make("WgThesisRun");
    core.call("wg_thesis_begin", state, startX, startY, heading, robot.speed);
    const portion = recorded ? RECORDED_AT_ONCE : Math.max(1, Math.trunc(WORK / Math.max(1, robot.speed * Number(recipe.setup.time_step))));
    const room = recorded ? portion + 1 : 0;
    const rows = core.zeros(room * core.size("WgThesisRow"));
    let count = FIRST_DRAWS;
    for (;;) {
      const first = core.get(state, "WgThesisRun", "steps");
      const [numbers, given] = draws(core, count);
      const until = Math.min(setup.steps, first + portion);
      core.check(
        "wg_thesis_run",
        ...[arena, settings, state, search, numbers, BigInt(given), rows, BigInt(room), BigInt(first), BigInt(until)],
      );
      const steps = core.get(state, "WgThesisRun", "steps");
      if (recorded) takeRows(rows, first, steps, recorded);
      const ending = core.get(state, "WgThesisRun", "ending");
      if (ending === core.constants.WG_NEEDS_DRAWS) count *= 4;
      else if (ending !== core.constants.WG_LIMIT || steps >= setup.steps) break;
      await pause();
    }
    const known = core.get(search, "WgSearch", "known");
    return {
      all: core.all(state, "WgThesisRun"),
      digest: core.whole(state, "WgThesisRun", "digest"),
      state: stateWords(core, core.view(known, words, "uint64_t")),
    };
  }

  /**
   * Takes the states after some steps.
   * @param {number} table
   * @param {number} first step of the first row
   * @param {number} last
   * @param {Recorded} recorded
   */
  function takeRows(table, first, last, { trail, isKept, half, late }) {
    const columns = core.size("WgThesisRow") / 8;
    const numbers = core.view(table, columns * (last - first + 1), "double");
    const [atX, atY, atHeading, atBump] = ["x", "y", "heading", "collision"].map(
      (name) => core.offset("WgThesisRow", name) / 8,
    );
    for (let step = first + Number(first > 0); step <= last; step++) {
      const row = numbers.subarray((step - first) * columns);
      const touches = row[atBump] !== 0;
      if (touches) trail.touch(step);
      if (step >= half) late.push([row[atX], row[atY], row[atHeading]]);
      if (!isKept(step)) continue;
      const turned = modulo(2 * Math.PI - row[atHeading], 2 * Math.PI) - Math.PI;
      trail.add(step, row[atX] / CELL - pad, height - pad - row[atY] / CELL, turned, Number(touches));
    }
  }

  /**
   * Returns a place of a run, in the world's frame.
   * @param {Record<string, number | bigint>} ended
   * @param {string} name
   * @returns {NonNullable<LiveRun["hit"]>}
   */
  const placeOf = (ended, name) => ({
    step: Number(ended[`${name}.step`]),
    cell: [Number(ended[`${name}.x`]) - pad, rowOf(Number(ended[`${name}.y`]))],
  });
  return { run, placeOf };
}

/**
 * Returns the move that led into a wall, if there is one.
 * @param {Core} core
 * @param {Record<string, number>} ended
 * @param {string} place
 */
function causeOf(core, ended, place) {
  const { WG_SLIDE, WG_BACK_OFF, WG_CORNER } = core.constants;
  const cause = new Map([[WG_SLIDE, "slide"], [WG_BACK_OFF, "back-off"], [WG_CORNER, "corner"]]).get(ended[`${place}.cause`]);
  return cause ? { cause, since: ended[`${place}.began`] } : {};
}

/**
 * Returns how a robot behaves in the second half of a run that stalls.
 * @param {Place[]} places
 * @param {number} half step of the first one
 */
function confinedIn(places, half) {
  const [columns, rows] = [0, 1].map((axis) => {
    const cells = places.map((place) => Math.floor(place[axis] / CELL));
    return cells.reduce((a, b) => Math.max(a, b)) - cells.reduce((a, b) => Math.min(a, b)) + 1;
  });
  const box = [columns, rows];
  const recurs = periodOf(places);
  return recurs ? { kind: "drifting", entry: half + recurs.entry, period: recurs.period, box } : { kind: "confined", box };
}

/**
 * Returns the shortest period in which places recur until the end, and the first such one; null if
 * there is none.
 * @param {Place[]} places
 */
function periodOf(places) {
  const last = places.length - 1;
  const isNear = (/** @type {number} */ a, /** @type {number} */ b) => places[a].every((value, k) => Math.abs(value - places[b][k]) < DRIFT);
  for (let period = 1; PERIODS * period <= places.length; period++) {
    if (!isNear(last - period, last)) continue;
    let entry = last - period;
    while (entry > 0 && isNear(entry - 1, entry - 1 + period)) entry -= 1;
    if (last - entry >= PERIODS * period) return { period, entry };
  }
  return null;
}

/**
 * Returns a state in the words of a trace, which has its whole numbers as floats.
 * @param {Core} core
 * @param {BigUint64Array} known
 */
function stateWords(core, known) {
  const words = known.slice();
  const floats = new Float64Array(words.buffer);
  const first = core.offset("WgThesisState", "collision") / 8;
  for (let k = first; k < words.length; k++) floats[k] = Number(BigInt.asIntN(64, words[k]));
  return words;
}

/**
 * Returns a function that lays out the first random numbers of a run: those given, then a count.
 * @param {LiveRecipe} recipe
 */
function drawsOf(recipe) {
  /** @type {number[]} */
  const known = [];
  let state = BigInt(recipe.setup.rule === 3 ? recipe.seed : 0);
  return (/** @type {Core} */ core, /** @type {number} */ count) => {
    if (recipe.setup.rule !== 3) return [0, 0];
    // SplitMix64, as in worldgen/random_streams.py.
    while (known.length < count) {
      state = (state + GAMMA) & MASK;
      let z = ((state ^ (state >> 30n)) * 0xbf58476d1ce4e5b9n) & MASK;
      z = ((z ^ (z >> 27n)) * 0x94d049bb133111ebn) & MASK;
      known.push(Number((z ^ (z >> 31n)) >> 11n) * 2 ** -53);
    }
    const draws = [...recipe.draws, ...known];
    return [core.array(draws, "double"), draws.length];
  };
}

/**
 * Returns what is left of a division, as Python's % does: 0 or more.
 * @param {number} value
 * @param {number} divisor above 0
 */
function modulo(value, divisor) {
  const rest = value % divisor;
  return rest < 0 ? rest + divisor : rest;
}
