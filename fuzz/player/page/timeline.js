// The timeline: the scrub bar with its marks, and the part of the run that it and the plots show.

import { openWorld } from "#player/decode.js";
import { el, grouped, keyButton, svg } from "#player/dom.js";

const NEAREST = 20; // minimum number of steps to show

/**
 * Makes the timeline of a player.
 * @param {Player} player
 * @param {(step: number) => void} jump
 * @returns {Timeline}
 */
export function makeTimeline(player, jump) {
  const view = { from: 0, to: Math.max(1, player.last) };
  const scrub = el("input", { type: "range", step: 1, id: "scrub", "aria-label": "Step", oninput: () => jump(scrub.valueAsNumber) });
  const rail = el("div");
  const part = el("span", { class: "quiet" });
  const element = el("div", { class: "scrub" }, rail, scrub);
  let marked = "";
  const zoom = (factor, at = player.step) => {
    zoomAt(view, player.last, factor, at);
    player.update();
  };
  const buttons = el(
    "span",
    { class: "view", role: "group", "aria-label": "Timeline zoom" },
    part,
    keyButton("−", "Show more of the run", "<", () => zoom(1 / 2)),
    keyButton("+", "Show less of the run", ">", () => zoom(2)),
    keyButton("Whole run", "Show the whole run", "|", () => zoom(0)),
  );
  const draw = (step, words) => {
    follow(view, player);
    const [from, to] = [Math.floor(view.from), Math.ceil(view.to)];
    Object.assign(scrub, { min: from, max: to, value: step });
    scrub.setAttribute("aria-valuetext", words);
    if (marked === `${view.from} ${view.to}`) return;
    marked = `${view.from} ${view.to}`;
    rail.replaceChildren(marksIn(player, view));
    part.textContent = to - from < Math.max(1, player.last) ? `steps ${grouped(from)} to ${grouped(to)}` : "";
  };
  onWheel(scrub, zoom, (share) => view.from + share * (view.to - view.from));
  return { element, buttons, view, zoom, draw };
}

/**
 * Zooms a part of the timeline by the wheel; the step under the pointer stays in its place.
 * @param {HTMLElement} element
 * @param {Timeline["zoom"]} zoom
 * @param {(share: number) => number} stepAt - Returns the step at a share of the width
 */
export function onWheel(element, zoom, stepAt) {
  const wheel = (event) => {
    event.preventDefault();
    const { left, width } = element.getBoundingClientRect();
    zoom(event.deltaY < 0 ? 1.3 : 1 / 1.3, stepAt(Math.min(1, Math.max(0, (event.clientX - left) / Math.max(1, width)))));
  };
  element.addEventListener("wheel", wheel, { passive: false });
}

// Above the bar: the period of a loop, the important steps, the world's events.
function marksIn(player, view) {
  const { run, world } = player.drawn,
    share = (step) => (1000 * (step - view.from)) / (view.to - view.from);
  const bar = (name, from, to, y, height, ...children) => {
    const [left, right] = [Math.max(-8, from), Math.min(1008, to)];
    return right > left ? svg("rect", { class: name, x: left, y, width: right - left, height }, children) : null;
  };
  const tick = (name, at, half, y, ...children) => bar(`tick ${name}`, at - half, at + half, y, 14 - y, children);
  return svg(
    "svg",
    { viewBox: "-8 0 1016 14", preserveAspectRatio: "none", "aria-hidden": "true" },
    bar("rail", 0, 1000, 11, 2),
    run.loop ? bar("period", share(run.loop[0]), share(run.loop[0] + run.loop[1]), 3, 11) : null,
    changeSteps(world, run, view).map((step) => tick("change", share(step), 0.75, 8)),
    run.marks.map(({ step, kind, text }) => tick(kind, share(step), 1.5, 0, svg("title", {}, `step ${step}: ${text}`))),
  );
}

// Returns the shown steps at which the world changes, at most one for each place on the bar.
function changeSteps(world, run, { from, to }) {
  const { events } = openWorld(world);
  if (!events) return [];
  const places = new Set([...events.ms].map((ms) => Math.round((300 * (ms / (run.dt * 1000) - from)) / (to - from))));
  return [...places].filter((place) => place >= 0 && place <= 300).map((place) => from + (place * (to - from)) / 300);
}

// Changes which steps are shown, with one of them in its place; a factor of 0 shows the whole run.
function zoomAt(view, last, factor, at) {
  const whole = Math.max(1, last);
  if (factor === 0) {
    Object.assign(view, { from: 0, to: whole });
    return;
  }
  const span = Math.min(whole, Math.max(Math.min(NEAREST, whole), (view.to - view.from) / factor));
  const share = (at - view.from) / (view.to - view.from);
  const from = Math.min(whole - span, Math.max(0, at - Math.min(1, Math.max(0, share)) * span));
  Object.assign(view, { from, to: from + span });
}

// Scrolls to keep the current step in view.
function follow(view, { step, last }) {
  const span = view.to - view.from;
  if (step >= view.from && step <= view.to) return;
  const from = Math.min(Math.max(1, last) - span, Math.max(0, step - 0.1 * span));
  Object.assign(view, { from, to: from + span });
}
