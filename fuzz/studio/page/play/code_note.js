// The note about edited code: which file has changed, and whether the results are up to date with
// it.

import { el } from "#player/dom.js";
import { fileWords } from "#studio/shared/edits.js";
import { keep, keptOf } from "#studio/shared/kept.js";

const BY_ITSELF = "run-edited"; // key for the choice, in the browser's storage

/**
 * Makes the note, which is empty until a file has been edited.
 * @param {Studio} studio
 * @param {() => void} run
 * @returns {{element: HTMLElement, setting: HTMLElement, offer: () => void, edited: (files:
 *   CodeFile[]) => boolean, ran: () => void}}
 */
export function makeCodeNote(studio, run) {
  const words = el("span", {});
  const again = el("button", { type: "button", id: "run-edited", class: "small", onclick: run }, "Run again");
  const element = el("p", { class: "code-note", id: "code-note", role: "status", hidden: true }, words, again);
  const box = el("input", { type: "checkbox", id: "run-by-itself", onchange: () => keep(studio.folder, BY_ITSELF, box.checked) });
  const setting = el("label", { class: "check", hidden: true }, box, "Run again when its code is edited");
  let what = "";
  return {
    element,
    setting,
    /* Shows the setting if the user has code of their own. */
    offer: () => {
      setting.hidden = !studio.offered?.controllers.some(({ named }) => named);
      box.checked = keptOf(studio.folder, BY_ITSELF) ?? true;
    },
    /* Shows that files have changed; returns whether to run the robots again now. */
    edited: (files) => {
      what = `${fileWords(files)} changed at ${new Date().toTimeString().slice(0, 8)}`;
      const now = box.checked && studio.page() === "play";
      words.textContent = now ? `${what}: running again …` : `${what}: run again.`;
      element.className = "code-note due";
      element.hidden = false;
      again.hidden = now;
      return now;
    },
    /* Shows that a run has begun after the edit. */
    ran: () => {
      if (element.hidden) return;
      words.textContent = `${what}. What is shown comes from the current code.`;
      element.className = "code-note quiet";
      again.hidden = true;
    },
  };
}
