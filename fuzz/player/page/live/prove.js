// Decides whether a disc gets from start to target, with the path or the cut that proves it:
// worldgen/reach/single/prove.py, in a page. The core does the work; here is what Python computes with
// fractions.

import { div, fraction, square } from "#player/live/exact.js";
import { UNITS } from "#player/live/lattice.js";
import { blocked, cut } from "#player/live/cut.js";
import { pathThroughPinches } from "#player/live/pinch.js";
import { askOf, isOffLattice, queryOf } from "#player/live/query.js";
import { nearestCell } from "#player/live/walls.js";
import { pathOf, reached, witnessOf } from "#player/live/witness.js";

/** @typedef {import("#player/live/core.js").Core} Core */

/** Larger worlds take too long while a reader waits. */
const MOST_CELLS = 1 << 18;

/**
 * @param {string} reason
 * @returns {LiveProof}
 */
export const undecided = (reason) => ({ reachable: null, reason, witness: null, cut: null });

/** Of a target that is out of reach, if no cut was asked for. */
const NOT_ASKED = { reachable: false, reason: "", witness: null, cut: null };

/**
 * Decides a static world for its disc.
 * @param {Core} core the prover
 * @param {LiveWorld} world
 * @param {() => Promise<void>} pause throws if a newer question has come
 * @param {{ wantsCut: boolean }} [wanted] whether the proof of a target out of reach is wanted
 * @returns {Promise<LiveProof>}
 */
export async function prove(core, world, pause, { wantsCut } = { wantsCut: true }) {
  const query = queryOf(core, world);
  if (query.width * query.height > MOST_CELLS) return undecided("A world this large is decided by `worldgen verify`.");
  const asked = askOf(core, world, query);
  if (!asked) return undecided("Numbers with this many digits are decided by `worldgen verify`.");
  core.set(asked, "WgStill", { wants_cut: Number(wantsCut) });
  core.check("wg_still_decide", query.walls, asked);
  const { outcome, goal_clear, goal_x, goal_y } = core.all(asked, "WgStill");
  const { WG_REACHED, WG_START_COVERED, WG_NO_PATH, WG_PARTED } = core.constants;
  if (outcome === WG_PARTED) return NOT_ASKED;
  if (outcome === WG_REACHED) {
    const { points, witness } = pathOf(core, world, asked);
    core.call("wg_still_free", asked);
    return reached(isOffLattice(query) ? witnessOf(world, query, [query.exactStart, ...points]) : witness);
  }
  if (outcome === WG_START_COVERED) {
    const { cell, squared } = nearestCell(query, query.exactStart);
    const reason = `the start is closer than the radius to cell (${cell.join(", ")})`;
    return blocked(world, [cell], div(squared, square(UNITS)), reason);
  }
  if (outcome !== WG_NO_PATH) return undecided("This start is so close to a wall that `worldgen verify` decides it.");

  // There is no path over half cells. Either a chain of cells stops the disc, or a path squeezes through.
  const goal = goal_clear ? { x: fraction(goal_x), y: fraction(goal_y) } : null;
  const found = await cut(core, world, { ...query, goal }, pause);
  if ("proof" in found) return found.proof;
  const path = await pathThroughPinches(core, { ...query, goal: found.goal }, pause);
  if (path) return reached(witnessOf(world, query, path));
  return undecided("there is a passage just wide enough, but no path along it was found");
}
