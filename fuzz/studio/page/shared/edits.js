// Notices that a file of a controller's code has been edited,
// from the server's report on the files.

import { Ended } from "#studio/shared/connection.js";
import { Refused } from "#studio/shared/refusals.js";

/**
 * What a result depends on: the world, the settings, and the code of its robots.
 * @typedef {object} Stamp
 * @property {string} world - A digest
 * @property {string} settings - As JSON
 * @property {Map<string, string>} code - Digest of each file of the robots' code
 */

/**
 * Returns what a result depends on that is asked for now.
 * @param {Studio} studio
 * @param {{controllers: string[]} & Record<string, unknown>} settings - Of a run or a comparison
 * @param {string} [world] - A digest; that of the drawn world if omitted
 * @returns {Stamp}
 */
export function stampOf(studio, settings, world = studio.model.digest) {
  return { world, settings: JSON.stringify(settings), code: codeOf(studio, settings.controllers) };
}

/**
 * Returns the digest of each file that robots run, as far as the server has reported it.
 * @param {Studio} studio
 * @param {string[]} robots
 * @returns {Map<string, string>}
 */
function codeOf({ code }, robots) {
  const own = (code ?? []).filter(({ controllers }) => robots.some((robot) => runsOneOf(robot, controllers)));
  return new Map(own.map(({ file, digest }) => [file, digest]));
}

/**
 * Notes which code has in fact been run; the server reports it with each result.
 * @param {Stamp} stamp
 * @param {Record<string, string> | undefined} code - Digest of each file; "?" if it is not known
 */
export function noteCode(stamp, code) {
  for (const [file, digest] of Object.entries(code ?? {})) if (digest !== "?") stamp.code.set(file, digest);
}

/**
 * Notes the files that the server has reported for the first time since: the result is of these.
 * @param {Stamp | null} then - Of the result; updated
 * @param {Stamp} now
 */
export function noteReported(then, now) {
  for (const [file, digest] of now.code) if (then && !then.code.has(file)) then.code.set(file, digest);
}

/**
 * Returns whether a result is about what is on the screen now. A file that was not reported at the
 * time of the result does not count.
 * @param {Stamp | null} then - Of the result
 * @param {Stamp} now
 * @param {boolean} [anySettings] - Whether the settings do not matter
 * @returns {boolean}
 */
export function isSame(then, now, anySettings = false) {
  if (!then || then.world !== now.world || (!anySettings && then.settings !== now.settings)) return false;
  return [...now.code].every(([file, digest]) => (then.code.get(file) ?? digest) === digest);
}

/**
 * Returns a text that changes whenever the code of robots does.
 * @param {Studio} studio
 * @param {string[]} robots
 * @returns {string}
 */
export function codeText(studio, robots) {
  return [...codeOf(studio, robots)].flat().join(" ");
}

/**
 * Returns the files that have changed since the last report, and remembers their new state.
 * @param {Map<string, string>} known - Digest of each file; updated
 * @param {CodeFile[]} files
 * @returns {CodeFile[]}
 */
function editedIn(known, files) {
  const edited = files.filter(({ file, digest }) => known.has(file) && known.get(file) !== digest);
  for (const { file, digest } of files) known.set(file, digest);
  return edited;
}

/**
 * Returns whether a robot runs one of some controllers, perhaps with options or as one of its
 * behaviours.
 * @param {string} robot
 * @param {string[]} controllers - Their names without options, as the server sends them
 * @returns {boolean}
 */
export function runsOneOf(robot, controllers) {
  // a name ends where options, a list or a class begins, so ./mine.py:Bot is not in ./mine.py:Bot2
  const separated = (name) => `,${name.replaceAll(/[+=:]/g, ",")},`;
  return controllers.some((controller) => separated(robot).includes(separated(controller)));
}

/**
 * Describes files by their names, such as "mine.py and gains.py".
 * @param {Pick<CodeFile, "name">[]} files
 * @returns {string}
 */
export function fileWords(files) {
  const names = [...new Set(files.map(({ name }) => name))];
  return names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names.at(-1)}`;
}

/**
 * Returns what the server offers. Keeps a controller that can no longer be loaded after an edit, so
 * that a run shows where its code fails.
 * @param {Offered | null} before
 * @param {Offered} now
 * @returns {Offered}
 */
export function stillOffered(before, now) {
  const earlier = new Map((before?.controllers ?? []).filter(({ fault }) => !fault).map((one) => [one.name, one]));
  const controllers = now.controllers.map((one) => (one.named && one.fault && earlier.get(one.name)) || one);
  return { ...now, controllers };
}

/**
 * Listens until the connection ends; `edited` is called with the files of each edit.
 * @param {Connection} connection
 * @param {Map<string, string>} known - What an earlier connection has learned; updated
 * @param {(files: CodeFile[]) => void} edited
 * @param {(files: CodeFile[]) => void} [reported] - Called with all files, before that
 */
export async function listenToEdits(connection, known, edited, reported = () => {}) {
  try {
    await connection.ask("edits", {}, (files) => {
      reported(files);
      const changed = editedIn(known, files);
      if (changed.length > 0) edited(changed);
    });
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
  }
}
