// The connection to the server: requests and answers by number. It reconnects automatically.

import { Refused } from "#studio/shared/refusals.js";

const FIRST_WAIT = 300; // ms before the first attempt to reconnect
const LONGEST_WAIT = 3000;
const TOO_LARGE = 1009;
const TOKEN = "worldgen-studio-token"; // stored for pages of this port only, unlike a cookie
let token = "";

/** Removes the token from the address that the browser shows and remembers, and keeps it. */
export function takeToken() {
  token = new URLSearchParams(location.search).get("token") || "";
  history.replaceState(null, "", `${location.pathname}${location.hash}`);
}

/** Stores the token for reloads of this page, and for pages
 * that were open before the server restarted. */
export function shareToken() {
  try {
    if (token) localStorage.setItem(TOKEN, token);
  } catch {
    // no storage: a reload loses the token
  }
}

// Returns the newest token: another page may have been opened since with a restarted server's
// token.
function newestToken() {
  try {
    return localStorage.getItem(TOKEN) || token;
  } catch {
    return token;
  }
}

/**
 * A connection's state.
 * @typedef {object} State
 * @property {WebSocket | null} socket
 * @property {number} number - Number of the last request
 * @property {number} largest - Limit of a message to the server, bytes, once the server has sent it
 * @property {Map<number, {done: (answer: any) => void, fail: (error: Error) => void, part: (part: any,
 *   code: Record<string, string>) => void}>} waiting
 * @property {number} wait - ms before the next attempt to reconnect
 * @property {boolean} opened
 */

/** A request without an answer: it was stopped or replaced by a newer one,
 * or the connection was lost. */
export class Ended extends Error {}

/**
 * Makes a connection.
 * @param {Given} given - By the server with the page
 * @param {(begins: Begins) => void} begun - Called whenever the connection is established
 * @param {(forbidden: boolean, why: string) => void} lost - Called when it is lost;
 *     forbidden: the server runs but no longer accepts this page; why: a sentence from the server,
 *     or empty
 * @param {Promise<any>} ready - The connection opens after this promise
 * @returns {Connection}
 */
export function makeConnection(given, begun, lost, ready) {
  /** @type {State} */
  const state = { socket: null, number: 0, largest: Infinity, waiting: new Map(), wait: FIRST_WAIT, opened: false };
  const open = () => {
    state.opened = false;
    const socket = new WebSocket(`ws://${location.host}/socket`, [given.subprotocol, newestToken()].filter(Boolean));
    state.socket = socket;
    socket.addEventListener("message", (event) => hear(state, JSON.parse(event.data), begun, given));
    socket.addEventListener("close", async ({ code, reason }) => {
      const error = code === TOO_LARGE ? new Refused(tooLarge(state)) : new Ended("The connection was lost.");
      for (const { fail } of state.waiting.values()) fail(error);
      state.waiting.clear();
      if (code === given.full) lost(false, reason);
      else lost(!state.opened && (await isForbidden()), "");
      setTimeout(open, state.wait);
      state.wait = Math.min(LONGEST_WAIT, state.wait * 1.6);
    });
  };
  ready.finally(open);
  return { ask: (kind, message = {}, part = () => {}) => ask(state, kind, message, part) };
}

/**
 * @param {State} state
 * @param {any} said
 * @param {(begins: Begins) => void} begun
 * @param {Given} given
 */
function hear(state, said, begun, given) {
  if (!("id" in said)) {
    if (said.protocol !== given.protocol) {
      location.reload(); // load the page of the current server; the drawing is kept
      return;
    }
    state.opened = true;
    state.largest = said.limits.message;
    state.wait = FIRST_WAIT;
    begun(said);
    return;
  }
  const question = state.waiting.get(said.id);
  if (!question) return;
  if ("part" in said) {
    question.part(said.part, said.code ?? {});
    return;
  }
  state.waiting.delete(said.id);
  if ("answer" in said) question.done(said.answer);
  else question.fail(said.ended ? new Ended("Stopped.") : new Refused(said.error));
}

/**
 * @param {State} state
 * @param {string} kind
 * @param {object} message
 * @param {(part: any, code: Record<string, string>) => void} part
 * @returns {Asked<any>}
 */
function ask(state, kind, message, part) {
  if (!state.socket || state.socket.readyState !== WebSocket.OPEN)
    return refused(new Ended("The server does not answer."));
  const id = state.number + 1,
    text = JSON.stringify({ ...message, id, do: kind });
  if (3 * text.length > state.largest && new Blob([text]).size > state.largest)
    return refused(new Refused(tooLarge(state)));
  state.number = id;
  state.socket.send(text);
  const answer = new Promise((done, fail) => state.waiting.set(id, { done, fail, part }));
  const stop = () => {
    if (state.waiting.has(id)) ask(state, "cancel", { of: id }, () => {}).catch(() => {});
  };
  return Object.assign(answer, { stop });
}

// A request that was never sent can be stopped like any other.
function refused(error) {
  return Object.assign(Promise.reject(error), { stop: () => {} });
}

// A larger message would end the connection, together with all waiting requests.
function tooLarge({ largest }) {
  return `This is more than ${largest / 2 ** 20} MiB, the limit for one message to the studio; put the file into the studio's folder, or draw a smaller world.`;
}

async function isForbidden() {
  try {
    await fetch("/studio/start.js", { method: "HEAD" });
    return true; // the server runs, but does not accept this page
  } catch {
    return false;
  }
}
