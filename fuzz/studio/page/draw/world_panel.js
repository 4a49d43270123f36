// The world panel: size, robot, start and target, and the widest robot that passes.

import { askAbout } from "#studio/shared/asking.js";
import { el } from "#player/dom.js";
import { Ended } from "#studio/shared/connection.js";
import { isGood, labelled, number, words } from "#studio/shared/fields.js";
import { round } from "#player/edit/model.js";
import { kindOf } from "#player/edit/drawn_world.js";
import { radiusSlider } from "#player/edit/radius.js";
import { goalPart } from "#studio/draw/goal_form.js";
import { messageOf } from "#studio/shared/world_message.js";
import { LOOKING, isWidestByHand } from "#studio/draw/proof.js";
import { Refused } from "#studio/shared/refusals.js";
import { sizePart } from "#studio/draw/size_form.js";

const TURN = { low: -360, high: 360 }; // degrees

/**
 * @param {Studio} studio
 * @param {any} draw
 * @returns {any}
 */
export function makeWorldPanel(studio, draw) {
  const { model } = studio,
    parts = { lengths: [] },
    goal = goalPart(studio),
    hard = hardPart(studio);
  const element = el(
    "div",
    {},
    el("h2", {}, "Robot"),
    (parts.disc = radiusPart(studio, parts)),
    speedPart(studio, parts),
    el("h2", {}, "Start and target"),
    placePart(studio, parts),
    goal.element,
    el("h2", {}, "Size"),
    sizePart(studio, draw, parts),
    hard.element,
  );
  return {
    element,
    refresh: () => {
      if (studio.limits) setBounds(studio.limits, parts);
      refresh(model.world, parts);
      showWidest(studio, parts);
      goal.refresh();
      hard.forget();
    },
  };
}

function radiusPart(studio, parts) {
  const { model } = studio;
  const change = (value) => model.change("radius", { robot_radius: round(value) }, true);
  const slider = radiusSlider(() => model, { id: "radius", "aria-describedby": "widest" });
  parts.radius = slider.input;
  parts.showRadius = slider.refresh;
  parts.radiusNumber = lengthField(studio, parts, change);
  parts.widest = el("p", { class: "quiet widest", id: "widest" });
  parts.find = el("button", { type: "button", id: "find-widest", onclick: () => studio.askWidest() }, "Find the widest robot that passes");
  parts.closes = el("i", { class: "closes", title: "The widest robot that passes" });
  return el(
    "div",
    {},
    labelled("Radius", parts.radiusNumber, { unit: "m" }),
    el("div", { class: "radius" }, parts.radius, parts.closes),
    parts.widest,
    parts.find,
  );
}

function speedPart(studio, parts) {
  const { model } = studio;
  parts.speed = lengthField(studio, parts, (value) => model.change("speed", { robot_speed: value }));
  parts.cell = lengthField(studio, parts, (value) => model.change("cell size", scaled(model.world, value)));
  return el(
    "div",
    { class: "pair-fields" },
    labelled("Top speed", parts.speed, { unit: "m/s" }),
    labelled("Cell size", parts.cell, { unit: "m" }),
  );
}

/**
 * The contents of a field: a number of the world, and the drawing that it belongs to.
 * @type {WeakMap<HTMLInputElement, {value: number, sheet: symbol}>}
 */
const shown = new WeakMap();

// Makes a field that changes the world if its number is within bounds;
// otherwise the field shows the bounds.
function bounded(change, bounds) {
  const input = number(0, (value) => isGood(input) && change(value), bounds);
  input.addEventListener("blur", () => {
    if (input.value !== "") return;
    input.value = String(shown.get(input)?.value ?? ""); // it was empty or not a number
    isGood(input);
  });
  return input;
}

// Makes a field for a length, m, or a speed, m/s; it has no effect until the server has sent the
// bounds.
function lengthField(studio, parts, change) {
  const input = bounded((value) => studio.limits && change(value), {});
  parts.lengths.push(input);
  return input;
}

/**
 * Gives the fields the bounds that the server has sent.
 * @param {Limits} limits
 * @param {Record<string, any>} parts
 */
function setBounds({ lengths, side }, parts) {
  for (const input of parts.lengths) [input.min, input.max] = lengths;
  parts.width.max = parts.height.max = side;
}

// Shows a value of the world in a field, unless the user is typing there,
// or has typed an invalid one for this drawing.
function show(input, value, { sheet }) {
  const before = shown.get(input);
  const wrong = input.hasAttribute("aria-invalid") && before?.value === value && before?.sheet === sheet;
  shown.set(input, { value, sheet });
  if (document.activeElement === input || wrong) return;
  input.value = value;
  isGood(input);
}

// Returns the same drawing with another cell size: places stay in their cells, and the robot keeps
// its size in cells.
function scaled(world, cell) {
  const share = cell / world.cell_size;
  const [x, y, heading] = world.start;
  return {
    cell_size: cell,
    robot_radius: round(world.robot_radius * share),
    start: [round(x * share), round(y * share), heading],
    target: world.target.map((value) => round(value * share)),
  };
}

function placePart(studio, parts) {
  const { model } = studio;
  const set = (name, k) => (value) => {
    const values = [...model.world[name]];
    values[k] = name === "start" && k === 2 ? round((value * Math.PI) / 180) : value;
    model.change(name, { [name]: values });
  };
  const places = (name) => [0, 1].map((k) => bounded(set(name, k), { low: 0 }));
  parts.start = [...places("start"), bounded(set("start", 2), TURN)];
  parts.target = [...places("target"), lengthField(studio, parts, set("target", 2))];
  const row = (title, inputs, third) =>
    el(
      "fieldset",
      { class: "triple" },
      el("legend", {}, title),
      labelled("x", inputs[0], { unit: "m" }),
      labelled("y", inputs[1], { unit: "m" }),
      third(inputs[2]),
    );
  return el(
    "div",
    {},
    row("Start", parts.start, (input) => labelled("Heading", input, { unit: "°" })),
    row("Target", parts.target, (input) => labelled("Radius", input, { unit: "m" })),
  );
}

// Makes the section that measures the world's difficulty, on request only, because that may take a
// while.
function hardPart(studio) {
  const found = el("div", { role: "status" });
  let measured = studio.model.version;
  const ask = async () => {
    measured = studio.model.version;
    found.replaceChildren(el("p", { class: "quiet" }, "Measuring …"));
    try {
      const metrics = await askAbout(studio.connection, () => studio.model.version, "measure", { world: messageOf(studio.model.world) });
      const row = ({ name, value, unit, meaning }) =>
        el(
          "tr",
          { title: meaning },
          el("th", { scope: "row" }, words(name)),
          el("td", {}, `${Number(value.toPrecision(4))} ${unit}`),
        );
      found.replaceChildren(el("table", { class: "numbers" }, el("tbody", {}, metrics.map(row))));
    } catch (error) {
      if (!(error instanceof Refused || error instanceof Ended)) throw error;
      found.replaceChildren(el("p", { class: error instanceof Refused ? "bad" : "quiet" }, error.message));
    }
  };
  const element = el(
    "div",
    {},
    el(
      "div",
      { class: "line hard" },
      el("h2", {}, "How hard it is"),
      el("button", { type: "button", id: "measure", onclick: ask }, "Measure"),
    ),
    found,
  );
  const forget = () => {
    // the result is for another world
    if (measured !== studio.model.version) found.replaceChildren();
  };
  return { element, forget };
}

function refresh(world, parts) {
  for (const [x, y] of [parts.start, parts.target]) {
    x.max = round(world.width * world.cell_size);
    y.max = round(world.height * world.cell_size);
  }
  parts.disc.hidden = Boolean(kindOf(world).footprint); // a body has no radius to set
  parts.showRadius();
  show(parts.radiusNumber, world.robot_radius, world);
  show(parts.speed, world.robot_speed, world);
  show(parts.cell, world.cell_size, world);
  parts.start.forEach((input, k) =>
    show(input, k < 2 ? world.start[k] : Number(((world.start[2] * 180) / Math.PI).toFixed(4)), world),
  );
  parts.target.forEach((input, k) => show(input, world.target[k], world));
  showSize(world, parts);
}

// Shows the size if it has changed; what the user types for the next size stays until then.
function showSize({ width, height }, parts) {
  if (parts.shown === `${width} x ${height}`) return;
  parts.shown = `${width} x ${height}`;
  [parts.width.value, parts.height.value] = [width, height];
}

function showWidest({ widest, model, say }, parts) {
  const most = Number(parts.radius.max),
    known = typeof widest === "number";
  parts.closes.hidden = !known || widest > most;
  if (!parts.closes.hidden) parts.closes.style.left = `${(100 * widest) / most}%`;
  const found = known && parts.find.disabled; // the search on request has ended
  if (found && parts.focused && [null, document.body, parts.find].includes(document.activeElement)) parts.radius.focus();
  if (widest === LOOKING && !parts.find.disabled) parts.focused = document.activeElement === parts.find;
  parts.find.hidden = known || !isWidestByHand(model.world);
  parts.find.disabled = widest === LOOKING;
  parts.widest.textContent = widestWords(widest, model.world);
  if (found) say(parts.widest.textContent);
}

function widestWords(widest, world) {
  if (world.events) return "The world changes, so the widest robot that passes is not known.";
  if (widest === LOOKING) return "Searching for the widest robot that passes …";
  if (widest === null) return isWidestByHand(world) ? "In a large world this takes up to a minute." : "…";
  if (widest === 0) return "No robot can pass, however small.";
  return `Robots with a radius of up to ${widest.toPrecision(4)} m can pass.`;
}
