// A run beside another one in the same stage, played in step: the other on the left, as it was before.

import { el } from "#player/dom.js";

/**
 * Makes room for another drawn run in a stage, or takes it away; gives what the player wants as `beside`.
 * @param {HTMLElement} stage
 * @param {Pick<Beside, "world" | "run" | "sensors"> | null} other - { world, run, sensors }, or null
 * @param {string[]} [words] - What stands on the two: of the other one, and of the one in front
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
