// The panel that says which robots drive, and how.

import { choice, el } from "/player/dom.js";
import { labelled, number, parameterField, words } from "./fields.js";

const MOST = 6; // robots at once

export function makeRobots(studio, run) {
  const state = {
    motion: "stepped",
    chosen: ["thesis-2"],
    seed: 0,
    time_step: 0.015,
    steps: 20_000,
    options: {},
    still: false,
    built: false,
  };
  const parts = {};
  parts.run = runButton(run);
  parts.list = el("div", { class: "robots", role: "group", "aria-label": "Controllers" });
  parts.motion = el("div");
  parts.options = el("div");
  parts.numbers = el("div");
  const element = el(
    "div",
    { class: "setup" },
    el("div", { class: "line" }, el("h2", {}, "Robots"), parts.run),
    parts.motion,
    parts.list,
    parts.numbers,
    el("details", {}, el("summary", {}, "Options of the motion model"), parts.options),
  );
  const robots = { studio, state, parts };
  return {
    element,
    refresh: () => refresh(robots),
    message: () => messageFor(robots),
    prefer: (failure) => prefer(robots, failure),
  };
}

function runButton(run) {
  return el(
    "button",
    {
      type: "button",
      id: "run",
      class: "main",
      title: "Run (Ctrl+Enter)",
      "aria-keyshortcuts": "Control+Enter",
      onclick: run,
    },
    "Run",
  );
}

function refresh(robots) {
  const { studio, state, parts } = robots;
  if (!studio.offered) return;
  if (parts.still) parts.still.hidden = !studio.model.world.events;
  if (state.built) return;
  state.built = true;
  const motions = studio.offered.motions.map(({ name, about }) => [name, `${name}: ${about}`]);
  const list = choice(motions, state.motion, (event) => setMotion(robots, event.target.value));
  parts.motionList = list;
  parts.motion.replaceChildren(labelled("Motion model", list));
  setMotion(robots, state.motion);
  showNumbers(robots);
}

function motionOf({ studio, state }) {
  return studio.offered.motions.find(({ name }) => name === state.motion);
}

function offeredTo(robots) {
  const { thesis } = motionOf(robots);
  return robots.studio.offered.controllers.filter((one) => !one.fault && (thesis ? one.thesis : one.lattice));
}

function setMotion(robots, name) {
  const { state, parts } = robots;
  state.motion = name;
  state.options = {};
  const names = offeredTo(robots).map((one) => one.name);
  state.chosen = state.chosen.filter((one) => names.includes(one));
  if (state.chosen.length === 0) state.chosen = [names[0]];
  parts.motionList.value = name;
  showList(robots);
  showOptions(robots);
}

function showList(robots) {
  const { state, parts } = robots;
  const one = (name) =>
    el(
      "label",
      { class: "check" },
      el("input", {
        type: "checkbox",
        value: name,
        checked: state.chosen.includes(name),
        disabled: !state.chosen.includes(name) && state.chosen.length >= MOST,
        onchange: (event) => toggle(robots, name, event.target.checked),
      }),
      name,
    );
  parts.list.replaceChildren(...offeredTo(robots).map(({ name }) => one(name)));
}

function toggle(robots, name, on) {
  const { state } = robots;
  state.chosen = state.chosen.filter((one) => one !== name);
  if (on) state.chosen.push(name);
  showList(robots);
  robots.parts.list.querySelector(`input[value="${CSS.escape(name)}"]`)?.focus();
  robots.parts.run.disabled = state.chosen.length === 0;
}

function showNumbers(robots) {
  const { state, parts } = robots;
  parts.seed = number(state.seed, (value) => (state.seed = Math.round(value)), { low: 0, step: 1 });
  parts.step = number(state.time_step, (value) => (state.time_step = value), { low: 0.001, high: 10 });
  parts.steps = el("input", {
    type: "number",
    value: state.steps,
    min: 1,
    max: 1_000_000,
    step: 1,
    placeholder: "auto",
    onchange: (event) => (state.steps = event.target.value),
  });
  const still = el("input", { type: "checkbox", onchange: (event) => (state.still = event.target.checked) });
  parts.still = el(
    "label",
    { class: "check", hidden: !robots.studio.model.world.events },
    still,
    "The world stands still",
  );
  parts.numbers.replaceChildren(
    el(
      "div",
      { class: "triple" },
      labelled("Time step", parts.step, { unit: "s" }),
      labelled("Seed", parts.seed),
      labelled("Steps", parts.steps),
    ),
    parts.still,
  );
}

function showOptions(robots) {
  const { state, parts } = robots;
  const field = (option) => {
    const value = state.options[option.name] ?? option.default;
    const input = parameterField(option, value, (given) => {
      if (given === option.default) delete state.options[option.name];
      else state.options[option.name] = given;
    });
    return labelled(words(option.name), input, { unit: option.unit, help: option.help });
  };
  parts.options.replaceChildren(...motionOf(robots).options.map(field));
}

function messageFor({ state }) {
  const steps = state.steps === "" ? null : Number(state.steps);
  return {
    controllers: state.chosen,
    motion: state.motion,
    time_step: state.time_step,
    seed: state.seed,
    steps,
    options: state.options,
    still: state.still,
  };
}

// A failure's file was opened: its controller, with its settings.
function prefer(robots, failure) {
  const { state, studio } = robots;
  refresh(robots);
  if (!studio.offered || !studio.offered.controllers.some(({ name }) => name === failure.controller)) return;
  const { steps, time_step: timeStep, ...options } = failure.parameters;
  state.chosen = [failure.controller];
  setMotion(robots, failure.motion);
  Object.assign(state, { seed: failure.seed, time_step: timeStep ?? 0.015, steps: steps ?? "", options });
  showNumbers(robots);
  showOptions(robots);
}
