// Whether the target can be reached, asked of the server while one draws: the newest world counts.

import { numbersOf } from "/player/decode.js";
import { Ended, Refused } from "./connection.js";
import { messageOf } from "./model.js";

const SOON = 60; // ms after the last change
const LATER = 500; // ms of quiet before the widest robot is asked for
const LARGEST_WIDEST = 40_000; // cells: in larger worlds the widest robot is asked for by hand

/** The proof in words, and whether it is good news. */
export function proofWords(proof) {
  if (!proof) return { words: "…", kind: "waiting" };
  if (proof.error) return { words: proof.error, kind: "bad" };
  if (proof.result === "reachable") {
    const clearance = (proof.clearance * 100).toPrecision(3);
    return {
      words: `✓ reachable: ${proof.length.toFixed(2)} m, ${proof.duration.toFixed(2)} s, radius up to ${clearance} cm`,
      kind: "good",
    };
  }
  const mark = proof.result === "blocked" ? "✗ blocked" : "? undecided";
  return { words: `${mark}: ${proof.reason}`, kind: proof.result === "blocked" ? "bad" : "waiting" };
}

/** What the thesis's robot reads in each cell, or the reason why it reads nothing. */
export async function askSignal(studio, noise) {
  const world = { ...messageOf(studio.model.world), source: null };
  try {
    const values = numbersOf((await studio.connection.ask("signal", { world, noise })).signal);
    return { values, most: values.reduce((most, value) => Math.max(most, value), 1) };
  } catch (error) {
    if (error instanceof Refused) studio.say(error.message);
    else if (!(error instanceof Ended)) throw error;
    return null;
  }
}

/* Asks for the proof after each change.
     studio    its model and connection
     proved    called with the proof, or null while it is not known
     widest    called with the largest radius that passes, m; null while it is not known */
export function makeProver(studio, proved, widest) {
  const state = { soon: 0, later: 0 };
  return () => {
    clearTimeout(state.soon);
    clearTimeout(state.later);
    widest(null);
    state.soon = setTimeout(() => decide(studio, proved), SOON);
    if (studio.model.world.cells.length <= LARGEST_WIDEST)
      state.later = setTimeout(() => measure(studio, widest), LATER);
  };
}

async function decide(studio, proved) {
  const version = studio.model.version,
    waiting = setTimeout(() => proved(null), 150); // a proof that is nearly there does not flicker
  try {
    const proof = await studio.connection.ask("decide", { world: { ...messageOf(studio.model.world), source: null } });
    if (version === studio.model.version) proved(proof);
  } catch (error) {
    if (error instanceof Refused) proved({ error: error.message });
    else if (!(error instanceof Ended)) throw error;
  } finally {
    clearTimeout(waiting);
  }
}

async function measure(studio, widest) {
  const version = studio.model.version;
  try {
    const answer = await studio.connection.ask("widest", { world: { ...messageOf(studio.model.world), source: null } });
    if (version === studio.model.version) widest(answer.widest);
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
  }
}
