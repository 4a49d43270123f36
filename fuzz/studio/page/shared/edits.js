// Notices that a file of a controller's code has been edited,
// from the server's report on the files.

import { Ended } from "#studio/shared/connection.js";
import { Refused } from "#studio/shared/refusals.js";

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
 */
export async function listenToEdits(connection, known, edited) {
  try {
    await connection.ask("edits", {}, ({ files }) => {
      const changed = editedIn(known, files);
      if (changed.length > 0) edited(changed);
    });
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
  }
}
