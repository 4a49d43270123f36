// The connection to the server: questions and answers by number; it comes back by itself when it was gone.

const FIRST_WAIT = 300; // ms before the first attempt to come back
const LONGEST_WAIT = 3000;

/** What is asked again in vain: the connection was gone meanwhile, or a newer question has replaced it. */
export class Ended extends Error {}

/** What the server objects to, in its own words. */
export class Refused extends Error {}

/* A connection.
     begun(begins)       called each time the connection is there
     lost(forbidden)     called when it is gone; forbidden: the server is there, but does not know this page any more */
export function makeConnection(begun, lost) {
  const state = { socket: null, number: 0, waiting: new Map(), wait: FIRST_WAIT, opened: false };
  const open = () => {
    state.opened = false;
    state.socket = new WebSocket(`ws://${location.host}/socket`);
    state.socket.addEventListener("message", (event) => hear(state, JSON.parse(event.data), begun));
    state.socket.addEventListener("close", async () => {
      for (const { fail } of state.waiting.values()) fail(new Ended("The connection is gone."));
      state.waiting.clear();
      lost(!state.opened && (await isForbidden()));
      setTimeout(open, state.wait);
      state.wait = Math.min(LONGEST_WAIT, state.wait * 1.6);
    });
  };
  open();
  return { ask: (kind, message = {}, part = () => {}) => ask(state, kind, message, part) };
}

function hear(state, said, begun) {
  if (!("id" in said)) {
    state.opened = true;
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
  else question.fail(said.ended ? new Ended("A newer question came.") : new Refused(said.error));
}

function ask(state, kind, message, part) {
  if (!state.socket || state.socket.readyState !== WebSocket.OPEN)
    return Promise.reject(new Ended("The server is not there."));
  state.number += 1;
  const id = state.number;
  state.socket.send(JSON.stringify({ ...message, id, do: kind }));
  return new Promise((done, fail) => state.waiting.set(id, { done, fail, part }));
}

async function isForbidden() {
  try {
    return (await fetch("/studio/start.js", { method: "HEAD" })).status === 403;
  } catch {
    return false;
  }
}
