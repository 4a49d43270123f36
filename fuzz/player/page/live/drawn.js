// A run as the player draws it: fuzz/player/runs.py and fuzz/player/page/decode.js in one.

import { TURN, UNIT } from "#player/live/lattice.js";

/** Steps of a run that are drawn, about; a longer one is thinned. */
const MOST_STEPS = 4000;
/** Steps around an event that a reader looks at most closely. */
const LEAD_UP = 300;
/** Parts of a step in which corners have their times. */
const STEP_TIME = 2 ** 32;

/** @type {Record<string, [string, string]>} */
const BREACHES = {
  tunnel: ["Breach", "goes through this wall"],
  overlap: ["Overlap", "cuts into this wall"],
  contact: ["Contact", "touches this wall"],
  burned: ["Caught", "is caught"],
};

/** @typedef {import("#player/live/verdict.js").Judged} Judged */

/**
 * Returns which steps to draw: densely where a reader looks, evenly elsewhere.
 * @param {Judged} run
 * @returns {(step: number) => boolean}
 */
export function keptSteps({ steps, entry, period, hit }) {
  const centre = hit?.step ?? steps;
  const [from, to] = entry >= 0 ? [entry, entry + period] : [Math.max(0, centre - LEAD_UP), Math.min(steps, centre + LEAD_UP)];
  const near = strideOf(to - from, MOST_STEPS / 2);
  const far = strideOf(steps - (to - from), MOST_STEPS - (to - from) / near);
  return (step) =>
    step % far === 0 ||
    (step >= from && step <= to && (step - from) % near === 0) ||
    [from, to, steps, hit?.step].includes(step);
}

/**
 * @param {number} count
 * @param {number} most
 */
const strideOf = (count, most) => Math.max(1, Math.ceil(count / most));

/** The places of a run, in the player's units. */
export class Trail {
  /** @type {{ at: number[], x: number[], y: number[], heading: number[], bump: number[] }} */
  columns = { at: [], x: [], y: [], heading: [], bump: [] };
  /** The first step that ends with a contact; -1 for none. */
  firstTouch = -1;

  /**
   * @param {number} at steps
   * @param {number} x cells
   * @param {number} y cells
   * @param {number} heading rad, in any turn
   * @param {number} bump
   */
  add(at, x, y, heading, bump) {
    const { columns } = this;
    const before = columns.heading.at(-1) ?? heading;
    const turn = 2 * Math.PI;
    columns.at.push(at);
    columns.x.push(x);
    columns.y.push(y);
    // Without jumps, so that it can be drawn between two rows.
    columns.heading.push(heading - Math.round((heading - before) / turn) * turn);
    columns.bump.push(bump);
  }

  /**
   * Notes that a step ends with a contact.
   * @param {number} step
   */
  touch(step) {
    if (this.firstTouch < 0) this.firstTouch = step;
  }

  /**
   * Takes recorded steps, and the corners inside them.
   * @param {BigInt64Array} states rows of contact, x, y, heading, ...
   * @param {number} width numbers in a row
   * @param {number} first step of the first row
   * @param {BigInt64Array} corners rows of step, time, x, y
   * @param {(step: number) => boolean} isKept
   */
  take(states, width, first, corners, isKept) {
    let corner = 0;
    for (let k = 0; k * width < states.length; k++) {
      const [bump, x, y, heading] = Array.from(states.subarray(k * width, k * width + 4), Number);
      const step = first + k;
      const isDrawn = isKept(step);
      const angle = (heading / TURN) * 2 * Math.PI;
      if (bump) this.touch(step);
      for (; corner < corners.length && Number(corners[corner]) === step; corner += 4) {
        const time = Number(corners[corner + 1]);
        // One at the end of a step is its state.
        if (!isDrawn || time >= STEP_TIME) continue;
        const at = step - 1 + time / STEP_TIME;
        this.add(at, Number(corners[corner + 2]) / UNIT, Number(corners[corner + 3]) / UNIT, angle, bump);
      }
      if (isDrawn) this.add(step, x / UNIT, y / UNIT, angle, bump);
    }
  }

  /**
   * Returns a run for the player.
   * @param {Judged} run
   * @param {LiveRecipe} recipe
   * @returns {DrawnRun}
   */
  drawn(run, recipe) {
    const { at, x, y, heading, bump } = this.columns;
    const breached = run.verdict === "tunnel" || run.verdict === "overlap";
    const marks = [...(this.firstTouch < 0 ? [] : [touchMark(this.firstTouch)]), ...marksOf(run)];
    return {
      steps: run.steps,
      dt: recipe.time_step,
      per: { step: 1, cell: UNIT, turn: TURN },
      at: "",
      x: "",
      y: "",
      heading: "",
      bump: "",
      memory: null,
      tolerance: breached ? recipe.tolerance : null,
      thinned: Math.max(1, Math.ceil(run.steps / MOST_STEPS)),
      loop: run.verdict === "loop" ? [run.entry, run.period] : null,
      marks: marks.sort((a, b) => a.step - b.step),
      open: {
        at: Float64Array.from(at),
        x: Float64Array.from(x),
        y: Float64Array.from(y),
        heading: Float64Array.from(heading),
        bump: Uint8Array.from(bump),
        active: null,
      },
    };
  }
}

/**
 * @param {number} step
 * @returns {Mark}
 */
const touchMark = (step) => ({
  step,
  kind: "touch",
  name: "First bump",
  text: "touches something for the first time",
});

/**
 * Returns the steps in the evidence, each with a name, a description and perhaps a cell.
 * @param {Judged} run
 * @returns {Mark[]}
 */
function marksOf({ verdict, entry, hit, last_new_cell: last }) {
  if (verdict === "loop") return [{ step: entry, kind: "entry", name: "Entry", text: "the loop is entered" }];
  if (hit && BREACHES[verdict]) {
    const [name, text] = BREACHES[verdict];
    return [{ step: hit.step, kind: ["contact", "burned"].includes(verdict) ? "caught" : "breach", name, text, cell: hit.cell }];
  }
  if (verdict === "stalled" || verdict === "timeout") {
    return [{ step: last, kind: "stays", name: "Nothing new after", text: "enters a new cell for the last time" }];
  }
  return [];
}
