// The flow chart of a robot's behaviours next to its run, with the active behaviour at the shown
// step.

import { behaviourAt, rowAt, stepWithin } from "#player/decode.js";
import { el, shortName, svg } from "#player/dom.js";
import { keep, keptOf } from "#studio/shared/kept.js";

const SHOWN = "arbitration"; // key for the choice, in the browser's storage
const SMALLEST = 0.7; // scale of a tall chart's text; a taller one scrolls

/**
 * Makes the chart, hidden until the user asks for it, and the button for it.
 * @param {Studio} studio
 * @returns {{element: HTMLElement, button: HTMLButtonElement, offer: (robot: Robot | null) => void,
 *   at: (player: Player) => void, toggle: () => void}}
 */
export function makeArbitration(studio) {
  const element = el("section", { class: "arbitration", id: "arbitration", tabindex: "0", "aria-label": "How its behaviours take turns", hidden: true });
  const button = el("button", { type: "button", id: "show-arbitration", class: "small", hidden: true, "aria-controls": "arbitration", "aria-keyshortcuts": "b", title: "How its behaviours take turns, and which one is active (b)", onclick: toggle }, "Flow chart");
  /** @type {{chart: FlowChart | null, acting: string | null, now: HTMLElement | null}} */
  const state = { chart: null, acting: null, now: null };
  let wanted = false;

  function toggle() {
    if (!state.chart) return;
    wanted = !wanted;
    keep(studio.folder, SHOWN, wanted);
    show();
  }

  function show() {
    element.hidden = !(wanted && state.chart);
    button.hidden = !state.chart;
    button.setAttribute("aria-pressed", String(wanted));
  }

  /* Takes the robot in front; keeps the chart if it is the same. */
  function offer(robot) {
    const chart = robot?.arbitration ?? null;
    wanted = keptOf(studio.folder, SHOWN) ?? false;
    if (robot && chart && chart !== state.chart) {
      state.now = el("b", {});
      state.acting = null;
      element.replaceChildren(
        el("p", {}, `${shortName(robot.name)}, by ${chart.arbiter}. Acts now: `, state.now),
        drawn(chart, robot.name),
        el("ol", { class: "away", "aria-label": "Behaviours" }, chart.words.map((words) => el("li", {}, words))),
      );
    }
    state.chart = chart;
    show();
  }

  /* Marks the behaviour that acts at the player's step. */
  function at({ drawn: { run }, step }) {
    if (!state.chart || !state.now || !run) return;
    const acting = behaviourAt(run, rowAt(run, stepWithin(run, step)));
    if (acting === state.acting) return;
    state.acting = acting;
    state.now.textContent = acting;
    for (const box of element.querySelectorAll("[data-part]")) box.classList.toggle("acts", box.getAttribute("data-part") === acting);
  }

  return { element, button, offer, at, toggle };
}

/**
 * Draws the chart: as wide as there is room, and smaller if it is too tall.
 * @param {FlowChart} chart
 * @param {string} name
 */
function drawn({ width, height, shapes }, name) {
  const picture = svg(
    "svg",
    { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `Flow chart of ${shortName(name)}` },
    shapes.map(([tag, attributes, words]) => svg(tag, attributes, words)),
  );
  picture.style.minHeight = `${Math.round(SMALLEST * height)}px`;
  return picture;
}
