// Requests whose answer is only right as long as what they are about stays on the screen.

import { Ended } from "#studio/shared/connection.js";
import { Refused } from "#studio/shared/refusals.js";

const OUTDATED = "This has changed in the meantime.";
let opening = 0; // number of the last request for a world to be shown

/**
 * Sends a request. If what it is about has changed when the answer or a part of it arrives, that is
 * dropped, and the request fails with Ended.
 * @template {keyof Messages} K
 * @param {Connection} connection
 * @param {() => unknown} about - Returns a value that identifies what the request is about
 * @param {K} kind
 * @param {Messages[K]["request"]} message
 * @param {(part: Messages[K]["part"], code: Record<string, string>) => void} [part]
 * @returns {Promise<Messages[K]["answer"]>}
 */
export async function askAbout(connection, about, kind, message, part = () => {}) {
  const then = about();
  const isCurrent = () => Object.is(about(), then);
  try {
    const answer = await connection.ask(kind, message, (one, code) => isCurrent() && part(one, code));
    if (isCurrent()) return answer;
  } catch (error) {
    if (isCurrent() || !(error instanceof Refused || error instanceof Ended)) throw error;
  }
  throw new Ended(OUTDATED);
}

/**
 * Asks for a world to be shown. Only the last such request is answered, in whatever order the
 * answers arrive.
 * @template {keyof Messages} K
 * @param {Connection} connection
 * @param {K} kind
 * @param {Messages[K]["request"]} message
 * @param {(part: Messages[K]["part"]) => void} [progress]
 * @returns {Promise<Messages[K]["answer"]>}
 */
export function askToOpen(connection, kind, message, progress) {
  opening += 1;
  return askAbout(connection, () => opening, kind, message, progress);
}
