// The worlds of a comparison: the open one, the examples, and those in folders.

import { plural } from "#player/dom.js";
import { EXAMPLES } from "#studio/draw/examples.js";

const OPEN = "open",
  SAMPLES = "examples",
  FOLDER = "folder:"; // followed by its name; the opened one has none

const folderOf = (name) => name.slice(0, Math.max(0, name.lastIndexOf("/")));

/**
 * Returns the sources of worlds that can be chosen, as pairs of a key and words; the user's own
 * folders come first.
 * @param {{name: string, world: boolean, found: boolean}[]} files
 * @returns {[string, string][]}
 */
export function sourcesOf(files) {
  const counts = new Map();
  for (const { name, world } of files) if (world) counts.set(folderOf(name), (counts.get(folderOf(name)) ?? 0) + 1);
  const folders = [...counts].map(([name, count]) => /** @type {[string, string]} */ ([`${FOLDER}${name}`, `${name || "The opened folder"} (${plural(count, "world")})`]));
  const examples = Object.keys(EXAMPLES).join(", ");
  return [[OPEN, "The open world"], [SAMPLES, `The examples: ${examples}`], ...folders];
}

/**
 * Returns the worlds of some sources, each with its name and how the server finds it.
 * @param {string[]} sources
 * @param {{name: string, world: boolean}[]} files
 * @param {{name: string, world: WorldMessage}} open - The world on the board
 * @returns {ChosenWorld[]}
 */
export function worldsOf(sources, files, open) {
  /** @type {(source: string) => ChosenWorld[]} */
  const worlds = (source) => {
    if (source === OPEN) return [{ name: open.name || "the open world", world: open.world }];
    if (source === SAMPLES) return Object.entries(EXAMPLES).map(([name, [family, seed]]) => ({ name: `example ${name}`, family, seed }));
    if (!source.startsWith(FOLDER)) return [];
    const folder = source.slice(FOLDER.length);
    return files.filter(({ name, world }) => world && folderOf(name) === folder).map(({ name }) => ({ name, file: name }));
  };
  return sources.flatMap(worlds);
}
