// A one-minute tour: what the pages are for, one sentence and one place at a time. The user can
// leave it at any step.

import { byId, el } from "#player/dom.js";

const STOPS = [
  ["draw", "#board", "Draw walls on the board with the mouse, a finger or the arrow keys and Space. The right button erases."],
  ["draw", "#proof", "Here you see whether your robot can get through. The dashed line is a path for its disc; a ring is the cut that blocks it."],
  ["draw", "#tab-maker", "Generate makes mazes, caves, fires and other worlds, each with a proof that the target can be reached."],
  ["play", "#run", "Play runs robots in your drawing. Choose one or more controllers, and press Run or Ctrl+Enter."],
  ["play", ".results", "The result shows how each run ended. Space plays it; the slider moves through time."],
  ["campaign", "#campaign-form", "A campaign searches for worlds in which a controller fails, and makes each as small as possible."],
  ["compare", "#compare-form", "Compare runs several robots in several worlds and shows the results in one table. A click on a result plays it."],
  ["campaign", "#campaign-form", "Start the studio with --controller ./mine.py:Robot to do all this with your own robot. It runs again whenever you save its file."],
];

/**
 * Makes the tour.
 * @param {Studio} studio
 * @returns {{element: HTMLElement, begin: () => void}}
 */
export function makeTour(studio) {
  const state = { at: 0, before: /** @type {HTMLElement | null} */ (null) };
  const words = el("p", { id: "tour-words" });
  const count = el("span", { class: "quiet" });
  const back = el("button", { type: "button", onclick: () => go(state.at - 1) }, "Back");
  const next = el("button", { type: "button", class: "main", id: "tour-next", onclick: () => go(state.at + 1) }, "Next");
  const element = el(
    "section",
    { class: "tour", role: "region", "aria-label": "Tour", hidden: true, onkeydown: (event) => event.key === "Escape" && go(-1) },
    words,
    el("div", { class: "line" }, count, el("span", { class: "actions" }, el("button", { type: "button", onclick: () => go(-1) }, "End"), back, next)),
  );
  // Moves the place into view; the sentence is at the bottom, unless it would hide the place there.
  const lead = () => {
    const shown = document.querySelector(".toured");
    if (!shown || element.hidden) return;
    shown.scrollIntoView({ block: "center" });
    const { top, bottom } = shown.getBoundingClientRect();
    element.classList.toggle("above", (top + bottom) / 2 > innerHeight - element.offsetHeight - 24);
  };
  new ResizeObserver(lead).observe(byId("main")); // a run that ends moves what is below it
  const go = (at) => {
    for (const one of document.querySelectorAll(".toured")) one.classList.remove("toured");
    state.at = at;
    const stop = STOPS[at];
    element.hidden = !stop;
    if (!stop) {
      state.before?.focus();
      return;
    }
    const [page, place, text] = stop;
    studio.go(page);
    if (place === "#tab-maker") studio.draw.panel("maker");
    document.querySelector(place)?.classList.add("toured");
    words.textContent = text;
    lead();
    count.textContent = `${at + 1} of ${STOPS.length}`;
    back.disabled = at === 0;
    next.textContent = at + 1 === STOPS.length ? "Done" : "Next";
    next.focus({ preventScroll: true });
    studio.say(text);
  };
  return {
    element,
    begin: () => {
      state.before = /** @type {HTMLElement | null} */ (document.activeElement);
      go(0);
    },
  };
}
