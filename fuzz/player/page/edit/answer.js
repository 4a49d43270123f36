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
 * @param {number} side - Of a cell, m
 * @returns {Proof}
 */
export function proofOf(proof, missing, side) {
  const { reachable, reason, witness, cut } = proof;
  const lengthOf = ({ x, y }) => x.reduce((sum, at, k) => (k > 0 ? sum + Math.hypot(at - x[k - 1], y[k] - y[k - 1]) : 0), 0);
  return {
    result: reachable === null ? "undecided" : reachable ? "reachable" : "blocked",
    reason: missing || reason,
    length: witness ? lengthOf(witness) : 0,
    duration: witness?.t.at(-1) ?? 0,
    clearance: (witness ?? cut)?.clearance ?? 0,
    cut: cut?.cells ?? null,
    ring: cut && cut.cells.length > 1 ? cut.cells.length : null,
    opened: drawnWitness(proof, side),
    openedOthers: [],
  };
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
