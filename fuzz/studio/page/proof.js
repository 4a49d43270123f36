// Whether the target can be reached, asked of the server while one draws: the newest world counts.

import { numbersOf } from "#player/decode.js";
import { Ended } from "./connection.js";
import { messageOf } from "./model.js";
import { Refused } from "./refusals.js";

const SOON = 60; // ms after the last change
const LATER = 500; // ms of quiet before the widest robot is asked for
const LARGEST_WIDEST = 40_000; // cells: in larger worlds the widest robot is asked for by hand
const LARGE = 500_000; // cells of a world whose proof takes seconds
const DECIDING = {}; // stands for a proof that takes a while
const DECIDING_LONG = {}; // likewise, in a large world

/** Stands for the widest robot while it is looked for by hand. */
export const LOOKING = Symbol("looking");

/** Whether the widest robot is only looked for when it is asked for: it takes up to a minute. */
export const isWidestByHand = ({ cells, events }) => cells.length > LARGEST_WIDEST && !events;

const ring = (cells) => `a ring of ${cells} wall cells, every gap too narrow for this robot, parts the start from the target`;

/**
 * The proof in words, of which `head` comes first and is bold, and whether it is good news.
 * @param {Proof | null} proof
 * @returns {{head: string, words: string, kind: string}}
 */
export function proofWords(proof) {
  if (!proof) return { head: "", words: "…", kind: "waiting" };
  if (proof === DECIDING) return { head: "deciding …", words: "", kind: "waiting" };
  if (proof === DECIDING_LONG) return { head: "deciding …:", words: " a large world takes some seconds; draw on meanwhile", kind: "waiting" };
  if (proof.error) return { head: "", words: proof.error, kind: "bad" };
  if (proof.result === "reachable") {
    const { length, duration, clearance } = proof;
    return {
      head: "✓ reachable:",
      words: ` ${length.toFixed(2)} m, ${duration.toFixed(2)} s; clearance of the way that is shown ${clearance.toPrecision(4)} m`,
      kind: "good",
    };
  }
  const mark = proof.result === "blocked" ? "✗ blocked" : "? undecided";
  const reason = proof.ring ? ring(proof.ring) : proof.reason;
  return { head: `${mark}:`, words: ` ${reason}`, kind: proof.result === "blocked" ? "bad" : "waiting" };
}

/**
 * What the thesis's robot reads in each cell, or the reason why it reads nothing.
 * @param {Studio} studio
 * @param {boolean} noise
 * @returns {Promise<Board["signal"]>}
 */
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

/**
 * Asks for the proof after each change; its `widest` asks for the widest robot by hand.
 * @param {Studio} studio - Its model and connection
 * @param {(proof: Proof) => void} proved - Called with the proof of what is drawn now, or with what stands for it while it takes long
 * @param {(radius: number | symbol | null) => void} widest - Called with the largest radius that passes, m;
 *     null while it is not known, LOOKING while it is looked for
 * @returns {{(): void, widest: () => Promise<void>}}
 */
export function makeProver(studio, proved, widest) {
  const state = { soon: 0, later: 0, version: -1 };
  const prove = () => {
    clearTimeout(state.soon);
    clearTimeout(state.later);
    if (state.version !== studio.model.version) widest(null); // saving changes nothing that was found
    state.version = studio.model.version;
    state.soon = setTimeout(() => decide(studio, proved), SOON);
    if (!isWidestByHand(studio.model.world)) state.later = setTimeout(() => measure(studio, widest), LATER);
  };
  prove.widest = () => {
    widest(LOOKING);
    return measure(studio, widest);
  };
  return prove;
}

async function decide(studio, proved) {
  const version = studio.model.version,
    current = (proof) => version === studio.model.version && proved(proof),
    large = studio.model.world.cells.length > LARGE,
    waiting = setTimeout(() => current(large ? DECIDING_LONG : DECIDING), 150); // a proof that is nearly there does not flicker
  try {
    const proof = await studio.connection.ask("decide", { world: { ...messageOf(studio.model.world), source: null } });
    current(proof);
  } catch (error) {
    if (error instanceof Refused) current({ error: error.message });
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
    if (version === studio.model.version) widest(null);
  }
}
