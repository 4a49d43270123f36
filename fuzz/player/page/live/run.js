// Runs a controller of the core, as sim/runners/lattice.py and sim/runners/decide.py do.

import { Trail, keptSteps } from "#player/live/drawn.js";
import {
  TURN,
  UNIT,
  discNumbers,
  headingFromLattice,
  headingToLattice,
  inCells,
  solidOf,
  targetSq,
  toLattice,
  toMetres,
} from "#player/live/lattice.js";
import { RECORDED_AT_ONCE, endingOf, evidenceOf, fnv1a, multipleOf, verdictOf } from "#player/live/verdict.js";

/** @typedef {import("#player/live/core.js").Core} Core */

/** Steps between two looks at whether a newer question has come. */
const PORTION = 1_000_000n;
/** The largest grid that tables of beams describe in 16 bits, cells. */
const MOST_CELLS_OF_RUNS = 65535;
/** Lattice points next to a start, the nearest first. */
const NEXT = [0, 1, 2].flatMap((away) =>
  [-1, 0, 1].flatMap((dx) => [-1, 0, 1].map((dy) => [dx, dy]).filter(([, dy]) => dx * dx + dy * dy === away)),
);

/**
 * Lays out a world, and runs a recipe in it until the verdict is certain.
 * @param {Core} core the simulator
 * @param {LiveWorld} world
 * @param {LiveRecipe} recipe of a motion model on the lattice
 * @param {LiveProof["witness"]} witness
 * @param {number} budget steps
 * @param {() => Promise<void>} pause throws if a newer question has come
 * @returns {Promise<LiveRun | string>} the run, or why it cannot start
 */
export async function runOnLattice(core, world, recipe, witness, budget, pause) {
  const arena = layOut(core, world, recipe);
  const { settings, start } = arena;
  if (!start) return "The robot overlaps a wall at its start.";
  const fresh = arena.copy();
  const own = arena.copy();
  const controller = controllerOf(core, recipe);
  const episode = newEpisode(core, own, settings, controller, recipe.finds_loops ? budget : 0);
  const seek = core.constants[recipe.finds_loops ? "WG_SEEK_LOOP" : "WG_NO_LOOP"];
  const run = core.make("WgRun", { episode, settings, fresh, budget, find_loop: seek });
  core.check("wg_run_begin", run);
  do {
    while (core.call("wg_episode_run", episode, PORTION) === core.constants.WG_GOES_ON) {
      await pause();
    }
  } while (core.call("wg_run_goes_on", run));

  const at = episode + core.offset("WgEpisode", "robot.report.ending");
  const report = core.all(at, "WgReport");
  const digest = core.whole(at, "WgReport", "digest");
  const verdict = verdictOf(endingOf(core, report.ending), /** @type {any} */ (report));
  const known = core.get(episode, "WgEpisode", "search.known");
  const words = core.get(episode, "WgEpisode", "search.words");
  const state = known ? core.view(known, words, "uint64_t").slice() : new BigUint64Array();
  core.call("wg_episode_free", episode);

  const isLoop = verdict === "loop";
  const isCrash = verdict === "crash";
  const error = isCrash && report.error ? core.text(report.error) : "";
  const judged = {
    verdict,
    steps: report.steps,
    entry: isLoop ? core.get(settings, "WgSettings", "loop_entry") : -1,
    period: isLoop ? report.period : 0,
    last_new_cell: report.last_new_cell,
    hit: hitOf(verdict, report),
  };
  const evidence = evidenceOf(judged, {
    stateDigest: () => fnv1a(state),
    burned: report.hit_state === core.constants.WG_SOLID ? "solid" : "burning",
    multiple: multipleOf(recipe, report.steps, witness),
    error,
  });
  // Again, for the path. The step in which a controller fails isn't part of it.
  core.set(settings, "WgSettings", { digest: 0 });
  const steps = report.steps - Number(isCrash);
  const trail = await record(core, arena.copy(), settings, controller, steps, keptSteps(judged), pause);
  const side = world.cell_size;
  return {
    ...judged,
    evidence,
    time: Number((report.steps * recipe.time_step).toFixed(9)),
    budget,
    digest: digest.toString(16).padStart(16, "0"),
    path_length: report.path_length * core.get(settings, "WgSettings", "metres"),
    collisions: report.collisions,
    error,
    start: [toMetres(start[0], side), toMetres(start[1], side), headingFromLattice(Number(start[2]))],
    drawn: trail.drawn(judged, recipe),
  };
}

/**
 * @param {string} verdict
 * @param {Record<string, number>} report
 * @returns {LiveRun["hit"]}
 */
function hitOf(verdict, report) {
  if (verdict === "overlap") return { step: report.overlap_step, cell: [report.overlap_ix, report.overlap_iy] };
  if (report.hit_step < 0) return null;
  return { step: report.hit_step, cell: [report.hit_ix, report.hit_iy] };
}

/**
 * Fills the settings of a run, and the tables of its surroundings before the first event.
 * @param {Core} core
 * @param {LiveWorld} world
 * @param {LiveRecipe} recipe
 */
function layOut(core, world, recipe) {
  const { solid, width, height } = solidOf(world);
  const cells = core.array(solid, "uint8_t");
  const grid = gridOf(core, cells, width, height);
  const headings = core.table("headings", 2 * TURN * 8, (at) => core.call("wg_heading_table", at));
  const settings = settingsOf(core, world, recipe);
  const pose = clearStart(core, grid, headings, settings, world);
  if (pose) core.set(settings, "WgSettings", { start_x: pose[0], start_y: pose[1], start_heading: pose[2] });

  const near = core.zeros(4 * width * height);
  core.call("wg_near_masks", grid, near);
  const clearance = clearanceTable(core, solid, width, height, settings, recipe);
  const events = core.array(recipe.events.flat().map(BigInt), "int64_t");
  const beams = recipe.events.length ? {} : beamTables(core, grid, headings, settings, width, height);
  /** Returns a WgArena with its own copies of all that changes. */
  const copy = () =>
    core.make("WgArena", {
      width,
      height,
      cells: core.array(core.view(cells, width * height, "uint8_t"), "uint8_t"),
      near: core.array(core.view(near, width * height, "int32_t"), "int32_t"),
      clearance,
      events,
      event_count: recipe.events.length,
      headings,
      visited: core.zeros(width * height),
      ...beams,
    });
  return { settings, start: pose, copy };
}

/**
 * @param {Core} core
 * @param {number} cells
 * @param {number} width
 * @param {number} height
 */
const gridOf = (core, cells, width, height) => core.make("WgGrid", { cells, width, height });

/**
 * Returns a WgSettings: the recipe's, with what an edit can change computed again.
 * @param {Core} core
 * @param {LiveWorld} world
 * @param {LiveRecipe} recipe
 */
function settingsOf(core, world, recipe) {
  const side = world.cell_size;
  const pushes = core.array(recipe.pushes.flat().map(BigInt), "int64_t");
  const decoys = core.zeros(Math.max(1, recipe.decoys.length) * core.size("WgDecoy"));
  for (const [k, [x, y, strength]] of recipe.decoys.entries()) {
    core.set(decoys + k * core.size("WgDecoy"), "WgDecoy", { x, y, strength });
  }
  const own = core.make("WgSettings", { ...recipe.settings, pushes, decoys });
  core.set(own, "WgSettings", {
    "target.x": toLattice(world.target[0], side),
    "target.y": toLattice(world.target[1], side),
    "target.radius_sq": targetSq(world),
    top_speed: world.speed,
    start_speed: Math.min(Number(recipe.start_speed), world.speed),
  });
  // A body's discs follow from its footprint, which no edit changes.
  if (!core.get(own, "WgSettings", "footprint.count")) {
    core.set(own, "WgSettings", { radius: world.radius, ...discNumbers(inCells(world.radius, side)) });
  }
  return own;
}

/**
 * Returns the lattice point nearest to the start at which the robot is clear, with its heading.
 * @param {Core} core
 * @param {number} grid
 * @param {number} headings
 * @param {number} settings
 * @param {LiveWorld} world
 */
function clearStart(core, grid, headings, settings, world) {
  const x = toLattice(world.start[0], world.cell_size);
  const y = toLattice(world.start[1], world.cell_size);
  const heading = BigInt(headingToLattice(world.start[2]));
  const solid = core.constants.WG_SOLID;
  for (const [dx, dy] of NEXT) {
    const at = [x + BigInt(dx), y + BigInt(dy), heading];
    if (core.call("wg_robot_is_clear", grid, solid, headings, settings, ...at)) return at;
  }
  return null;
}

/**
 * Returns distances to cells that are ever not free; NULL if the masks reach as far as any step.
 * @param {Core} core
 * @param {Uint8Array} solid
 * @param {number} width
 * @param {number} height
 * @param {number} settings
 * @param {LiveRecipe} recipe
 */
function clearanceTable(core, solid, width, height, settings, recipe) {
  const { top_speed: speed, speed: units, drift_reach: drift, reach } = core.all(settings, "WgSettings");
  const fastest = Math.floor(speed * units) + 1 + drift;
  if (reach + fastest <= core.constants.WG_NEAR * UNIT) return 0;
  const ever = solid.slice();
  for (const [, , ix, iy, state] of recipe.events) ever[iy * width + ix] = Math.max(ever[iy * width + ix], state);
  const table = core.zeros(4 * width * height);
  core.call("wg_chessboard_clearance", gridOf(core, core.array(ever, "uint8_t"), width, height), table);
  return table;
}

/**
 * Returns the tables of range beams in cells that never change; nothing without beams.
 * @param {Core} core
 * @param {number} grid
 * @param {number} headings
 * @param {number} settings
 * @param {number} width
 * @param {number} height
 * @returns {import("#player/live/core.js").Fields}
 */
function beamTables(core, grid, headings, settings, width, height) {
  const { senses, beams, beam_field: field } = core.all(settings, "WgSettings");
  if (!(senses & core.constants.WG_SENSE_BEAMS) || Math.max(width, height) > MOST_CELLS_OF_RUNS) return {};
  const size = (TURN / 8 + 1) * core.size("WgRay");
  const rays = core.table("rays", size, (at) => core.call("wg_ray_table", headings, at));
  const runs = core.zeros((height + 2) * (width + 2) * 4 * 2);
  core.check("wg_free_runs", grid, runs);
  const spread = core.zeros(8 * beams);
  core.call("wg_beam_spread", BigInt(beams), field, spread);
  return { rays, runs, spread };
}

/**
 * Returns a WgController.
 * @param {Core} core
 * @param {LiveRecipe} recipe
 */
function controllerOf(core, recipe) {
  const name = core.array(new TextEncoder().encode(`${recipe.controller}\0`), "uint8_t");
  const numbers = new Float64Array(recipe.memory.size);
  for (const [at, value] of recipe.memory.numbers) numbers[Number(at)] = Number(value);
  const act = core.call("wg_library_act", name);
  if (!act) throw new Error(`the core has no controller ${recipe.controller}`);
  return core.make("WgController", {
    act,
    memory: core.array(numbers, "double"),
    memory_size: numbers.length,
  });
}

/**
 * @param {Core} core
 * @param {number} arena
 * @param {number} settings
 * @param {number} controller
 * @param {number} logged steps in which a loop is searched for; 0 for none
 */
function newEpisode(core, arena, settings, controller, logged) {
  const made = core.zeros(4);
  core.check("wg_episode_new", arena, settings, controller, BigInt(logged), made);
  return core.view(made, 1, "uint32_t")[0];
}

/**
 * Runs again, and keeps the path.
 * @param {Core} core
 * @param {number} arena
 * @param {number} settings
 * @param {number} controller
 * @param {number} steps
 * @param {(step: number) => boolean} isKept which steps to draw
 * @param {() => Promise<void>} pause
 * @returns {Promise<Trail>}
 */
async function record(core, arena, settings, controller, steps, isKept, pause) {
  const episode = newEpisode(core, arena, settings, controller, 0);
  core.check(
    "wg_run_begin",
    core.make("WgRun", { episode, settings, fresh: arena, budget: steps, find_loop: core.constants.WG_NO_LOOP }),
  );
  const { event_count: events } = core.all(arena, "WgArena");
  const { place_count: places, push_count: pushes, start_x, start_y, start_heading } = core.all(settings, "WgSettings");
  const legs = core.call("wg_most_legs", settings) + Number(places > 0);
  const room = core.constants.WG_MOST_CORNERS * (RECORDED_AT_ONCE * legs + events + pushes);
  const columns = 1 + core.get(episode, "WgEpisode", "search.words");
  const rows = core.zeros(8 * columns * RECORDED_AT_ONCE);
  const points = core.zeros(room * core.size("WgPathPoint"));
  const headings = core.call("wg_carriage_words", settings) ? core.zeros(8 * room) : 0;
  const trail = new Trail();
  trail.add(0, start_x / UNIT, start_y / UNIT, (start_heading / TURN) * 2 * Math.PI, 0);

  for (let first = 1, before = 0; first <= steps; first += RECORDED_AT_ONCE) {
    const count = Math.min(RECORDED_AT_ONCE, steps + 1 - first);
    core.check("wg_episode_record", episode, rows, BigInt(count), points, headings, BigInt(room));
    // A call may return early.
    while (core.get(episode, "WgEpisode", "step") < first + count - 1) {
      const left = first + count - 1 - core.get(episode, "WgEpisode", "step");
      if (core.call("wg_episode_run", episode, BigInt(left)) !== core.constants.WG_GOES_ON) break;
    }
    const after = core.get(episode, "WgEpisode", "robot.report.points");
    const states = core.view(rows, columns * count, "int64_t");
    const corners = core.view(points, 4 * (after - before), "int64_t");
    trail.take(states, columns, first, corners, isKept);
    before = after;
    await pause();
  }
  core.call("wg_episode_free", episode);
  return trail;
}
