// What is known of an edited world: whether its target can be reached, and how a run in it ends.

import { grouped } from "#player/dom.js";
import { drawnWitness } from "#player/live/live.js";

/** @type {Proof} */
export const DECIDING = { waiting: "deciding …", length: 0, duration: 0, clearance: 0 }; // of a proof that takes a while
/** @type {Proof} */
export const DECIDING_LONG = { ...DECIDING, waiting: "deciding …: a large world takes a few seconds; you can keep drawing" };

const ring = (cells) => `a ring of ${cells} wall cells, with gaps too narrow for this robot, separates the start from the target`;

/**
 * Describes the proof; `head` comes first, in bold, and `kind` tells good news from bad.
 * @param {Proof | null} proof
 * @returns {{head: string, words: string, kind: string}}
 */
export function proofWords(proof) {
  if (!proof) return { head: "", words: "…", kind: "waiting" };
  if (proof.waiting) return { head: "", words: proof.waiting, kind: "waiting" };
  if (proof.error) return { head: "", words: proof.error, kind: "bad" };
  if (proof.result === "reachable") {
    const { length, duration, clearance, others = [] } = proof;
    const who = others.length > 0 ? ` all ${others.length + 1} robots together,` : "";
    return {
      head: "✓ reachable:",
      words: `${who} ${length.toFixed(2)} m, ${duration.toFixed(2)} s; clearance of the path shown ${clearance.toPrecision(4)} m`,
      kind: "good",
    };
  }
  const mark = proof.result === "blocked" ? "✗ blocked" : "? undecided";
  const reason = proof.ring ? ring(proof.ring) : proof.reason;
  return { head: `${mark}:`, words: ` ${reason}`, kind: proof.result === "blocked" ? "bad" : "waiting" };
}

/**
 * Returns the proof of an edited world as the board draws it.
 * @param {LiveProof} proof - The core's
 * @param {string} missing - Why the core does not decide it; empty if it does
 * @param {EditedWorld} world
 * @returns {Proof}
 */
export function proofOf(proof, missing, world) {
  const { reachable, reason, witness, cut } = proof;
  const lengthOf = ({ x, y }) => x.reduce((sum, at, k) => (k > 0 ? sum + Math.hypot(at - x[k - 1], y[k] - y[k - 1]) : 0), 0);
  return {
    result: reachable === null ? "undecided" : reachable ? "reachable" : "blocked",
    reason: missing || reason,
    length: witness ? lengthOf(witness) : 0,
    duration: witness?.t.at(-1) ?? 0,
    clearance: (witness ?? cut)?.clearance ?? 0,
    cut: cut && !cut.boxes ? cut.cells : null,
    cut_poses: cut?.boxes ? stoppedPlaces(world, cut.boxes) : null,
    ring: cut && !cut.waypoint && cut.cells.length > 1 ? cut.cells.length : null,
    opened: drawnWitness(proof, world.cell_size),
    openedOthers: [],
  };
}

const FINENESS = 4; // places per cell and axis at which a cut of poses is sampled
const MOST_PLACES = 2_000_000; // of a world; larger ones have fewer per cell
const ALL = 0.995; // share of the headings that are all: boxes end a step before the next
const TURN = 65536; // headings
const UNIT = 1024; // parts of a cell in which boxes are given

/**
 * Returns where a cut of poses stops a body in all headings, and where in some, as bits:
 * worldgen/render/certificate_parts.py.
 * @param {EditedWorld} world
 * @param {number[][]} boxes - Rows of heading, following headings, side, y, and x from and to
 * @returns {CutPoses}
 */
function stoppedPlaces(world, boxes) {
  let fineness = FINENESS;
  while (fineness > 1 && world.cells.length * fineness ** 2 > MOST_PLACES) fineness -= 1;
  const width = world.width * fineness,
    height = world.height * fineness,
    part = UNIT / fineness;
  // The places whose middles are between two bounds.
  const bounds = (low, high, most) => [Math.ceil(low / part - 0.5), Math.floor(high / part - 0.5) + 1].map((at) => Math.min(Math.max(at, 0), most));
  // Corners of each rectangle in a table whose sums along both axes are the headings in all.
  const table = new Float64Array((width + 1) * (height + 1));
  for (const [, span, side, y, begin, end] of boxes) {
    const [left, right] = bounds(begin, end, width),
      [low, high] = bounds(y, y + side, height);
    if (left >= right || low >= high) continue;
    for (const [row, column, sign] of [[low, left, 1], [low, right, -1], [high, left, -1], [high, right, 1]]) table[row * (width + 1) + column] += sign * span;
  }
  const all = new Uint8Array(Math.ceil((width * height) / 8)),
    some = all.slice();
  for (let row = 0; row < height; row += 1)
    for (let column = 0; column < width; column += 1) {
      const at = row * (width + 1) + column;
      if (column > 0) table[at] += table[at - 1];
      if (row > 0) table[at] += table[at - width - 1] - (column > 0 ? table[at - width - 2] : 0);
      // where a wall is, nothing need be shown
      if (world.cells[Math.floor(row / fineness) * world.width + Math.floor(column / fineness)]) continue;
      const place = row * width + column;
      if (table[at] >= ALL * TURN) all[place >> 3] |= 1 << (place & 7);
      else if (table[at] > 0) some[place >> 3] |= 1 << (place & 7);
    }
  return { all, some, fineness };
}

const ONCE = { tunnel: "goes into a wall", overlap: "cuts into a wall", contact: "touches a wall", burned: "is caught" };

/**
 * Describes how a run ended, after its verdict.
 * @param {LiveRun} run
 * @returns {string}
 */
export function runWords({ verdict, steps, time, entry, period, hit, last_new_cell: last, error }) {
  if (verdict === "reached") return `after ${grouped(steps)} steps, ${time.toFixed(2)} s`;
  if (verdict === "loop") return `forever: the state after step ${grouped(entry)} recurs ${period === 1 ? "in every step" : `every ${grouped(period)} steps`}`;
  if (hit && verdict in ONCE) return `in step ${grouped(hit.step)}: ${ONCE[verdict]}, cell (${hit.cell.join(", ")})`;
  if (verdict === "stalled") return `no new cell after step ${grouped(last)} of ${grouped(steps)}`;
  if (verdict === "timeout") return `still reaching new cells when its ${grouped(steps)} steps were used up`;
  return error;
}
