// Answers a page's question about a world: does a path exist, and what does the robot do?

import { add, ceil, div, exact, fraction, least, mul, sub } from "#player/live/exact.js";
import { proveGoals } from "#player/live/goals.js";
import { undecided } from "#player/live/prove.js";
import { runOnLattice } from "#player/live/run.js";
import { runStepped } from "#player/live/stepped.js";

/** @typedef {import("#player/live/core.js").Core} Core */
/** @typedef {{ prover: Core, simulator: Core }} Cores */

/** Steps of a run without a witness. */
const STEPS_WITHOUT_WITNESS = 20_000;
/** A budget grows at most this many times for a drift. */
const MOST_OF_A_DRIFT = fraction(10);

/**
 * @param {Cores} cores
 * @param {LiveQuestion} question
 * @param {() => Promise<void>} pause throws if a newer question has come
 * @returns {Promise<LiveAnswer>}
 */
export async function judge({ prover, simulator }, { world, run: recipe, edited }, pause) {
  try {
    const began = performance.now();
    const elsewhere = whyNotProved(world);
    const proof = elsewhere ? undecided(elsewhere) : await proveInTime(prover, world, pause);
    await pause();
    const proved = performance.now();
    /** @type {LiveRun | null} */
    let run = null;
    let why = "";
    if (recipe) {
      const budget = edited ? budgetOf(world, recipe, proof) : recipe.steps;
      const runs = recipe.motion === "stepped" ? runStepped : runOnLattice;
      const found = await runs(simulator, world, recipe, proof.witness, budget, pause);
      if (typeof found === "string") why = found;
      else run = found;
    }
    const ms = { proof: proved - began, run: performance.now() - proved };
    return { proof, run, live: { proof: proof.reachable === null ? proof.reason : "", run: why }, ms };
  } finally {
    prover.release();
    simulator.release();
  }
}

/**
 * Returns why the proof of a world isn't made in a page, in a sentence; empty if it is.
 * @param {LiveWorld} world
 */
const whyNotProved = (world) => ((world.robots ?? 1) > 1 ? "The proof for several robots is made by worldgen verify." : "");

/**
 * Decides a world whose cells may change: a path around all that is ever blocked holds at any time,
 * and what always stops the robot stops it. What lies in between depends on the times.
 * @param {Core} prover
 * @param {LiveWorld} world
 * @param {() => Promise<void>} pause
 * @returns {Promise<LiveProof>}
 */
async function proveInTime(prover, world, pause) {
  if (!world.changes) return proveGoals(prover, world, pause);
  const { closes, opens } = world.changes;
  const around = await proveGoals(prover, withCells(world, closes, "#"), pause);
  if (around.reachable) return { ...around, reason: `${around.reason}, around all cells that ever close or burn` };
  await pause();
  const always = await proveGoals(prover, withCells(world, opens, "."), pause);
  if (always.reachable === false) return { ...always, reason: `whatever changes: ${always.reason}` };
  return undecided("Whether it can arrive may depend on the times of the changes; worldgen verify searches further.");
}

/**
 * Returns a world in which some cells are solid, or free, all the time.
 * @param {LiveWorld} world
 * @param {CellPlace[]} places
 * @param {string} sign
 * @returns {LiveWorld}
 */
function withCells(world, places, sign) {
  const rows = world.cells.map((row) => [...row]);
  for (const [ix, iy] of places) rows[rows.length - 1 - iy][ix] = sign;
  return { ...world, cells: rows.map((row) => row.join("")), changes: undefined };
}

/**
 * Returns the steps that an edited world's run gets: sim.options.run.step_budget.
 * @param {LiveWorld} world
 * @param {LiveRecipe} recipe
 * @param {LiveProof} proof
 */
function budgetOf(world, recipe, { reachable, witness }) {
  const { factor, fewest, most, moved, drift, pushed, last_push: last } = recipe.budget;
  // Without a proof of its own, the run has as long as the recorded one.
  if (reachable === null) return recipe.steps;
  if (!witness) return STEPS_WITHOUT_WITNESS;
  let duration = exact(witness.t.at(-1) ?? 0);
  if (moved) {
    const speed = exact(world.speed);
    const left = sub(speed, exact(drift));
    const slower = left.over > 0n ? div(speed, left) : fraction(1);
    duration = add(mul(least(slower, MOST_OF_A_DRIFT), duration), exact(last + pushed / world.speed));
  }
  const wanted = ceil(div(mul(fraction(factor), duration), exact(recipe.time_step)));
  return Math.min(Math.max(Number(wanted), fewest), most);
}
