// The generator: a family, its parameters, and a seed.

import { choice, el } from "#player/dom.js";
import { makeFamilies } from "#studio/draw/families.js";
import { Ended } from "#studio/shared/connection.js";
import { faultOf, firstFault, isField, labelled, parameterField, rangeWords, words } from "#studio/shared/fields.js";
import { Refused } from "#studio/shared/refusals.js";

/**
 * @param {Studio} studio
 * @returns {{element: HTMLElement, redraw: () => void, refresh: () => void}}
 */
export function makeMaker(studio) {
  const state = { family: null, given: {} };
  const parts = { fields: el("div"), about: el("p", { class: "quiet" }), said: el("p", { role: "status" }) };
  parts.seed = el("input", { type: "text", inputmode: "numeric", value: "1", id: "maker-seed", pattern: "[0-9]+" });
  const family = el("div", { id: "maker-family" });
  parts.gallery = makeFamilies(studio, (name) => {
    parts.list.value = name;
    chooseFamily(studio, state, parts, name);
  });
  const element = el(
    "div",
    {},
    family,
    parts.about,
    seedPart(studio, state, parts),
    parts.said,
    constraintPart(parts),
    parts.fields,
  );
  element.addEventListener("keydown", (event) => {
    // after the field has taken the typed value
    if (event.key === "Enter" && isField(event.target)) setTimeout(() => generate(studio, state, parts));
  });
  return {
    element,
    redraw: () => parts.gallery.redraw(),
    refresh: () => {
      if (state.family || !studio.offered) return;
      const names = studio.offered.families.map(({ name }) => [name, name]);
      const list = choice(names, "maze", (event) => chooseFamily(studio, state, parts, event.target.value));
      parts.list = list;
      parts.gallery.offer();
      family.replaceChildren(parts.gallery.element, labelled("Family", list));
      chooseFamily(studio, state, parts, "maze");
    },
  };
}

function seedPart(studio, state, parts) {
  const make = () => generate(studio, state, parts);
  parts.make = el("button", { type: "button", class: "main", onclick: make }, "Generate");
  const roll = () => {
    parts.seed.value = String((BigInt(parts.seed.value.replace(/\D/g, "") || "0") + 1n) % (BigInt(studio.limits.seed) + 1n));
    make();
  };
  return el(
    "div",
    { class: "seed" },
    labelled("Seed", parts.seed),
    parts.make,
    el("button", { type: "button", title: "The next seed", onclick: roll }, "Next seed"),
  );
}

// The part of the form for searching for a world.
function constraintPart(parts) {
  parts.difficulty = el("input", { type: "number", min: 0, max: 1, step: 0.05, placeholder: "any" });
  parts.where = el("input", { type: "text", placeholder: "detour > 3 and bottleneck < 1.2r", spellcheck: "false" });
  return el(
    "details",
    {},
    el("summary", {}, "Search for a world with a given difficulty"),
    labelled("Difficulty, 0 to 1", parts.difficulty),
    labelled("Condition", parts.where, { help: "Metrics have the names shown under World, How hard it is." }),
  );
}

function chooseFamily(studio, state, parts, name) {
  state.family = studio.offered.families.find((family) => family.name === name);
  state.given = {};
  parts.about.textContent = state.family.about;
  parts.difficulty.disabled = state.family.changes;
  if (state.family.changes) parts.difficulty.value = ""; // worlds with events have no difficulty
  parts.difficulty.placeholder = state.family.changes ? "none: its worlds have events" : "any";
  const field = (parameter) => {
    const input = parameterField(parameter, parameter.default, (value) => {
      state.given[parameter.name] = value;
      showEffective(state, parts);
    });
    const range = rangeWords(parameter).replace(/^./, (letter) => letter.toUpperCase());
    const help = [parameter.help, range && parameter.kind !== "bool" && parameter.choices.length === 0 ? `${range}.` : ""].join(" ").trim();
    const element = labelled(words(parameter.name), input, { help });
    parts.made.set(parameter.name, { parameter, input, element });
    return element;
  };
  parts.made = new Map();
  const isOfRobot = (parameter) => Object.hasOwn(studio.usual, parameter.name);
  const own = state.family.parameters.filter((parameter) => !isOfRobot(parameter));
  const robot = state.family.parameters.filter((parameter) => isOfRobot(parameter));
  parts.fields.replaceChildren(
    ...own.map(field),
    robot.length > 0 ? el("details", {}, el("summary", {}, "Cells and robot"), robot.map(field)) : "",
  );
  showEffective(state, parts);
  parts.gallery.choose(name);
}

// Shows only parameters that have an effect with the chosen algorithm or shape;
// the others are not sent.
function showEffective(state, parts) {
  for (const [name, { parameter, element }] of parts.made) {
    const { idle } = parameter;
    const other = idle && parts.made.get(idle.by);
    const hidden = Boolean(other && idle.values.includes(String(state.given[idle.by] ?? other.parameter.default)));
    element.hidden = hidden;
    if (hidden) delete state.given[name];
  }
}

// Returns the first invalid field and what is wrong with it; null if all are valid.
function wrongIn(studio, parts) {
  const bad = firstFault(parts.fields);
  if (bad) return [bad, faultOf(bad)];
  const seed = parts.seed.value.trim();
  const most = BigInt(studio.limits.seed);
  if (!/^[0-9]{1,40}$/.test(seed) || BigInt(seed) > most)
    return [parts.seed, `The seed must be a whole number from 0 to ${most}.`];
  if (!parts.difficulty.validity.valid && !parts.difficulty.validity.stepMismatch)
    return [parts.difficulty, "The difficulty must be a number from 0 to 1; leave it empty for any."];
  return null;
}

async function generate(studio, state, parts) {
  const fault = wrongIn(studio, parts);
  if (fault) {
    parts.said.className = "bad";
    parts.said.textContent = fault[1];
    const within = fault[0].closest("details");
    if (within) within.open = true;
    fault[0].focus();
    return;
  }
  parts.said.className = "quiet";
  parts.said.textContent = "…";
  const message = { family: state.family.name, seed: parts.seed.value.trim(), parameters: { ...state.given } };
  if (parts.difficulty.value !== "") message.difficulty = parts.difficulty.valueAsNumber;
  if (parts.where.value.trim() !== "") message.where = parts.where.value.trim();
  const progress = ({ done, of }) => {
    parts.said.textContent = `Searching: world ${done} of at most ${of}`;
  };
  try {
    const answer = await studio.generate(message, `${state.family.name} ${message.seed}`, progress);
    parts.said.textContent = `Generated by ${answer.made}.`;
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    parts.said.className = error instanceof Refused ? "bad" : "quiet";
    parts.said.textContent = error.message;
  }
}
