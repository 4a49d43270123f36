// The page that compares several controllers over several worlds, as `worldgen compare` does.

import { askToOpen } from "#studio/shared/asking.js";
import { breakable, el, grouped, plural, say, shortName } from "#player/dom.js";
import { makeTable } from "#studio/compare/table.js";
import { sourcesOf, worldsOf } from "#studio/compare/worlds.js";
import { messageOf } from "#studio/shared/world_message.js";
import { Ended } from "#studio/shared/connection.js";
import { fileWords, isSame, noteCode, noteReported, runsOneOf, stampOf } from "#studio/shared/edits.js";
import { isGood, labelled, motionField, number } from "#studio/shared/fields.js";
import { keep, keptOf } from "#studio/shared/kept.js";
import { isOfferedAs, joinNames, splitNames } from "#studio/shared/links.js";
import { Refused } from "#studio/shared/refusals.js";

const KEPT = "compare"; // key for the choices, in the browser's storage
const USUAL = { chosen: ["turn-right", "bug2", "vfh"], sources: ["examples"], seeds: 20 };

const EMPTY = "Choose robots and worlds, then press Compare.";

/**
 * Makes the page.
 * @param {HTMLElement} section
 * @param {Studio} studio
 * @returns {any}
 */
export function makeCompare(section, studio) {
  /** @type {any} */
  const compare = { studio, state: { ...USUAL, motion: "" }, folder: null, offered: null, files: [], running: null, asked: null, shown: null, wanted: null, isFault: false };
  const parts = {
    said: el("p", { class: "said quiet", role: "status", id: "compare-said" }, EMPTY),
    form: el("form", { id: "compare-form", class: "panel", novalidate: true, onsubmit: (event) => (event.preventDefault(), run(compare)) }, el("p", { class: "quiet" }, "Loading the choices …")),
    run: el("button", { type: "submit", class: "main", id: "run-compare" }, "Compare"),
    stop: el("button", { type: "button", id: "stop-compare", hidden: true, onclick: () => compare.running?.stop() }, "Stop"),
  };
  const table = makeTable((row, column) => open(compare, row, column));
  Object.assign(compare, { parts, table });
  section.replaceChildren(
    el("div", { class: "middle" }, el("div", { class: "line" }, parts.said, parts.stop), table.element),
    el("div", { class: "side" }, parts.form),
  );
  return {
    begin: () => begin(compare),
    refresh: () => refresh(compare),
    edited: (files) => edited(compare, files),
    changed: () => studio.page() === "compare" && showStale(compare),
    link: () => linkOf(compare.state),
    follow: (shows) => follow(compare, shows),
  };
}

// Returns what a link to the table names.
function linkOf({ chosen, motion, sources }) {
  return { robots: joinNames(chosen), motion, worlds: joinNames(sources) };
}

// Takes the robots, the motion model and the worlds that a link names, and compares them.
async function follow(compare, { robots, motion, worlds }) {
  refresh(compare);
  if (!robots || !worlds || !compare.offered) return;
  const { state, studio } = compare;
  const isKnown = studio.offered?.motions.some(({ name }) => name === motion);
  Object.assign(state, { chosen: splitNames(robots), sources: splitNames(worlds), motion: isKnown ? motion : state.motion });
  await list(compare);
  build(compare);
  run(compare);
}

async function begin(compare) {
  refresh(compare);
  if (!compare.offered) return;
  showRobots(compare); // with those added on Play in the meantime
  await list(compare);
  showWorlds(compare);
  showStale(compare);
}

// Returns the worlds that are chosen, and how many of them can be compared.
function chosenWorlds({ studio, state, files }, open) {
  const sources = sourcesOf(files).map(([key]) => key).filter((key) => state.sources.includes(key));
  const all = worldsOf(sources, files, open);
  return { all, worlds: all.slice(0, studio.limits?.compared_worlds) };
}

// Returns the settings of a comparison: Play's, so that a click on a cell plays this very run.
function setupOf({ studio, state }) {
  const { time_step, seed, steps, options, motion } = studio.play.setup();
  return { motion: state.motion, time_step, seed, steps, options: motion === state.motion ? options : {} };
}

// Returns what a table that is asked for now depends on.
function now(compare) {
  const { studio, state } = compare;
  const { worlds } = chosenWorlds(compare, { name: "", world: /** @type {any} */ (studio.model.digest) });
  return stampOf(studio, { ...setupOf(compare), controllers: state.chosen, seeds: state.seeds, worlds }, "");
}

// Greys the table unless it is about the worlds, the settings and the code on the screen.
function showStale(compare) {
  const { table, shown } = compare;
  const current = now(compare);
  noteReported(shown, current);
  table.element.classList.toggle("stale", shown !== null && !isSame(shown, current));
}

async function list(compare) {
  try {
    const files = await compare.studio.connection.ask("files");
    compare.files = files;
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    tell(compare, error.message, error instanceof Refused);
  }
}

function refresh(compare) {
  const { studio, state } = compare;
  if (!studio.offered || compare.offered === studio.offered) return;
  if (compare.folder !== studio.folder) Object.assign(state, USUAL, { motion: studio.offered.motion }, firstOf(studio.offered), keptOf(studio.folder, KEPT));
  Object.assign(compare, { offered: studio.offered, folder: studio.folder });
  build(compare);
}

// Returns the robots to begin with: those that were named when the studio was started come first.
function firstOf({ controllers, motion: usual }) {
  const own = controllers.filter(({ named, fault }) => named && !fault);
  if (own.length === 0) return {};
  const [{ motion }] = own;
  return { motion, chosen: [...own.map(({ name }) => name), ...(motion === usual ? USUAL.chosen : [])].slice(0, 6) };
}

// Builds the form from the choices.
function build(compare) {
  const { parts, state, studio } = compare;
  parts.motion = motionField(compare.offered.motions, state.motion, (name) => {
    state.motion = name;
    showRobots(compare);
    showStale(compare);
  });
  parts.motion.show(state.motion);
  parts.robots = el("div", { class: "robots", role: "group", "aria-label": "Controllers to compare" });
  parts.worlds = el("div", { class: "sources", role: "group", "aria-label": "Worlds to compare in" });
  parts.seeds = number(state.seeds, (value) => ((state.seeds = Math.round(value)), showStale(compare)), { low: 1, high: studio.limits?.compared_seeds, step: 1 });
  parts.form.replaceChildren(
    el("div", { class: "line" }, el("h2", {}, "Compare"), parts.run),
    parts.motion.element,
    parts.robots,
    el("h2", {}, "Worlds"),
    parts.worlds,
    labelled("Runs per random robot", parts.seeds, { help: "For each robot that draws random numbers. Steps, seed and options are those of Play, where you add robots with options." }),
  );
  showRobots(compare);
  showWorlds(compare);
}

function offeredTo({ offered, state }) {
  const motion = offered.motions.find(({ name }) => name === state.motion);
  return offered.controllers.filter(({ named, fault, thesis, lattice }) => (named || !fault) && (motion?.thesis ? thesis : lattice));
}

// Lists the robots of the motion model, and chosen ones that have their own options.
function showRobots(compare) {
  const { parts, state } = compare;
  const names = offeredTo(compare).map(({ name }) => name);
  state.chosen = state.chosen.filter((one) => isOfferedAs(one, names));
  if (state.chosen.length === 0) state.chosen = names.slice(0, 3);
  const own = [...new Set([...compare.studio.play.own(), ...state.chosen])].filter((one) => !names.includes(one));
  const box = (name) =>
    el(
      "label",
      { class: "check", title: name },
      el("input", { type: "checkbox", value: name, checked: state.chosen.includes(name), onchange: ({ target }) => toggle(compare, "chosen", name, target.checked) }),
      el("span", {}, breakable(shortName(name))),
    );
  parts.robots.replaceChildren(...[...names, ...own].map(box));
}

function showWorlds(compare) {
  const { parts, state, files } = compare;
  if (!parts.worlds) return;
  const box = ([key, words]) =>
    el(
      "label",
      { class: "check" },
      el("input", { type: "checkbox", value: key, checked: state.sources.includes(key), onchange: ({ target }) => toggle(compare, "sources", key, target.checked) }),
      el("span", {}, words),
    );
  parts.worlds.replaceChildren(...sourcesOf(files).map(box));
}

function toggle(compare, what, name, on) {
  const { state } = compare;
  state[what] = state[what].filter((one) => one !== name);
  if (on) state[what].push(name);
  showStale(compare);
  if (compare.isFault) tell(compare, EMPTY); // the message no longer applies
}

function tell(compare, words, isBad = false) {
  const { parts } = compare;
  compare.isFault = isBad;
  parts.said.className = isBad ? "said bad" : "said quiet";
  parts.said.textContent = words;
}

// Compares the chosen robots and worlds; cells appear as they are finished.
async function run(compare) {
  const { studio, state, parts, table } = compare;
  if (!isGood(parts.seeds)) {
    parts.seeds.focus();
    return;
  }
  const { compared, compared_worlds: most } = studio.limits;
  const { all, worlds } = chosenWorlds(compare, { name: studio.model.world.name, world: messageOf(studio.model.world) });
  if (state.chosen.length === 0 || state.chosen.length > compared || worlds.length === 0) {
    tell(compare, worlds.length === 0 ? "No world is chosen: tick some under Worlds." : `Choose 1 to ${compared} controllers.`, true);
    return;
  }
  const setup = setupOf(compare);
  const asked = { ...setup, controllers: [...state.chosen], worlds, seeds: state.seeds };
  Object.assign(compare, { asked, setup, world: studio.model.digest, shown: now(compare) });
  const stamp = compare.shown;
  keep(studio.folder, KEPT, state);
  studio.showLink();
  table.begin(asked.controllers, worlds);
  showStale(compare);
  parts.stop.hidden = false;
  const count = asked.controllers.length * worlds.length;
  let done = 0;
  const take = (part, code) => {
    if (compare.asked !== asked) return;
    noteCode(stamp, code);
    table.take(part);
    showStale(compare);
    done += part.column !== undefined ? 1 : part.error ? asked.controllers.length : 0;
    tell(compare, `${grouped(done)} of ${plural(count, "cell")} …`);
  };
  tell(compare, "Preparing …");
  try {
    compare.running = studio.connection.ask("compare", { ...asked, worlds: worlds.map(({ name: _, ...one }) => one) }, take);
    const { totals, rows } = await compare.running;
    if (compare.asked !== asked) return;
    table.totals(totals, rows);
    const left = all.length > most ? ` Only the first ${most} of ${grouped(all.length)} worlds are compared.` : "";
    tell(compare, `${plural(worlds.length, "world")}, ${plural(asked.controllers.length, "controller")}. Click a result to play it.${left}`);
    say(parts.said.textContent);
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    if (compare.asked === asked) tell(compare, error.message, error instanceof Refused);
  } finally {
    if (compare.asked === asked) parts.stop.hidden = true;
  }
}

// Plays the run of a cell: its world on the board, its controller on Play.
async function open(compare, row, column) {
  const { studio, asked, setup, world: drawn } = compare;
  const world = asked.worlds[row];
  try {
    if (world.file) {
      if (studio.model.world.name !== world.file || studio.model.unsaved) studio.show(await askToOpen(studio.connection, "open", { name: world.file }), world.file, world.file);
    } else if (world.family) await studio.generate({ family: world.family, seed: world.seed ?? "1", parameters: {} }, `the example ${world.family}`);
    else if (studio.model.digest !== drawn) studio.show({ world: world.world }, "", "the world that was compared");
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    tell(compare, error.message, error instanceof Refused);
    return;
  }
  studio.play.follow({ ...setup, robots: joinNames([asked.controllers[column]]), seed: compare.table.seedOf(row, column) ?? setup.seed });
  studio.play.run(); // first, so that opening the page does not run it again
  studio.go("play");
}

// Reports that results come from the code before an edit.
function edited(compare, files) {
  const own = files.filter(({ controllers }) => (compare.asked?.controllers ?? []).some((robot) => runsOneOf(robot, controllers)));
  showStale(compare);
  if (own.length > 0) tell(compare, `${fileWords(own)} changed: press Compare again.`);
}
