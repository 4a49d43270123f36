// The form that begins a campaign, with the options of `worldgen fuzz`.

import { choice, el } from "#player/dom.js";
import { makeMore } from "#studio/campaign/more.js";
import { copied } from "#studio/shared/clipboard.js";
import { Ended } from "#studio/shared/connection.js";
import { isGood, labelled, motionField, number } from "#studio/shared/fields.js";
import { keep, keptOf } from "#studio/shared/kept.js";
import { messageOf } from "#studio/shared/world_message.js";
import { Refused } from "#studio/shared/refusals.js";

const KEPT = "campaign-form"; // key for the choices, in the browser's storage
const SLOW = 4000; // ms after which the page explains the delay
const FIRST = "The first campaign of a new installation prepares the simulator, which can take a minute.";
const USUAL = { controller: "turn-right", worlds: "search", budget: "seconds", units: 50, seconds: 30, named: false };

/**
 * @param {any} campaign
 * @returns {{element: HTMLElement, refresh: () => void, workers: () => number | null}}
 */
export function makeForm(campaign) {
  const state = { ...USUAL, motion: "", strategies: new Set(), chosen: false };
  const parts = { fields: el("div", {}, el("h2", {}, "New campaign"), el("p", { class: "quiet" }, "Loading the choices …")) };
  const sent = (event) => {
    event.preventDefault();
    return once(parts.begin, () => submit(form, (message) => begin(form, message)));
  };
  // only marked fields, so that nothing moves during a click
  const typed = ({ target }) => target.hasAttribute("aria-invalid") && isGood(target);
  const changed = () => keepForm(form); // runs after the field's own listener
  const listeners = { onsubmit: sent, oninput: typed, onchange: changed };
  parts.element = el("form", { class: "campaign-form", id: "campaign-form", novalidate: true, ...listeners }, parts.fields);
  /** @type {any} */
  const form = { campaign, state, parts, folder: null, offered: null };
  return { element: parts.element, refresh: () => refresh(form), workers: () => (form.folder === null ? null : parts.workers.valueAsNumber || null) };
}

function refresh(form) {
  const { campaign } = form;
  const { offered, folder } = campaign.studio;
  if (!offered) return;
  if (form.folder !== folder) build(form);
  // the studio was restarted and offers something else
  else if (form.offered !== offered) setMotion(form, form.state.motion);
  form.offered = offered;
  follow(form);
  suggestFolder(form);
  // archives are not accepted there
  const folders = campaign.folders.filter(({ worlds }) => worlds !== null);
  form.more.offer(folders.map(({ name }) => name).filter((name) => name && name !== offered.known));
}

// Builds the form for the opened folder, with the last choices made there.
function build(form) {
  const { campaign, parts, state } = form;
  const { offered, folder, limits } = campaign.studio;
  form.folder = folder;
  const kept = keptFor(folder, offered);
  Object.assign(state, USUAL, { motion: offered.motion }, firstOf(offered), kept.state, { strategies: new Set(kept.strategies) });
  parts.motion = motionField(offered.motions, state.motion, (name) => {
    state.chosen = true;
    setMotion(form, name);
  });
  parts.controllerPlace = el("div", {});
  parts.folder = el("input", { type: "text", autocomplete: "off", required: true, placeholder: "loading …", title: "Enter the name of a folder.", oninput: () => (state.named = true) });
  parts.seed = el("input", { type: "text", inputmode: "numeric", value: kept.seed ?? "1", required: true, pattern: "[0-9]+", title: "Enter a whole number of at least 0." });
  parts.workers = number(kept.workers ?? offered.cores, () => {}, { low: 1, high: limits.workers, step: 1 });
  parts.said = el("p", { class: "fault", role: "alert", id: "form-said" });
  parts.waiting = el("p", { class: "quiet", role: "status" });
  parts.begin = el("button", { type: "submit", class: "main", id: "begin" }, "Begin");
  parts.halt = el("button", { type: "button", id: "stop-beginning", hidden: true, onclick: () => halt(form) }, "Stop");
  const title = "The command that does the same at a terminal";
  parts.copy = el("button", { type: "button", id: "copy-command", title, onclick: () => submit(form, (message) => copyCommand(form, message)) }, "Copy command");
  form.more = makeMore(offered, limits);
  form.more.write(kept.more ?? {});
  parts.fields.replaceChildren(
    el("h2", {}, "New campaign"),
    parts.motion.element,
    parts.controllerPlace,
    worldsPart(form),
    goalPart(form),
    el("div", { class: "triple" }, form.more.robots, labelled("Seed", parts.seed), labelled("Workers", parts.workers)),
    labelled("Folder for the failures", parts.folder, { help: "A folder inside the opened one." }),
    knownPart(form, kept.known ?? true),
    form.more.element,
    parts.said,
    el("div", { class: "actions" }, parts.begin, parts.halt, parts.copy),
    parts.waiting,
    el("p", { class: "quiet small-print" }, "It runs in its own process, and continues when you close this page or the studio."),
  );
  setMotion(form, state.motion);
}

// Returns the controller to start with if there are no earlier choices: the first one named when
// the studio was started.
function firstOf({ controllers }) {
  const first = controllers.find(({ named, fault }) => named && !fault);
  return first ? { controller: first.name, motion: first.motion } : {};
}

const namedIn = ({ controllers }) => controllers.filter(({ named }) => named).map(({ name }) => name);

function keepForm({ campaign, state, parts, folder, more }) {
  const { strategies, named, ...chosen } = state;
  const fields = { seed: parts.seed.value, workers: parts.workers.value, known: parts.known.checked, more: more.written() };
  keep(folder, KEPT, { state: chosen, strategies: [...strategies], named: namedIn(campaign.studio.offered), ...fields });
}

// Returns the earlier choices that are still offered; if the studio was started
// with other controllers, those come first.
function keptFor(folder, offered) {
  const kept = keptOf(folder, KEPT) ?? {};
  const { controller, motion, ...state } = kept.state ?? {};
  const who = offered.controllers.find(({ name, fault }) => name === controller && !fault);
  const same = String(namedIn(offered)) === String(kept.named) && who && offered.motions.some(({ name }) => name === motion);
  const names = [...offered.strategies, ...offered.families.map(({ name }) => name)];
  const chosen = same ? { controller, motion } : { chosen: false };
  return { ...kept, state: { ...state, ...chosen }, strategies: (kept.strategies ?? []).filter((name) => names.includes(name)) };
}

// Follows the page Play until something is chosen here: its controller, motion model and time step.
function follow(form) {
  const { state, campaign, more } = form;
  const played = campaign.studio.play.played();
  if (!played || state.chosen) return;
  state.controller = played.controller;
  more.timeStep(played.time_step === campaign.studio.offered.time_step ? null : played.time_step);
  setMotion(form, played.motion);
}

function setMotion(form, name) {
  const { campaign, state, parts } = form;
  state.motion = name;
  parts.motion.show(name);
  const motion = campaign.studio.offered.motions.find((one) => one.name === name);
  const fitting = campaign.studio.offered.controllers.filter((one) => !one.fault && (motion.thesis ? one.thesis : one.lattice));
  if (!fitting.some((one) => one.name === state.controller)) state.controller = fitting[0].name;
  const change = (event) => {
    state.chosen = true;
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

// Suggests a name that no folder has yet, unless the user has typed one.
function suggestFolder({ campaign, state, parts }) {
  if (state.named || document.activeElement === parts.folder) return;
  const plain = state.controller.split(/[/\\]/).at(-1).replace(/[^A-Za-z0-9._+-]+/g, "-").replace(/^[.-]+/, "");
  if (!campaign.isListed) return; // the existing names are not known yet
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
  const { campaign, state, parts } = form;
  const names = [...campaign.studio.offered.strategies, ...campaign.studio.offered.families.map(({ name }) => name)];
  const box = (name) => {
    const change = (event) => (event.target.checked ? state.strategies.add(name) : state.strategies.delete(name));
    return el("label", { class: "check" }, el("input", { type: "checkbox", value: name, checked: state.strategies.has(name), onchange: change }), name);
  };
  parts.none = el("small", { class: "fault", role: "alert", hidden: true }, "Choose at least one.");
  const strategies = el("div", { class: "robots", id: "campaign-strategies", role: "group", "aria-label": "Strategies and families", hidden: state.worlds !== "some" }, names.map(box));
  parts.strategies = strategies;
  const pairs = [
    ["search", "Let the search choose"],
    ["some", "From these strategies and families"],
    ["drawn", "On the drawn map; only start, target and radius vary"],
  ];
  const set = (value) => {
    state.worlds = value;
    strategies.hidden = value !== "some";
    parts.none.hidden = true;
  };
  return el("div", {}, radios(form, "worlds", "Worlds", pairs, set), strategies, parts.none);
}

function goalPart(form) {
  const { state, parts, campaign } = form;
  const { limits } = campaign.studio;
  const set = (value) => {
    state.budget = value;
    parts.amount.value = state[value];
    parts.amount.max = limits[value];
    isGood(parts.amount);
    parts.amount.setAttribute("aria-label", value === "units" ? "Units" : "Seconds");
    hint.hidden = value !== "units";
  };
  const hint = el("small", { class: "quiet", hidden: state.budget !== "units" }, "A unit is a small search of its own, of many worlds. With a number of units, the result depends only on the seed.");
  parts.amount = number(state[state.budget], (value) => (state[state.budget] = value), { low: 1, high: limits[state.budget], step: 1 });
  parts.amount.required = true;
  parts.amount.title = "Enter a whole number of at least 1.";
  parts.amount.id = "campaign-amount";
  parts.amount.setAttribute("aria-label", state.budget === "units" ? "Units" : "Seconds");
  const pairs = [
    ["seconds", "Seconds"],
    ["units", "Units of work"],
  ];
  return el("div", {}, el("div", { class: "budget" }, radios(form, "budget", "How long", pairs, set), parts.amount), hint);
}

function knownPart({ parts, campaign }, checked) {
  parts.known = el("input", { type: "checkbox", checked });
  return el("label", { class: "check" }, parts.known, `Count causes in ${campaign.studio.offered.known}/, but keep only new ones`);
}

function messageFor({ campaign, state, parts, more }) {
  const { model } = campaign.studio;
  const given = ({ valueAsNumber: value }) => (Number.isFinite(value) ? value : null);
  return {
    ...more.filled(),
    folder: parts.folder.value.trim(),
    controller: state.controller,
    motion: state.motion,
    strategies: state.worlds === "some" ? [...state.strategies] : [],
    world: state.worlds === "drawn" ? messageOf(model.world) : null,
    world_name: state.worlds === "drawn" && !model.unsaved ? model.world.name || null : null,
    seed: parts.seed.value.trim(),
    workers: given(parts.workers),
    known: parts.known.checked,
    [state.budget]: given(parts.amount),
  };
}

// Returns whether every field is valid; if not, moves the focus to the first invalid one.
function isFilled({ parts, state }) {
  const inputs = [...parts.element.querySelectorAll("input:not([type=radio], [type=checkbox])")];
  const bad = inputs.filter((input) => !isGood(input));
  const none = state.worlds === "some" && state.strategies.size === 0;
  parts.none.hidden = !none;
  const first = none ? parts.strategies.querySelector("input") : bad[0];
  if (!first) return true;
  first.closest("details:not([open])")?.setAttribute("open", "");
  first.focus();
  return false;
}

// Runs an action started by a button, which is disabled until the action is done.
async function once(button, act) {
  if (button.disabled) return;
  button.disabled = true;
  try {
    await act();
  } finally {
    button.disabled = false;
    if (document.activeElement === document.body) button.focus();
  }
}

async function submit(form, act) {
  const { parts } = form;
  parts.said.textContent = "";
  await form.campaign.listed; // the suggested name depends on the existing folders
  if (!isFilled(form)) return;
  keepForm(form); // including choices that follow the page Play
  try {
    await act(messageFor(form));
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    parts.said.textContent = error instanceof Refused ? error.message : "";
    parts.said.scrollIntoView({ block: "nearest" });
  }
}

async function begin(form, message) {
  const { campaign, state, parts } = form;
  parts.begin.textContent = "Beginning …";
  const slow = setTimeout(() => (parts.waiting.textContent = FIRST), SLOW);
  try {
    await campaign.begin(message, (folder) => offerHalt(parts, folder));
    state.named = false; // the next campaign gets another name
    suggestFolder(form);
  } finally {
    clearTimeout(slow);
    parts.waiting.textContent = "";
    parts.begin.textContent = "Begin";
    offerHalt(parts, null);
  }
}

// Shows Stop in place of Copy command while a campaign is about to begin.
function offerHalt({ halt, copy }, folder) {
  Object.assign(halt, { value: folder, hidden: folder === null, disabled: false });
  copy.hidden = folder !== null;
}

function halt({ campaign, parts }) {
  parts.halt.disabled = true;
  campaign.halt(parts.halt.value);
}

async function copyCommand({ campaign, parts }, message) {
  const command = await campaign.studio.connection.ask("command", message);
  await copied(parts.copy, command);
}
