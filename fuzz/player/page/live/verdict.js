// What a run of the core ended with: sim/outcome.py, in a page.

/** @typedef {import("#player/live/core.js").Core} Core */

/** Steps of which one call records the path, so that a large memory takes little room. */
export const RECORDED_AT_ONCE = 256;

/** Endings with the verdict's name; a run that spent its budget has none yet. */
const ENDINGS = /** @type {const} */ ({
  WG_REACHED: "reached",
  WG_LOOP: "loop",
  WG_TUNNEL: "tunnel",
  WG_BURNED: "burned",
  WG_INVALID_COMMAND: "invalid-command",
  WG_CRASH: "crash",
  WG_CONTACT: "contact",
});
/** Verdicts on an event that ends a run in its step. */
const AT_ONCE = ["tunnel", "contact", "burned", "crash", "invalid-command"];

/**
 * Returns the verdict on a run.
 * @param {string} ending empty for a spent budget
 * @param {{ steps: number, last_new_cell: number, overlap_step: number }} report
 */
export function verdictOf(ending, report) {
  if (AT_ONCE.includes(ending)) return ending;
  if (report.overlap_step >= 0) return "overlap";
  if (ending) return ending;
  return report.last_new_cell <= Math.floor(report.steps / 2) ? "stalled" : "timeout";
}

/**
 * Returns the ending's name.
 * @param {Core} core
 * @param {number} ending
 */
export function endingOf(core, ending) {
  for (const [constant, name] of Object.entries(ENDINGS)) if (core.constants[constant] === ending) return name;
  return "";
}

/**
 * What a run ended with.
 * @typedef {object} Judged
 * @property {string} verdict
 * @property {number} steps
 * @property {number} entry of a loop; otherwise -1
 * @property {number} period of a loop; otherwise 0
 * @property {number} last_new_cell
 * @property {LiveRun["hit"]} hit
 */

/**
 * Returns the evidence of a run as a failure's record holds it (sim/evidence.py).
 * @param {Judged} run
 * @param {object} facts
 * @param {() => string} facts.stateDigest of the state to which a loop returns
 * @param {{ cause?: string, since?: number }} [facts.entered] the move that led into a wall, if it is known
 * @param {string} [facts.burned] state of the cell that ended a run
 * @param {number | null} facts.multiple the run's time divided by the witness's
 * @param {Record<string, any>} [facts.confined] how a stalled run stays where it is
 * @param {string} [facts.error] of the controller
 * @returns {Record<string, any>}
 */
export function evidenceOf({ verdict, steps, entry, period, last_new_cell, hit }, { stateDigest, entered = {}, burned, multiple, confined, error }) {
  if (verdict === "loop") return { entry, period, state_digest: stateDigest() };
  if (verdict === "timeout" || verdict === "stalled") {
    return { last_new_cell, ...(multiple === null ? {} : { witness_multiple: multiple }), ...(verdict === "stalled" ? confined : {}) };
  }
  if (verdict === "burned") return { ...hit, state: burned };
  if (verdict === "contact") return { ...hit };
  if (verdict === "tunnel" || verdict === "overlap") return { ...hit, ...entered };
  return { step: steps, ...(error ? { error } : {}) };
}

/**
 * Returns a run's time as a multiple of a witness's, to three digits; null without one.
 * @param {LiveRecipe} recipe
 * @param {number} steps
 * @param {LiveProof["witness"]} witness
 */
export function multipleOf(recipe, steps, witness) {
  const duration = witness?.t.at(-1) ?? 0;
  if (!duration) return null;
  const multiple = (steps * recipe.time_step) / duration;
  // Halves go to the even digit, as in Python; only such numbers are exactly half of one.
  const isHalf = Number.isInteger(multiple * 16) && (multiple * 1000) % 1 === 0.5;
  return isHalf ? (2 * Math.round(multiple * 500)) / 1000 : Number(multiple.toFixed(3));
}

/**
 * Returns the rolling FNV-1a hash of 64-bit words, 16 hex digits.
 * @param {BigUint64Array} words
 */
export function fnv1a(words) {
  let value = 1469598103934665603n;
  for (const word of words) value = BigInt.asUintN(64, (value ^ word) * 1099511628211n);
  return value.toString(16).padStart(16, "0");
}
