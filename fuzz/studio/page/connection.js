// The connection to the server: questions and answers by number; it comes back by itself when it was gone.

import { Refused } from "./refusals.js";

const FIRST_WAIT = 300; // ms before the first attempt to come back
const LONGEST_WAIT = 3000;
const PROTOCOL = 2; // that this page speaks
const FULL = 4000; // the code with which the server closes a connection too many; the reason is a sentence
const TOO_LARGE = 1009;
const TOKEN = "worldgen-studio-token"; // kept for this port's pages alone, unlike a cookie
let token = "";

/** Takes the token of the address that was opened out of what the browser shows and remembers. */
export function takeToken() {
  token = new URLSearchParams(location.search).get("token") || "";
  history.replaceState(null, "", `${location.pathname}${location.hash}`);
}

/** Keeps that token for this page when it is loaded anew, and for the pages of before the server's start. */
export function shareToken() {
  try {
    if (token) localStorage.setItem(TOKEN, token);
  } catch {
    // no storage: this page has the token until it is loaded anew
  }
}

// The newest token: another page may have been opened since, with that of a new start.
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
 * @property {number} number - Of the last question
 * @property {number} largest - Bytes of a message to the server, once it has told
 * @property {Map<number, {done: (answer: any) => void, fail: (error: Error) => void, part: (part: any) => void}>} waiting
 * @property {number} wait - ms before the next attempt to come back
 * @property {boolean} opened
 */

/** What was asked in vain: it was stopped, a newer question has replaced it, or the connection is gone. */
export class Ended extends Error {}

/**
 * A connection.
 * @param {(begins: Begins) => void} begun - Called each time the connection is there
 * @param {(forbidden: boolean, why: string) => void} lost - Called when it is gone;
 *     forbidden: the server is there, but does not know this page any more; why: a sentence of the server's, or empty
 * @param {Promise<any>} ready - A promise: the connection is opened after it
 * @returns {Connection}
 */
export function makeConnection(begun, lost, ready) {
  /** @type {State} */
  const state = { socket: null, number: 0, largest: Infinity, waiting: new Map(), wait: FIRST_WAIT, opened: false };
  const open = () => {
    state.opened = false;
    const socket = new WebSocket(`ws://${location.host}/socket`, ["worldgen-studio", newestToken()].filter(Boolean));
    state.socket = socket;
    socket.addEventListener("message", (event) => hear(state, JSON.parse(event.data), begun));
    socket.addEventListener("close", async ({ code, reason }) => {
      const error = code === TOO_LARGE ? new Refused(tooLarge(state)) : new Ended("The connection is gone.");
      for (const { fail } of state.waiting.values()) fail(error);
      state.waiting.clear();
      if (code === FULL) lost(false, reason);
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
 */
function hear(state, said, begun) {
  if (!("id" in said)) {
    if (said.protocol !== PROTOCOL) {
      location.reload(); // the page of the server that runs now; what is drawn is kept
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
    question.part(said.part);
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
 * @param {(part: any) => void} part
 * @returns {Asked}
 */
function ask(state, kind, message, part) {
  if (!state.socket || state.socket.readyState !== WebSocket.OPEN)
    return refused(new Ended("The server is not there."));
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

// What is not asked at all can be stopped like a question, too.
function refused(error) {
  return Object.assign(Promise.reject(error), { stop: () => {} });
}

// What is larger would end the connection, and all that waits for answers with it.
function tooLarge({ largest }) {
  return `This is more than ${largest / 2 ** 20} MiB, the most that can be sent to the studio at once; put a file into its folder, draw a smaller world.`;
}

async function isForbidden() {
  try {
    await fetch("/studio/start.js", { method: "HEAD" });
    return true; // it is there and does not let this page in
  } catch {
    return false;
  }
}
