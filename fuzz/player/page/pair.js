// Two runs side by side on one stage, played in step: the earlier one on the left.

import { el } from "#player/dom.js";

/**
 * Adds another drawn run to a stage, or removes it; returns the player's `beside`.
 * @param {HTMLElement} stage
 * @param {Pick<Beside, "world" | "run" | "sensors"> | null} other - { world, run, sensors }, or
 *   null
 * @param {string[]} [words] - Labels of the two: the other run, and the one in front
 * @returns {Beside | null}
 */
export function besideIn(stage, other, words = ["", ""]) {
  for (const old of stage.querySelectorAll(".beside, .tag")) old.remove();
  stage.classList.toggle("both", other !== null);
  if (other === null) return null;
  const canvas = el("canvas", { class: "beside", role: "img", "aria-label": words[0] });
  stage.prepend(canvas);
  stage.append(...words.map((text) => el("span", { class: "tag" }, text)));
  return { ...other, canvas, words };
}
