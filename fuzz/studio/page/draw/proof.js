// Asks the server, while the user draws, whether the target can be reached; only the newest world
// counts.

import { askAbout } from "#studio/shared/asking.js";
import { numbersOf } from "#player/decode.js";
import { Ended } from "#studio/shared/connection.js";
import { hasMoreInFile, robotsIn } from "#player/edit/model.js";
import { messageOf } from "#studio/shared/world_message.js";
import { Refused } from "#studio/shared/refusals.js";

const SOON = 60; // ms after the last change
// ms of quiet before asking for the widest robot, or whether several robots can arrive
const LATER = 500;
const LARGEST_WIDEST = 40_000; // cells: in larger worlds the user has to ask for the widest robot
const LARGE = 500_000; // cells of a world whose proof takes seconds
const DECIDING = {}; // placeholder for a proof that takes a while
const DECIDING_LONG = {}; // the same in a large world

/** Placeholder for the widest robot while the search that the user started is running. */
export const LOOKING = Symbol("looking");

/** Returns whether the widest robot is only searched for on request,
 * because that takes up to a minute. */
export const isWidestByHand = ({ cells, events }) => cells.length > LARGEST_WIDEST && !events;

const ring = (cells) => `a ring of ${cells} wall cells, with gaps too narrow for this robot, separates the start from the target`;

/**
 * Describes the proof; `head` comes first, in bold, and `kind` tells good news from bad.
 * @param {Proof | null} proof
 * @returns {{head: string, words: string, kind: string}}
 */
export function proofWords(proof) {
  if (!proof) return { head: "", words: "…", kind: "waiting" };
  if (proof === DECIDING) return { head: "deciding …", words: "", kind: "waiting" };
  if (proof === DECIDING_LONG) return { head: "deciding …:", words: " a large world takes a few seconds; you can keep drawing", kind: "waiting" };
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
 * Returns the reading of the thesis's robot in each cell. If it cannot be computed, announces why
 * and returns null.
 * @param {Studio} studio
 * @param {boolean} noise
 * @param {() => unknown} about - Identifies what the request is about
 * @returns {Promise<Board["signal"]>}
 */
export async function askSignal(studio, noise, about) {
  const world = { ...messageOf(studio.model.world), source: null };
  try {
    const values = numbersOf(await askAbout(studio.connection, about, "signal", { world, noise }));
    return { values, most: values.reduce((most, value) => Math.max(most, value), 1) };
  } catch (error) {
    if (error instanceof Refused) studio.say(error.message);
    else if (!(error instanceof Ended)) throw error;
    return null;
  }
}

/**
 * Makes a function that asks for the proof after each change; its `widest` searches for the widest
 * robot on request.
 * @param {Studio} studio - Its model and connection
 * @param {(proof: Proof) => void} proved - Called with the proof of the current drawing, or a
 *   placeholder if it takes a while
 * @param {(radius: number | symbol | null) => void} widest - Called with the largest radius that
 *   passes, m;
 *     null while it is unknown, LOOKING during a search on request
 * @returns {{(): void, widest: () => Promise<void>}}
 */
export function makeProver(studio, proved, widest) {
  const state = { soon: 0, later: 0, version: -1 };
  const prove = () => {
    clearTimeout(state.soon);
    clearTimeout(state.later);
    if (state.version !== studio.model.version) widest(null); // saving does not change the result
    state.version = studio.model.version;
    state.soon = setTimeout(() => decide(studio, proved), robotsIn(studio.model.world) > 1 ? LATER : SOON);
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
    // so that a quick proof does not flicker
    waiting = setTimeout(() => current(large ? DECIDING_LONG : DECIDING), 150);
  try {
    const sent = messageOf(studio.model.world);
    // The server reads what the page does not edit of the robots from the file's text.
    const world = hasMoreInFile(sent) ? sent : { ...sent, source: null };
    proved(await askAbout(studio.connection, () => studio.model.version, "decide", { world }));
  } catch (error) {
    if (error instanceof Refused) proved(/** @type {any} */ ({ error: error.message }));
    else if (!(error instanceof Ended)) throw error;
  } finally {
    clearTimeout(waiting);
  }
}

async function measure(studio, widest) {
  const about = () => studio.model.version,
    then = about();
  try {
    widest(await askAbout(studio.connection, about, "widest", { world: { ...messageOf(studio.model.world), source: null } }));
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    if (then === about()) widest(null);
  }
}
