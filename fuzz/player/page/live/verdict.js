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
