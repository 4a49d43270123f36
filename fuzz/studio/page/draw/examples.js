// Three worlds to start with, for users who have none yet.

import { el } from "#player/dom.js";
import { Ended } from "#studio/shared/connection.js";
import { Refused } from "#studio/shared/refusals.js";

/** By name: the family and seed of an example, and what it shows. */
export const EXAMPLES = {
  trap: ["trap", "7", "A trap: robots that only turn away from walls circle in it"],
  maze: ["maze", "3", "A maze: the path is long, and most turns are wrong"],
  fire: ["fire", "3", "A fire: the way is clear now, but not for long"],
};

/**
 * Makes a button for each example; it replaces the drawing, which undo brings back.
 * @param {Studio} studio
 * @param {(words: string) => void} told - Called with what has happened
 * @returns {HTMLElement[]}
 */
export function exampleButtons(studio, told) {
  const open = async (name, family, seed, about) => {
    try {
      told("Generating …");
      studio.go("draw"); // now, because the user may be on another page when the answer comes
      await studio.generate({ family, seed, parameters: {} }, `the example ${name}`);
      told(`${about}. Press 2 to watch a robot in it.`);
    } catch (error) {
      if (!(error instanceof Refused || error instanceof Ended)) throw error;
      told(error.message);
    }
  };
  return Object.entries(EXAMPLES).map(([name, [family, seed, about]]) =>
    el("button", { type: "button", class: "example", title: about, "data-example": name, onclick: () => open(name, family, seed, about) }, name.replace(/^./, (letter) => letter.toUpperCase())),
  );
}
