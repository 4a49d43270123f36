// The panel of the world: its size, its robot, start and target, and how wide a robot passes.

import { el } from "/player/dom.js";
import { Ended, Refused } from "./connection.js";
import { labelled, number, words } from "./fields.js";
import { emptyWorld, messageOf, resized, round } from "./model.js";

const SMALLEST = 3; // cells a side
const LARGEST = 2000;

export function makeWorldPanel(studio, draw) {
  const { model } = studio,
    parts = { sizes: { width: 40, height: 40 } },
    hard = hardPart(studio);
  const element = el(
    "div",
    {},
    el("h2", {}, "Robot"),
    radiusPart(studio, parts),
    speedPart(studio, parts),
    el("h2", {}, "Start and target"),
    placePart(studio, parts),
    el("h2", {}, "Size"),
    sizePart(studio, draw, parts),
    hard.element,
  );
  return {
    element,
    refresh: () => {
      refresh(model.world, parts);
      showWidest(studio, parts);
      hard.forget();
    },
  };
}

function radiusPart({ model }, parts) {
  const change = (value) => model.change("radius", { robot_radius: round(value) }, true);
  parts.radius = el("input", {
    type: "range",
    step: "any",
    min: 0,
    id: "radius",
    "aria-label": "Robot radius",
    oninput: (event) => {
      const cell = model.world.cell_size;
      change(Math.max(cell / 100, Math.round((event.target.valueAsNumber / cell) * 100) * (cell / 100)));
    },
  });
  parts.radiusNumber = number(0, change, { low: 0 });
  parts.widest = el("p", { class: "quiet widest", id: "widest" });
  parts.closes = el("i", { class: "closes", title: "Here the way closes" });
  return el(
    "div",
    {},
    labelled("Radius", parts.radiusNumber, { unit: "m" }),
    el("div", { class: "radius" }, parts.radius, parts.closes),
    parts.widest,
  );
}

function speedPart({ model }, parts) {
  parts.speed = number(2, (value) => value > 0 && model.change("speed", { robot_speed: value }), { low: 0 });
  parts.cell = number(0.1, (value) => value > 0 && model.change("cell size", scaled(model.world, value)), { low: 0 });
  return el(
    "div",
    { class: "pair-fields" },
    labelled("Top speed", parts.speed, { unit: "m/s" }),
    labelled("Cell size", parts.cell, { unit: "m" }),
  );
}

// Other cells, the same drawing: places stay in their cells, and the robot is as large as it was, in cells.
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

function placePart({ model }, parts) {
  const set = (name, k) => (value) => {
    const values = [...model.world[name]];
    values[k] = name === "start" && k === 2 ? round((value * Math.PI) / 180) : value;
    model.change(name, { [name]: values });
  };
  const fields = (name) => (parts[name] = [0, 1, 2].map((k) => number(0, set(name, k))));
  const row = (title, inputs, third) =>
    el(
      "fieldset",
      { class: "triple" },
      el("legend", {}, title),
      labelled("x", inputs[0], { unit: "m" }),
      labelled("y", inputs[1], { unit: "m" }),
      labelled(...third(inputs[2])),
    );
  return el(
    "div",
    {},
    row("Start", fields("start"), (input) => ["Heading", input, { unit: "°" }]),
    row("Target", fields("target"), (input) => ["Radius", input, { unit: "m" }]),
  );
}

function sizePart({ model }, draw, parts) {
  const whole = (name) => number(40, (value) => (parts.sizes[name] = value), { low: SMALLEST, high: LARGEST, step: 1 });
  parts.width = whole("width");
  parts.height = whole("height");
  const sizes = () => {
    const [width, height] = [parts.width, parts.height].map((input) =>
      Math.min(LARGEST, Math.max(SMALLEST, Math.round(input.valueAsNumber || SMALLEST))),
    );
    draw.board.view = null;
    return [width, height];
  };
  const button = (words, help, act) => el("button", { type: "button", title: help, onclick: act }, words);
  return el(
    "div",
    {},
    el(
      "div",
      { class: "pair-fields" },
      labelled("Columns", parts.width, { unit: "cells" }),
      labelled("Rows", parts.height, { unit: "cells" }),
    ),
    el(
      "div",
      { class: "actions" },
      button("New", "An empty world of this size", () => {
        model.change("new world", emptyWorld(...sizes(), model.world));
      }),
      button("Resize", "Keep what is drawn, cut or add cells at the right and the top", () =>
        model.change("resize", resized(model.world, ...sizes())),
      ),
      button("Clear", "Take all walls away but the border", () => {
        const { cells } = emptyWorld(model.world.width, model.world.height);
        model.change("clear", { cells, events: null });
      }),
    ),
  );
}

// How hard the world is, by its metrics; asked for by hand, for it may take a while.
function hardPart(studio) {
  const found = el("div", { role: "status" });
  let measured = studio.model.version;
  const ask = async () => {
    found.replaceChildren(el("p", { class: "quiet" }, "Measuring …"));
    try {
      const { metrics } = await studio.connection.ask("measure", { world: messageOf(studio.model.world) });
      const row = ({ name, value, unit, meaning }) =>
        el(
          "tr",
          { title: meaning },
          el("th", { scope: "row" }, words(name)),
          el("td", {}, `${Number(value.toPrecision(4))} ${unit}`),
        );
      measured = studio.model.version;
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
    if (measured !== studio.model.version) found.replaceChildren(); // that was another world
  };
  return { element, forget };
}

function refresh(world, parts) {
  const show = (input, value) => {
    if (document.activeElement !== input) input.value = value;
  };
  parts.radius.max = Math.max(2.5 * world.cell_size, 1.2 * world.robot_radius);
  parts.radius.value = world.robot_radius;
  show(parts.radiusNumber, world.robot_radius);
  show(parts.speed, world.robot_speed);
  show(parts.cell, world.cell_size);
  parts.start.forEach((input, k) =>
    show(input, k < 2 ? world.start[k] : Number(((world.start[2] * 180) / Math.PI).toFixed(4))),
  );
  parts.target.forEach((input, k) => show(input, world.target[k]));
  show(parts.width, world.width);
  show(parts.height, world.height);
}

function showWidest(studio, parts) {
  const { widest, model } = studio,
    most = Number(parts.radius.max);
  parts.closes.hidden = widest === null || widest === undefined || widest > most;
  if (!parts.closes.hidden) parts.closes.style.left = `${(100 * widest) / most}%`;
  if (model.world.events) parts.widest.textContent = "The world changes: how wide a robot passes is not known.";
  else if (widest === null || widest === undefined) parts.widest.textContent = "…";
  else if (widest === 0) parts.widest.textContent = "No robot can pass, however small.";
  else parts.widest.textContent = `The way closes for a radius above ${widest.toPrecision(4)} m.`;
}
