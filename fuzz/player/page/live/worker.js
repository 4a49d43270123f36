// The worker behind live.js: it starts the cores, and answers one question after another.

import { openCore } from "#player/live/core.js";
import { judge } from "#player/live/judge.js";

/** Time between two looks at whether a newer question has come, ms. */
const PATIENCE = 8;
/** Thrown once nobody waits for an answer. */
const STALE = new Error("a newer question has come");

/** @typedef {{ number: number, question: LiveQuestion }} Asked */

const { port1: near, port2: far } = new MessageChannel();
/** @type {Asked | null} */
let newest = null;
let works = false;
/** @type {Promise<import("#player/live/judge.js").Cores>} */
let cores;

addEventListener("message", ({ data }) => {
  if (data.modules) {
    cores = openCores(data.modules);
    cores.then(
      () => postMessage({ ready: true }),
      (error) => postMessage({ failed: String(error) }),
    );
    return;
  }
  newest = data;
  if (!works) void work();
});

/** @param {{ prover: BufferSource, simulator: BufferSource }} modules */
async function openCores({ prover, simulator }) {
  const [one, other] = await Promise.all([openCore(prover), openCore(simulator)]);
  return { prover: one, simulator: other };
}

async function work() {
  works = true;
  while (newest) {
    const { number, question } = /** @type {Asked} */ (newest);
    newest = null;
    let last = performance.now();
    const pause = async () => {
      if (performance.now() - last > PATIENCE) {
        await messagesCome();
        last = performance.now();
      }
      if (newest) throw STALE;
    };
    try {
      postMessage({ number, answer: await judge(await cores, question, pause) });
    } catch (error) {
      if (error !== STALE) postMessage({ number, failed: String(error) });
    }
    await messagesCome();
  }
  works = false;
}

/** Lets the messages in that have come while this has worked; a timer would take 4 ms. */
const messagesCome = () =>
  new Promise((resolve) => {
    near.onmessage = resolve;
    far.postMessage(0);
  });
