// Time on the board: the moment to show of a world that changes, and the meaning of the hatching.

import { BURNING, FREE, SOLID } from "#player/decode.js";
import { el } from "#player/dom.js";

const STEPS = 400; // positions of the slider

/**
 * Returns the last moment that matters, s: the last change, or the arrival of the timed path.
 * @param {Events | null} events
 * @param {number} [arrival]
 * @returns {number}
 */
function lastMoment(events, arrival = 0) {
  return events ? events.times.reduce((last, time) => Math.max(last, time), arrival) : 0;
}

// Returns which kinds of changes a world has, by the name of their mark.
function kindsIn({ events, cells, width }) {
  const { state, ix, iy } = events ?? { state: [], ix: [], iy: [] };
  const burns = state.includes(BURNING),
    closes = state.includes(SOLID);
  const opens = state.some((now, k) => now === FREE && (closes || cells[iy[k] * width + ix[k]] === SOLID));
  return { burns, fire: burns, burnt: burns, shuts: closes, frees: opens };
}

/**
 * Makes the slider, which is visible while the drawn world changes.
 * @param {any} draw - The page, with its board and the studio
 * @returns {{element: HTMLElement, refresh: () => void}}
 */
export function makeTime(draw) {
  const { board, studio } = draw;
  const readout = el("output", { for: "board-time" });
  const show = () => {
    readout.textContent = `${board.time.toFixed(1)} s`;
    slider.setAttribute("aria-valuetext", readout.textContent);
    board.draw();
  };
  const last = () => lastMoment(studio.model.world.events, board.proof?.duration);
  const slider = el("input", {
    type: "range",
    id: "board-time",
    min: 0,
    max: STEPS,
    step: 1,
    value: 0,
    oninput: () => {
      board.time = (last() * slider.valueAsNumber) / STEPS;
      show();
    },
  });
  const swatch = (name, words) => el("li", {}, el("i", { class: `square ${name}` }), words);
  const legend = el(
    "ul",
    { class: "legend", "aria-label": "Cell changes" },
    swatch("burns", "burns later"),
    swatch("fire", "burns"),
    swatch("burnt", "burnt"),
    swatch("shuts", "closes later"),
    swatch("frees", "opens later"),
  );
  const element = el("div", { class: "time-slider", hidden: true }, el("label", { class: "field" }, "Time", slider, readout), legend);
  let sheet = null;
  return {
    element,
    refresh: () => {
      const { world } = studio.model;
      element.hidden = !world.events;
      if (world.sheet === sheet && world.events) return;
      sheet = world.sheet;
      board.time = 0;
      slider.value = "0";
      readout.textContent = "0.0 s";
      const happens = kindsIn(world);
      for (const item of legend.querySelectorAll("li")) item.hidden = !happens[item.firstElementChild?.classList[1] ?? ""];
    },
  };
}
