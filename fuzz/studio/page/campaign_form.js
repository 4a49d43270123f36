// The form that begins a campaign: what `worldgen fuzz` takes.

import { choice, el } from "/player/dom.js";
import { labelled, number } from "./fields.js";
import { messageOf } from "./model.js";

export function makeForm(campaign) {
  const state = { motion: "swept", controller: "turn-right", worlds: "search", goal: "seconds", units: 50, seconds: 30, lanes: new Set(), named: false };
  const parts = { fields: el("div", {}) };
  const submit = (event) => {
    event.preventDefault();
    campaign.begin(messageFor(form));
  };
  parts.element = el("form", { class: "campaign-form", id: "campaign-form", novalidate: true, onsubmit: submit }, parts.fields);
  const form = { campaign, state, parts, built: false };
  return { element: parts.element, refresh: () => refresh(form), workers: () => (form.built ? parts.workers.valueAsNumber || null : null) };
}

function refresh(form) {
  const { campaign, parts, state } = form;
  const { offered } = campaign.studio;
  if (!offered || !campaign.offered) return;
  if (form.built) {
    suggestFolder(form);
    return;
  }
  form.built = true;
  const motions = offered.motions.map(({ name, about }) => [name, `${name}: ${about}`]);
  parts.motion = choice(motions, state.motion, (event) => setMotion(form, event.target.value));
  parts.controllerPlace = el("div", {});
  parts.folder = el("input", { type: "text", autocomplete: "off", required: true, oninput: () => (state.named = true) });
  parts.seed = el("input", { type: "text", inputmode: "numeric", value: "1", pattern: "[0-9]+" });
  parts.workers = number(campaign.offered.cores, () => {}, { low: 1, high: 256, step: 1 });
  parts.fields.replaceChildren(
    el("h2", {}, "New campaign"),
    labelled("Motion model", parts.motion),
    parts.controllerPlace,
    worldsPart(form),
    goalPart(form),
    el("div", { class: "pair-fields" }, labelled("Seed", parts.seed), labelled("Workers", parts.workers)),
    labelled("Folder for the failures", parts.folder, { help: "Below the opened one." }),
    knownPart(form),
    morePart(form),
    el("div", { class: "actions" }, el("button", { type: "submit", class: "main", id: "begin" }, "Begin")),
    el("p", { class: "quiet small-print" }, "It runs in a process of its own, and goes on when this page or the studio is closed."),
  );
  setMotion(form, state.motion);
}

function setMotion(form, name) {
  const { campaign, state, parts } = form;
  state.motion = name;
  const motion = campaign.studio.offered.motions.find((one) => one.name === name);
  const fitting = campaign.studio.offered.controllers.filter((one) => !one.fault && (motion.thesis ? one.thesis : one.lattice));
  if (!fitting.some((one) => one.name === state.controller)) state.controller = fitting[0].name;
  const change = (event) => {
    state.controller = event.target.value;
    suggestFolder(form);
  };
  const list = choice(
    fitting.map((one) => [one.name, one.name]),
    state.controller,
    change,
  );
  list.id = "campaign-controller";
  parts.controllerPlace.replaceChildren(labelled("Controller", list));
  suggestFolder(form);
}

// A name that no folder has yet, unless one was typed.
function suggestFolder({ campaign, state, parts }) {
  if (state.named || document.activeElement === parts.folder) return;
  const plain = state.controller.split(/[/\\]/).at(-1).replace(/[^A-Za-z0-9._+-]+/g, "-").replace(/^[.-]+/, "");
  const taken = new Set([...campaign.states.keys(), ...campaign.folders.map(({ name }) => name)]);
  const name = `${plain || "campaign"}-${state.motion}`;
  let number = 1;
  while (taken.has(number === 1 ? name : `${name}-${number}`)) number += 1;
  parts.folder.value = number === 1 ? name : `${name}-${number}`;
}

function radios(form, name, title, pairs, change) {
  const one = ([value, words]) =>
    el(
      "label",
      { class: "check" },
      el("input", { type: "radio", name: `campaign-${name}`, value, checked: form.state[name] === value, onchange: () => change(value) }),
      words,
    );
  return el("fieldset", { class: "radios" }, el("legend", {}, title), pairs.map(one));
}

function worldsPart(form) {
  const { campaign, state } = form;
  const names = [...campaign.offered.lanes, ...campaign.studio.offered.families.map(({ name }) => name)];
  const box = (name) => {
    const change = (event) => (event.target.checked ? state.lanes.add(name) : state.lanes.delete(name));
    return el("label", { class: "check" }, el("input", { type: "checkbox", value: name, onchange: change }), name);
  };
  const lanes = el("div", { class: "robots", id: "campaign-lanes", role: "group", "aria-label": "Lanes and families", hidden: true }, names.map(box));
  const pairs = [
    ["search", "As the search chooses"],
    ["some", "Of these lanes and families"],
    ["drawn", "The drawn map: only start, target and radius vary"],
  ];
  const set = (value) => {
    state.worlds = value;
    lanes.hidden = value !== "some";
  };
  return el("div", {}, radios(form, "worlds", "Worlds", pairs, set), lanes);
}

function goalPart(form) {
  const { state, parts } = form;
  const set = (value) => {
    state.goal = value;
    parts.amount.value = state[value];
    parts.amount.setAttribute("aria-label", value === "units" ? "Units" : "Seconds");
  };
  parts.amount = number(state.seconds, (value) => (state[state.goal] = value), { low: 1, step: 1 });
  parts.amount.id = "campaign-amount";
  parts.amount.setAttribute("aria-label", "Seconds");
  const pairs = [
    ["seconds", "Seconds"],
    ["units", "Units of work"],
  ];
  return el("div", { class: "goal" }, radios(form, "goal", "How long", pairs, set), parts.amount);
}

function knownPart({ parts, campaign }) {
  parts.known = el("input", { type: "checkbox", checked: true });
  return el("label", { class: "check" }, parts.known, `Count what is in ${campaign.offered.known}/, but keep only what is new`);
}

function morePart({ parts, campaign }) {
  parts.step = el("input", { type: "number", min: 0.001, max: 10, step: "any", placeholder: "usual" });
  parts.examples = el("input", { type: "number", min: 1, max: 100_000, step: 1, placeholder: "400" });
  parts.oracles = el("input", { type: "text", autocomplete: "off", placeholder: "detour=5 turn" });
  parts.vary = el("input", { type: "text", autocomplete: "off", placeholder: "robot_speed=1,2" });
  return el(
    "details",
    {},
    el("summary", {}, "More"),
    el("div", { class: "pair-fields" }, labelled("Time step", parts.step, { unit: "s" }), labelled("Draws a unit", parts.examples)),
    labelled("Oracles", parts.oracles, { help: `With blanks between: ${campaign.offered.oracles.join(", ")}.` }),
    labelled("Vary", parts.vary, { help: "NAME=VALUE,VALUE with blanks between; the simplest value first." }),
  );
}

function messageFor({ campaign, state, parts }) {
  const whole = ({ valueAsNumber: value }) => (Number.isFinite(value) ? Math.round(value) : null);
  const listed = (input) => input.value.split(/\s+/).filter(Boolean);
  const message = {
    folder: parts.folder.value.trim(),
    controller: state.controller,
    motion: state.motion,
    lanes: state.worlds === "some" ? [...state.lanes] : [],
    world: state.worlds === "drawn" ? messageOf(campaign.studio.model.world) : null,
    seed: parts.seed.value.trim(),
    workers: whole(parts.workers),
    examples: whole(parts.examples),
    time_step: Number.isFinite(parts.step.valueAsNumber) ? parts.step.valueAsNumber : null,
    oracles: listed(parts.oracles),
    vary: listed(parts.vary),
    known: parts.known.checked,
  };
  state.named = false; // the next one gets a name of its own
  return { ...message, [state.goal]: whole(parts.amount) };
}
