// A controller's memory: named numbers, and its map at the displayed time.

import { numbersOf, opened, rowAt } from "#player/decode.js";
import { MARKS } from "#player/picture/marks.js";
import { stroke, strokeMark } from "#player/picture/pen.js";

function openMemory(memory) {
  return opened(memory, () => ({
    fields: memory.fields.map((field) => numbersOf(field.values)),
    map: memory.map && Object.fromEntries(MAP_COLUMNS.map((name) => [name, numbersOf(memory.map[name])])),
  }));
}

const MAP_COLUMNS = ["kind", "x0", "y0", "x1", "y1", "since", "until"];

/**
 * @param {DrawnRun | null} run
 * @returns {boolean}
 */
export function hasMap(run) {
  return Boolean(run && run.memory && run.memory.map);
}

/**
 * Returns pairs of a name and the value in memory, as text if the controller provides some.
 * @param {DrawnRun} run
 * @param {number} step
 * @returns {[string, string][]}
 */
export function memoryFacts(run, step) {
  const { memory } = run;
  if (!memory) return [];
  if (memory.fault) return [["memory", memory.fault]];
  const row = rowAt(run, step),
    columns = openMemory(memory).fields,
    { one, missing } = memory;
  return memory.fields.map(({ name, words, least }, k) => {
    const parts = columns[k][row];
    if (parts >= missing) return [name, "none"];
    const value = parts / one;
    return [name, words[value - least] || String(value)];
  });
}

// Returns the shapes at a step by the name of their kind, and shapes with a degree in order of
// degree, worst first.
function shapesAt(run, step) {
  const { kinds, degrees, names } = run.memory.map,
    { cell } = run.per;
  /** @type {any[][]} */
  const found = Array.from({ length: kinds.length + degrees }, () => []);
  const { kind, x0, y0, x1, y1, since, until } = openMemory(run.memory).map;
  for (let k = 0; k < kind.length && since[k] <= step; k += 1) {
    if (step >= until[k]) continue;
    const ends = [x0[k] / cell, y0[k] / cell];
    found[kind[k]].push(kinds[kind[k]] === "place" ? [...ends, names[x1[k]]] : [...ends, x1[k] / cell, y1[k] / cell]);
  }
  const named = Object.fromEntries(kinds.map((/** @type {string} */ name, k) => [name, found[k]]));
  return { named, degrees: found.slice(kinds.length) };
}

/**
 * Tints what the robot's map considers occupied or hard to drive on.
 * @param {Pen} pen
 * @param {DrawnRun} run
 * @param {number} step
 */
export function drawRemembered(pen, run, step) {
  if (!hasMap(run)) return;
  const { context, px, py, colours } = pen,
    { named: shapes, degrees } = shapesAt(run, step);
  context.save();
  context.fillStyle = colours[MARKS.remembered.colour];
  context.globalAlpha = 0.6 * MARKS.remembered.fill;
  for (const [x0, y0, x1, y1] of shapes.cell) context.fillRect(px(x0), py(y0), px(x1) - px(x0), py(y1) - py(y0));
  drawDegrees(pen, degrees);
  context.restore();
}

/**
 * Draws the lines of the robot's map: what it considers blocked, its plan, the points and the graph
 * that it remembers.
 * @param {Pen} pen
 * @param {DrawnRun} run
 * @param {number} step
 */
export function drawMemory(pen, run, step) {
  if (!hasMap(run)) return;
  const { context, px, py, colours } = pen,
    { named: shapes } = shapesAt(run, step);
  context.save();
  const lines = (kind) => {
    context.beginPath();
    for (const [x0, y0, x1, y1] of shapes[kind]) {
      context.moveTo(px(x0), py(y0));
      context.lineTo(px(x1), py(y1));
    }
  };
  lines("blocked");
  stroke(pen, colours[MARKS.memory.colour], 0.6 * MARKS.memory.width * pen.unit);
  lines("plan");
  strokeMark(pen, "plan");
  lines("edge");
  strokeMark(pen, "memory");
  for (const [x, y] of shapes.node) drawNode(pen, x, y);
  for (const [x, y, name] of shapes.place) drawPlace(pen, x, y, name);
  context.restore();
}

// Tints rectangles: the worse they are to drive on, the stronger.
function drawDegrees({ context, px, py }, degrees) {
  for (const [degree, shapes] of degrees.entries()) {
    context.globalAlpha = 0.58 - (0.5 * degree) / (degrees.length - 1);
    for (const [x0, y0, x1, y1] of shapes) context.fillRect(px(x0), py(y0), px(x1) - px(x0), py(y1) - py(y0));
  }
}

function drawNode({ context, px, py, colours, unit }, x, y) {
  context.beginPath();
  context.arc(px(x), py(y), MARKS.memory.size * unit, 0, 2 * Math.PI);
  context.fillStyle = colours.memory;
  context.fill();
}

function drawPlace(pen, x, y, name) {
  const { context, px, py, colours } = pen,
    size = 6;
  context.beginPath();
  for (const [dx, dy] of [[0, -size], [size, 0], [0, size], [-size, 0]]) context.lineTo(px(x) + dx, py(y) + dy);
  context.closePath();
  stroke(pen, colours.memory, 2.5);
  context.font = "600 12px system-ui, sans-serif";
  context.lineWidth = 3;
  context.strokeStyle = colours.floor;
  context.strokeText(name, px(x) + size + 3, py(y) + 4);
  context.fillStyle = colours.memory;
  context.fillText(name, px(x) + size + 3, py(y) + 4);
}
