// The panel for choosing robots and their settings.

import { askAbout } from "#studio/shared/asking.js";
import { breakable, el, plural, shortName } from "#player/dom.js";
import { Ended } from "#studio/shared/connection.js";
import { isField, isGood, labelled, motionField, number } from "#studio/shared/fields.js";
import { robotsIn } from "#player/edit/model.js";
import { messageOf } from "#studio/shared/world_message.js";
import { keep, keepInTab, keptInTab, keptOf } from "#studio/shared/kept.js";
import { isOfferedAs } from "#studio/shared/links.js";
import { Refused } from "#studio/shared/refusals.js";
import { makeSettings } from "#studio/play/settings.js";

const SETUP = "play"; // key for the set-up of the last run, in the browser's storage
// defaults for each robot of a fleet, if no suitable choice was made
const FLEET = { motion: "swept", controller: "naive" };
const WIDE = 15; // letters of a name that fill half a line

/**
 * @param {Studio} studio
 * @param {() => void} run
 * @param {HTMLElement} drive - Another button next to Run
 * @param {HTMLElement} more - Another setting, shown under the list of robots
 * @returns {any}
 */
export function makeRobots(studio, run, drive, more) {
  const state = {
    motion: "stepped",
    chosen: ["thesis-2"],
    own: [], // robots with their own options, NAME+option=value
    seed: 0,
    time_step: 0, // the default, once it is known
    steps: 20_000,
    options: {},
    still: false,
  };
  const parts = {};
  parts.run = runButton(run);
  parts.due = el("span", { class: "quiet due", id: "run-due", role: "status" });
  parts.others = el("p", { class: "quiet others", id: "other-controllers" });
  parts.list = el("div", { class: "robots", role: "group", "aria-label": "Controllers" }, el("span", { class: "quiet" }, "Loading …"));
  parts.another = anotherForm(
    (label) => askAbout(studio.connection, () => JSON.stringify(messageFor(robots)), "check", checkOf(robots, label)),
    (label) => addOwn(robots, label),
  );
  parts.motion = el("div", { class: "motion" });
  parts.numbers = el("div");
  parts.changes = changesField(() => letChange(robots));
  parts.settings = makeSettings(() => showDue(robots));
  const element = el(
    "div",
    { class: "setup" },
    el("div", { class: "line head" }, el("h2", {}, "Robots"), parts.due, el("div", { class: "tools" }, drive, parts.run)),
    parts.motion,
    parts.list,
    more,
    parts.others,
    parts.another.element,
    parts.numbers,
    parts.changes.element,
    parts.settings.element,
  );
  /** @type {any} */
  const robots = { studio, state, parts, element, run, offered: null, ran: null, lent: null };
  element.addEventListener("change", ({ target }) => {
    if (isField(target) && target.type === "number") isGood(target);
    showDue(robots);
  });
  return {
    element,
    running: (message) => {
      robots.ran = JSON.stringify(message);
      showDue(robots);
    },
    refresh: () => refresh(robots),
    good: (leads) => isAllGood(robots, leads),
    settings: (heading) => parts.settings.open(heading),
    message: () => messageFor(robots),
    own: () => state.own,
    prefer: (failure) => prefer(robots, failure),
    forget: () => forget(robots),
    follow: (wanted, more) => follow(robots, wanted, more),
  };
}

// Returns whether all numbers are valid; if `leads` is true, moves the focus to the first invalid
// one.
function isAllGood({ element, parts }, leads) {
  const wrong = [...element.querySelectorAll("input[type=number]")].filter((input) => !isGood(input));
  if (wrong.length === 0) return true;
  if (!leads) return false;
  const heading = parts.settings.headingOf(wrong[0]);
  if (heading) parts.settings.open(heading);
  wrong[0].focus();
  return false;
}

// Makes the checkbox for a world that changes during runs; it adds events to a world without any.
function changesField(change) {
  const box = el("input", { type: "checkbox", id: "changes", onchange: change });
  const words = el("span");
  const fault = el("p", { class: "bad", role: "alert" });
  const element = el("div", { class: "changes" }, el("label", { class: "check" }, box, words), fault);
  return { element, box, words, fault };
}

function showChanges({ studio, state, parts: { changes } }) {
  const { events } = studio.model.world;
  changes.box.checked = events !== null && !state.still;
  changes.words.textContent = events ? `The world changes (${plural(events.times.length, "change")})` : "Let walls change places";
  changes.fault.textContent = "";
}

async function letChange(robots) {
  const { studio, state, parts } = robots,
    { model } = studio;
  const on = parts.changes.box.checked;
  state.still = model.world.events !== null && !on;
  if (!on || model.world.events) return;
  const about = () => `${model.version} ${parts.changes.box.checked}`;
  try {
    const world = await askAbout(studio.connection, about, "shift", { world: messageOf(model.world), seed: String(state.seed) });
    model.change("walls that change places", { events: world.events });
    showChanges(robots);
    robots.run();
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    showChanges(robots);
    if (error instanceof Refused) parts.changes.fault.textContent = error.message;
  }
}

// Makes the form for a robot with its own options, written as on the command line.
//   check    asks whether it may run, and fails with the reason
function anotherForm(check, add) {
  const input = el("input", { type: "text", id: "another", autocomplete: "off", spellcheck: false });
  const tell = (fault) => {
    input.setCustomValidity(fault);
    isGood(input);
  };
  input.addEventListener("input", () => tell(""));
  const send = async (event) => {
    event.preventDefault();
    const label = input.value.trim();
    if (!label) return;
    try {
      await check(label);
    } catch (error) {
      if (!(error instanceof Refused || error instanceof Ended)) throw error;
      if (input.value.trim() === label) tell(error.message);
      return;
    }
    add(label);
    if (input.value.trim() === label) input.value = "";
    input.focus();
  };
  const element = el(
    "form",
    { class: "another", novalidate: true, onsubmit: send },
    labelled("Another robot, with options", input, { help: "NAME+option=value, as on the command line" }),
    el("button", { type: "submit" }, "Add"),
  );
  const change = (label) => {
    input.value = label;
    tell("");
    input.focus();
  };
  return { element, change, example: (label) => (input.placeholder = label) };
}

function addOwn(robots, label) {
  const { state } = robots;
  if (!state.own.includes(label) && !offeredTo(robots).some(({ name }) => name === label)) state.own.push(label);
  if (!state.chosen.includes(label) && state.chosen.length < robots.studio.limits.robots) state.chosen.push(label);
  showList(robots);
}

// Shows that the chosen settings differ from those of the shown runs, and keeps them for a reload;
// nothing runs until the user presses Run.
function showDue(robots) {
  if (!robots.lent && robots.offered) keepSetup(robots);
  robots.studio.showLink();
  robots.studio.play?.changed();
  const due = robots.ran !== null && robots.ran !== JSON.stringify(messageFor(robots)) && robots.state.chosen.length > 0;
  robots.parts.due.textContent = due ? "Not run yet." : "";
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
  const { studio } = robots;
  if (!studio.offered) return;
  showChanges(robots);
  if (robots.offered !== studio.offered) takeOffered(robots);
  suitFleet(robots);
}

// The thesis's model runs one robot. In a world with several, another model is chosen,
// with robots that drive to their targets.
function suitFleet(robots) {
  const { studio, state } = robots;
  if (robotsIn(studio.model.world) < 2 || !motionOf(robots).thesis) return;
  state.chosen = [FLEET.controller];
  setMotion(robots, FLEET.motion);
}

function takeOffered(robots) {
  const { studio, state, parts } = robots;
  const before = robots.offered;
  // the studio was restarted and offers something else, or code was edited
  const again = before !== null;
  robots.offered = studio.offered;
  if (!again) Object.assign(state, { time_step: studio.offered.time_step }, setupIn(studio.folder, studio.offered));
  else followMended(robots, before);
  if (!motionOf(robots)) Object.assign(state, { motion: studio.offered.motions[0].name, options: {} });
  parts.motionList = motionField(studio.offered.motions, state.motion, (name) => setMotion(robots, name));
  parts.motion.replaceChildren(parts.motionList.element);
  showMotion(robots);
  if (!again) showNumbers(robots);
}

// Chooses the motion model of a chosen controller that could not be loaded before, and can be now.
function followMended({ state, studio }, before) {
  const broken = new Set(before.controllers.filter(({ fault }) => fault).map(({ name }) => name));
  const mended = studio.offered.controllers.find(({ name, fault }) => !fault && broken.has(name) && state.chosen.includes(name));
  if (mended && mended.motion !== state.motion) Object.assign(state, { motion: mended.motion, options: {} });
}

const namedIn = ({ controllers }) => controllers.filter(({ named }) => named).map(({ name }) => name);

function keepSetup({ studio, state }) {
  keep(studio.folder, SETUP, { ...state, named: namedIn(studio.offered) });
  keepInTab(studio.folder, SETUP, { ...state, named: namedIn(studio.offered) });
}

// Returns the set-up of the last run in this folder; without one, or if other controllers were
// named at the start, the first of those.
function setupIn(folder, offered) {
  const { named, ...kept } = keptInTab(folder, SETUP) ?? keptOf(folder, SETUP) ?? {};
  if (String(named ?? "-") === String(namedIn(offered)) && offered.motions.some(({ name }) => name === kept.motion)) return kept;
  const first = offered.controllers.find(({ named }) => named);
  return first ? { chosen: [first.name], motion: first.motion } : {};
}

function motionOf({ studio, state }) {
  return studio.offered.motions.find(({ name }) => name === state.motion);
}

function offeredTo(robots) {
  const { thesis } = motionOf(robots);
  return robots.studio.offered.controllers.filter((one) => isRunnable(one) && (thesis ? one.thesis : one.lattice));
}

// A user's controller that cannot be loaded stays in the list, because its run shows where the code
// fails.
const isRunnable = ({ named, fault }) => named || !fault;

function setMotion(robots, name) {
  const { state } = robots;
  state.motion = name;
  state.options = {};
  showMotion(robots);
}

// Shows the robots and options of the motion model; robots
// that it does not support are no longer chosen.
function showMotion(robots) {
  const { state, parts } = robots;
  const names = [...offeredTo(robots).map((one) => one.name), ...state.own];
  state.chosen = state.chosen.filter((one) => names.includes(one));
  if (state.chosen.length === 0) state.chosen = [names[0]];
  parts.motionList.show(state.motion);
  parts.another.example(motionOf(robots).thesis ? "thesis-1+repaired" : "turn-right+slip=0.1");
  showList(robots);
  showOptions(robots);
}

// Under the thesis's own model, lists a robot that has two names only once, unless both are chosen.
function listed(robots) {
  const { state } = robots,
    all = offeredTo(robots);
  if (!motionOf(robots).thesis) return all;
  const doubled = ({ name, also }) =>
    also !== "" && !state.chosen.includes(name) && all.some((one) => one.name === also) && (state.chosen.includes(also) || also < name);
  return all.filter((one) => !doubled(one));
}

function showList(robots) {
  const { state, parts } = robots,
    { thesis } = motionOf(robots);
  const one = ({ name, also }) =>
    el(
      "label",
      { class: shortName(name).length + (thesis ? also.length : 0) > WIDE ? "check wide" : "check", title: shortName(name) === name ? null : name },
      el("input", {
        type: "checkbox",
        value: name,
        checked: state.chosen.includes(name),
        disabled: !state.chosen.includes(name) && state.chosen.length >= robots.studio.limits.robots,
        onchange: (event) => toggle(robots, name, event.target.checked),
      }),
      el("span", {}, breakable(thesis && also ? `${name} (${also})` : shortName(name))),
    );
  const own = (name) =>
    el(
      "div",
      { class: "own" },
      one({ name, also: "" }),
      el("button", { type: "button", class: "small", "aria-label": `Change ${name}`, title: "Change its options", onclick: () => changeOwn(robots, name) }, "Change"),
    );
  parts.list.replaceChildren(...listed(robots).map(one), ...state.own.map(own));
  parts.run.disabled = state.chosen.length === 0;
  parts.others.replaceChildren(...othersOf(robots).map((words) => el("span", {}, words)));
  showDue(robots);
}

// Moves the text of a user's robot back to the field where it was typed.
function changeOwn(robots, name) {
  const { state, parts } = robots;
  state.own = state.own.filter((one) => one !== name);
  state.chosen = state.chosen.filter((one) => one !== name);
  showList(robots);
  parts.another.change(name);
}

// Describes the controllers that are not in the list.
function othersOf(robots) {
  const { controllers } = robots.studio.offered;
  const here = offeredTo(robots).map(({ name }) => name);
  const away = controllers.filter((one) => isRunnable(one) && !here.includes(one.name));
  const own = away.filter(({ named }) => named).map(({ name }) => name);
  const more = own.length > 0 ? `, including ${own.join(", ")}` : "";
  return [
    ...(away.length > 0 ? [...breakable(`${away.length} more under ${away[0].motion}${more}. `)] : []),
  ];
}

function toggle(robots, name, on) {
  const { state } = robots;
  state.chosen = state.chosen.filter((one) => one !== name);
  if (on) state.chosen.push(name);
  showList(robots);
  robots.parts.list.querySelector(`input[value="${CSS.escape(name)}"]`)?.focus();
}

function showNumbers(robots) {
  const { state, parts } = robots;
  const { steps, time_steps: [low, high] } = robots.studio.limits;
  parts.seed = number(state.seed, (value) => (state.seed = Math.round(value)), { low: 0, high: Number.MAX_SAFE_INTEGER, step: 1 });
  parts.step = number(state.time_step, (value) => (state.time_step = value), { low, high });
  for (const input of [parts.seed, parts.step]) Object.assign(input, { required: true, title: "Enter a number." });
  parts.steps = el("input", {
    type: "number",
    value: state.steps,
    min: 1,
    max: steps,
    step: 1,
    placeholder: "auto",
    onchange: (event) => (state.steps = event.target.value),
  });
  parts.numbers.replaceChildren(
    el(
      "div",
      { class: "triple" },
      labelled("Time step", parts.step, { unit: "s" }),
      labelled("Steps", parts.steps),
      labelled("Seed", parts.seed),
    ),
  );
}

function showOptions(robots) {
  robots.parts.settings.offer(motionOf(robots).options, robots.state.options);
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

function checkOf(robots, controller) {
  const { controllers: _, ...settings } = messageFor(robots);
  return { ...settings, controller };
}

// Takes over controller and settings of a failure whose file was opened.
function prefer(robots, failure) {
  const { state, studio } = robots;
  refresh(robots);
  if (!studio.offered || !studio.offered.controllers.some(({ name }) => name === failure.controller)) return;
  forget(robots);
  const { steps, time_step: timeStep, ...options } = failure.parameters;
  const before = { seed: state.seed, steps: state.steps };
  state.chosen = [failure.controller];
  setMotion(robots, failure.motion);
  Object.assign(state, { still: false, seed: failure.seed, time_step: timeStep ?? studio.offered.time_step, steps: steps ?? "", options });
  robots.lent = { seed: state.seed, steps: state.steps, before };
  showNumbers(robots);
  showOptions(robots);
  showChanges(robots);
}

// Takes the robots, the motion model, the seed and other settings from a link; returns sentences
// about the robots that it leaves out.
function follow(robots, { robots: names, motion, seed }, more) {
  const { state, studio } = robots;
  refresh(robots);
  if (!studio.offered || names.length === 0) return [];
  forget(robots);
  if (motion !== state.motion && studio.offered.motions.some(({ name }) => name === motion)) setMotion(robots, motion);
  const offered = offeredTo(robots).map(({ name }) => name);
  const unknown = names.filter((name) => !isOfferedAs(name, offered));
  const all = names.filter((name) => !unknown.includes(name));
  const known = all.slice(0, studio.limits.robots);
  if (known.length > 0) state.chosen = known;
  for (const name of known) if (![...offered, ...state.own].includes(name)) state.own.push(name);
  if (Number.isSafeInteger(seed) && seed >= 0) state.seed = seed;
  if (more.options) Object.assign(state, { time_step: more.time_step, steps: more.steps ?? "", options: { ...more.options }, still: false });
  showNumbers(robots);
  showOptions(robots);
  showList(robots);
  return [
    ...(unknown.length > 0 ? [`This studio cannot run ${unknown.map(shortName).join(", ")} from the link. Start it with --controller, or choose another robot.`] : []),
    ...(all.length > known.length ? [`At most ${plural(known.length, "robot")} can run at once, so only ${known.length} of the link's ${all.length} will.`] : []),
  ];
}

// Drops the failure's seed and steps when another world is opened,
// unless the user has changed them.
function forget(robots) {
  const { state, lent } = robots;
  robots.lent = null;
  if (!lent || state.seed !== lent.seed || state.steps !== lent.steps) return;
  Object.assign(state, lent.before);
  showNumbers(robots);
}
