// Judges worlds while a reader edits them: the cores in a worker, behind promises.

import { bytesOf } from "#player/decode.js";

/**
 * Starts the worker.
 * @param {LiveCore | null | undefined} core what the page holds of it
 * @returns {Promise<Live | null>} null if the page has no core, or the browser cannot run one
 */
export async function openLive(core) {
  const able = typeof WebAssembly === "object" && typeof Worker === "function" && typeof DecompressionStream === "function";
  if (!core || !able) return null;
  try {
    return await start(core);
  } catch {
    return null;
  }
}

/**
 * @param {LiveCore} core
 * @returns {Promise<Live>}
 */
async function start(core) {
  const [script, prover, simulator] = await Promise.all([core.script, core.prover, core.simulator].map(unpacked));
  const url = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
  const worker = new Worker(url);
  /** @type {{ number: number, resolve: (answer: LiveAnswer | null) => void, reject: (error: Error) => void } | null} */
  let waiting = null;
  let count = 0;

  await new Promise((resolve, reject) => {
    worker.onerror = (event) => reject(new Error(event.message));
    worker.onmessage = ({ data }) => (data.ready ? resolve(null) : reject(new Error(data.failed)));
    worker.postMessage({ modules: { prover, simulator } }, [prover, simulator]);
  }).finally(() => URL.revokeObjectURL(url));

  worker.onmessage = ({ data }) => {
    if (data.number !== waiting?.number) return;
    const { resolve, reject } = /** @type {NonNullable<typeof waiting>} */ (waiting);
    waiting = null;
    if (data.failed) reject(new Error(data.failed));
    else resolve(data.answer);
  };
  return {
    judge: (question) =>
      new Promise((resolve, reject) => {
        waiting?.resolve(null);
        waiting = { number: ++count, resolve, reject };
        worker.postMessage({ number: count, question });
      }),
    close() {
      worker.terminate();
      waiting?.resolve(null);
      waiting = null;
    },
  };
}

/**
 * @param {string} packed base64 of gzip
 * @returns {Promise<ArrayBuffer>}
 */
function unpacked(packed) {
  const stream = new Blob([bytesOf(packed)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

/**
 * Returns a witness as the player draws it: in ms and cells.
 * @param {LiveProof} proof
 * @param {number} cellSize
 * @returns {OpenWorld["witness"]}
 */
export function drawnWitness({ witness }, cellSize) {
  if (!witness) return null;
  return {
    ms: Float64Array.from(witness.t, (t) => t * 1000),
    x: Float64Array.from(witness.x, (x) => x / cellSize),
    y: Float64Array.from(witness.y, (y) => y / cellSize),
  };
}
