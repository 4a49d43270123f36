// What the player draws of a run, layer by layer: the cells, lines and words sent to the canvas.

import assert from "node:assert/strict";
import { test } from "node:test";
import "./stand_in.mjs";
import { cellsAt } from "#player/decode.js";
import { drawBlocked } from "#player/picture/blocked.js";
import { drawManyCells } from "#player/picture/many_cells.js";
import { drawLine } from "#player/picture/long_line.js";
import { drawScene, drawSmall, pictureLabel } from "#player/picture/map.js";
import { drawMemory, drawRemembered, memoryFacts } from "#player/picture/memory.js";
import { drawRobot } from "#player/picture/body.js";
import { drawHeadings, drawStart, drawTarget } from "#player/picture/ends.js";
import { drawNumbers } from "#player/picture/numbers.js";
import { penFor } from "#player/picture/pen.js";
import { drawPierced } from "#player/picture/pierced.js";
import { drawBeams } from "#player/picture/senses.js";
import { drivenIn } from "#player/picture/scene_robots.js";
import { drawTouched } from "#player/picture/touched.js";
import { drawApproach, drawLoop } from "#player/picture/trail.js";
import { eventView } from "#player/picture/view.js";
import { MARKS } from "#player/picture/marks.js";
import { numbers, roomOf, runOf } from "./samples.mjs";

const SHOW = { trail: true, touched: true, sensors: true, signal: true, memory: true, witness: true };

/* Makes a pen with 10 pixels per cell; the world's lower left corner is at (0, height). */
function penOf(world, { scale = 10, wide = world.width * scale, high = world.height * scale } = {}) {
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { clientWidth: wide, clientHeight: high });
  return penFor(canvas, { x: world.width / 2, y: world.height / 2, scale }, world);
}

/* Returns the cells whose squares were framed in a colour. */
function framed(pen, colour, height, name = "rect") {
  const { calls } = pen.context;
  const shown = calls.filter((call, k) => call.name === name && (name === "strokeRect" ? call : calls.slice(k).find((one) => one.name === "stroke"))?.strokeStyle === colour);
  return new Set(shown.map(({ given: [x, y] }) => `${Math.round(x / pen.scale - 0.2)},${height - 1 - Math.round(y / pen.scale - 0.2)}`));
}

const room = roomOf(14, 10, [[7, 2], [7, 3], [7, 4], [7, 5], [7, 6], [7, 7]]);
const through = runOf({
  at: [0, 1, 2, 3], x: [2.5, 5.5, 8.5, 11], y: [4.5, 4.5, 4.5, 4.5], tolerance: 0.1,
  marks: [{ step: 2, kind: "breach", name: "Breach", text: "goes through this wall", cell: [7, 4] }],
});

test("a wall that the robot enters is framed at first, and striped once the robot is in it", () => {
  const count = (step) => {
    const pen = penOf(room);
    drawPierced(pen, { world: room, run: through, step });
    return [framed(pen, "pierced", 10), pen.context.of("clip").length, pen.context.of("rect").length];
  };
  assert.deepEqual(count(0)[1], 0);
  assert.ok(count(0)[0].has("7,4")); // dashed: the robot is not there yet
  const [cells, stripes] = count(2);
  assert.ok(cells.has("7,4") && stripes === cells.size);
  assert.ok([...cells].every((cell) => cell.startsWith("7,")), [...cells].join(" "));
});

test("a cell that catches the robot is framed, without stripes", () => {
  const drawn = (kind) => {
    const pen = penOf(room);
    drawPierced(pen, { world: room, run: { ...through, open: undefined, tolerance: null, marks: through.marks.map((mark) => ({ ...mark, kind })) }, step: 2 });
    assert.deepEqual([...framed(pen, "pierced", 10)], ["7,4"]);
    return pen.context.of("lineTo").length;
  };
  assert.ok(drawn("breach") > 2);
  assert.equal(drawn("caught"), 2); // its cross
});

test("a wall that only the robot's edge enters is marked, unless by just a tenth of a cell", () => {
  const marked = (x) => {
    const pen = penOf(room);
    drawPierced(pen, { world: room, run: runOf({ at: [0, 1], x: [2.5, x], y: [4.5, 4.5], tolerance: 0.1 }), step: 1 });
    return [...framed(pen, "pierced", 10)];
  };
  assert.deepEqual([marked(6.45), marked(6.35)], [["7,4"], []]);
});

test("a cross marks where the robot breaks into a wall, from that step on", () => {
  const crosses = (step) => {
    const pen = penOf(room);
    drawPierced(pen, { world: room, run: through, step });
    return pen.context.of("stroke").filter(({ lineWidth }) => lineWidth === MARKS.breach.casing * pen.unit).length;
  };
  assert.deepEqual([0, 1.9, 2, 3].map(crosses), [0, 0, 1, 1]);
});

test("a robot that stays out of walls marks none, however near it comes", () => {
  const run = runOf({ at: [0, 1, 2], x: [2.5, 6.3, 6.3], y: [4.5, 4.5, 5.5], bump: [0, 1, 1] });
  const pen = penOf(room);
  drawPierced(pen, { world: room, run, step: 2 });
  assert.equal(framed(pen, "pierced", 10).size, 0);
});

test("at a bump, the sides of the nearest walls that face the robot are marked, from then on", () => {
  const run = runOf({ at: [0, 1, 2], x: [6.3, 6.3, 6.3], y: [3.5, 4.5, 5.5], bump: [0, 1, 0] });
  const touched = (step, whole = false) => {
    const pen = penOf(room);
    drawTouched(pen, room, drivenIn({ world: room, run, step, number: null, show: SHOW }), whole);
    const { calls } = pen.context;
    assert.ok(calls.every(({ name, strokeStyle }) => name !== "stroke" || strokeStyle === "touched"));
    const ends = pen.context.of("lineTo");
    // The cell in which the middle of each line is.
    return pen.context.of("moveTo").map(({ given: [x, y] }, k) => [Math.floor(x / pen.scale), room.height - 1 - Math.floor((y + ends[k].given[1]) / 2 / pen.scale)].join());
  };
  assert.deepEqual([touched(0), touched(1), touched(2)], [[], ["7,4"], ["7,4"]]);
  assert.deepEqual(touched(0, true), ["7,4"]);
});

test("a beam ends at the first wall, or at its range", () => {
  const pen = penOf(room);
  const sensors = { beams: 4, field: 0, range: 4 };
  drawBeams(pen, { world: room, sensors }, cellsAt(room, 0), { x: 4.5, y: 4.5, heading: 0 });
  const ends = pen.context.of("lineTo").slice(0, 4).map(({ given: [x, y] }) => [x / 10, 10 - y / 10].map((value) => Number(value.toFixed(6))));
  assert.deepEqual(ends, [[7, 4.5], [4.5, 8.5], [1, 4.5], [4.5, 1]]);
});

test("fire is drawn while it burns", () => {
  const events = { ms: numbers([300, 600]), ix: numbers([6, 6]), iy: numbers([1, 1]), state: numbers([2, 0]) };
  const world = roomOf(14, 10, [], { events });
  const run = runOf({ at: [0, 10], x: [2, 3] });
  const burns = [2.9, 3, 5.9, 6].map((step) => {
    const canvas = document.createElement("canvas");
    drawScene(canvas, { world, run, step, show: SHOW });
    return canvas.context.of("fillRect").some(({ fillStyle }) => fillStyle === "fire");
  });
  assert.deepEqual(burns, [false, true, true, false]);
});

test("each layer is drawn only if it is shown", () => {
  const memory = { fields: [], fault: "", map: mapOf([[1, 0, 0, 100, 100, 0, 9]]) };
  const run = runOf({ at: [0, 1, 2], x: [2.5, 6.3, 2.5], y: [4.5, 4.5, 4.5], bump: [0, 1, 0], memory });
  const signs = { trail: ["strokeStyle", "loop"], touched: ["strokeStyle", "touched"], sensors: ["globalAlpha", MARKS.beam.opacity, "target"], memory: ["fillStyle", "memory"] };
  for (const [name, [setting, value, stroked]] of Object.entries(signs))
    for (const on of [true, false]) {
      const canvas = document.createElement("canvas");
      drawScene(canvas, { world: room, run, step: 2, show: { ...SHOW, [name]: on }, sensors: { beams: 3, field: 0, range: 4 } });
      const drawn = canvas.context.calls.filter((call) => call.name === (setting === "fillStyle" ? "fillRect" : "stroke"));
      assert.equal(drawn.some((one) => one[setting] === value && (!stroked || one.strokeStyle === stroked)), on, `${name} ${on}`);
    }
});

const KINDS = ["blocked", "cell", "plan", "place", "node", "edge"];

function mapOf(rows, names = []) {
  const columns = ["kind", "x0", "y0", "x1", "y1", "since", "until"];
  return { ...Object.fromEntries(columns.map((name, k) => [name, numbers(rows.map((row) => row[k]))])), kinds: KINDS, degrees: 4, names };
}

test("a memory's shapes are visible from their step until they are forgotten", () => {
  const memory = { fields: [], fault: "", map: mapOf([[1, 100, 100, 200, 200, 2, 5], [3, 300, 300, 0, 0, 3, 9]], ["hit"]) };
  const run = runOf({ at: [0, 9], x: [1, 2], memory });
  const shown = [1, 2, 3, 4, 5, 8, 9].map((step) => {
    const pen = penOf(room);
    drawRemembered(pen, run, step);
    drawMemory(pen, run, step);
    return [pen.context.of("fillRect").length, pen.context.of("fillText").map(({ given }) => given[0]).join()];
  });
  assert.deepEqual(shown, [[0, ""], [1, ""], [1, "hit"], [1, "hit"], [0, "hit"], [0, "hit"], [0, ""]]);
});

test("a graph is drawn as lines and dots, and bad ground is tinted more than good ground", () => {
  const rows = [[4, 100, 100, 0, 0, 0, 9], [5, 100, 100, 400, 100, 0, 9], [6, 0, 0, 100, 100, 0, 9], [9, 0, 200, 100, 300, 0, 9]];
  const run = runOf({ at: [0, 9], x: [1, 2], memory: { fields: [], fault: "", map: mapOf(rows) } });
  const pen = penOf(room);
  drawRemembered(pen, run, 1);
  drawMemory(pen, run, 1);
  const tints = pen.context.of("fillRect").map(({ globalAlpha }) => globalAlpha);
  assert.equal(tints.length, 2);
  assert.ok(tints[0] > tints[1] && tints[1] > 0, String(tints));
  assert.equal(pen.context.of("arc").length, 1);
  assert.ok(pen.context.of("lineTo").length >= 1);
});

test("a memory's numbers are described in words if the controller has any", () => {
  const fields = [
    { name: "doing", words: ["drive", "follow"], least: 0, values: numbers([0, 1000]) },
    { name: "best", words: [], least: 0, values: numbers([1500, 99_000]) },
  ];
  const run = runOf({ at: [0, 1], x: [1, 2], memory: { fields, one: 1000, missing: 99_000, fault: "", map: null } });
  assert.deepEqual(memoryFacts(run, 0), [["doing", "drive"], ["best", "1.5"]]);
  assert.deepEqual(memoryFacts(run, 1), [["doing", "follow"], ["best", "none"]]);
  assert.deepEqual(memoryFacts({ ...run, memory: { fault: "it cannot be shown" } }, 0), [["memory", "it cannot be shown"]]);
});

test("the numbers of several robots are next to them and along their paths, without overlap", () => {
  const path = Array.from({ length: 60 }, (_, k) => 1 + k);
  const long = roomOf(64, 10);
  const robot = (y) => runOf({ at: path.map((_, k) => k), x: path, y: path.map(() => y) });
  const scene = { world: long, run: robot(3), others: [{ run: robot(3.2), number: 2 }], number: 1, step: 59, show: SHOW };
  const pen = penOf(long);
  drawNumbers(pen, scene.world, drivenIn(scene), true);
  const written = pen.context.of("fillText").map(({ given, fillStyle }) => ({ text: given[0], at: given.slice(1), fillStyle }));
  for (const [number, colour] of [[1, "robot-0"], [2, "robot-1"]]) {
    const own = written.filter(({ text }) => text === String(number));
    assert.ok(own.length > 1 && own.every(({ fillStyle }) => fillStyle === colour));
  }
  for (const [k, one] of written.entries())
    for (const other of written.slice(k + 1)) if (k > 1) assert.ok(Math.hypot(one.at[0] - other.at[0], one.at[1] - other.at[1]) > 15);
});

test("a disc with room has its robot's number in the middle", () => {
  const room = roomOf(10, 10);
  const scene = { world: room, run: runOf({ at: [0, 1], x: [2, 3], y: [5, 5] }), others: [{ run: runOf({ at: [0, 1], x: [7, 8], y: [4, 4] }), number: 2 }], number: 1, step: 1, show: { ...SHOW, trail: false } };
  const placed = (scale) => {
    const pen = penOf(room, { scale });
    drawNumbers(pen, scene.world, drivenIn(scene), false);
    return pen.context.of("fillText").map(({ given: [text, x, y] }) => [text, x - pen.px(text === "1" ? 3 : 8), Math.round(y - pen.py(text === "1" ? 5 : 4))]);
  };
  assert.deepEqual(placed(100).sort(), [["1", 0, 5], ["2", 0, 5]]);
  assert.ok(placed(5).every(([, x, y]) => x > 0 && y < 0), "next to a small disc");
});

test("a path fades in up to its period, which is stronger and has one arrow", () => {
  const room = roomOf(10, 10);
  const strokes = (loop) => {
    const pen = penOf(room, { scale: 20 });
    const path = runOf({ at: [0, 1, 2, 3, 4], x: [2, 3, 4, 6, 4], y: [5, 5, 5, 5, 5], loop });
    for (const one of drivenIn({ world: room, run: path, step: 4, show: SHOW, number: null, whole: true })) {
      drawApproach(pen, one, true);
      drawLoop(pen, one, true);
    }
    const own = pen.context.of("stroke").filter(({ strokeStyle }) => strokeStyle === "loop");
    return [own.map(({ lineWidth }) => lineWidth / pen.unit), own.map(({ globalAlpha }) => globalAlpha), pen.context.of("fill").length];
  };
  const { approach, loop, trail } = MARKS;
  const [widths, alphas, heads] = strokes([2, 2]);
  assert.deepEqual(widths.slice(0, -1), approach.fade.map(() => approach.width));
  assert.ok(Math.abs(widths[widths.length - 1] - loop.width) < 1, String(widths)); // whole pixels
  assert.deepEqual([alphas.slice(0, -1), heads], [approach.fade, 1]);
  assert.deepEqual(strokes(null)[1], trail.fade);
});

test("the end of a run is below its path, and the path that exists is drawn by default", () => {
  const world = { ...roomOf(10, 10), witness: { ms: numbers([0, 1]), x: numbers([200, 800]), y: numbers([300, 300]), per_cell: 100 } };
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { clientWidth: 190, clientHeight: 190 });
  drawSmall(canvas, { world, run: runOf({ at: [0, 1, 2, 3], x: [2, 6, 6, 2], y: [2, 2, 6, 6], loop: [1, 2] }), sensors: null });
  const order = canvas.context.calls.filter(({ name }) => name === "stroke").map(({ strokeStyle, dash }) => (dash.length > 0 ? `${strokeStyle} dashed` : strokeStyle));
  const first = ["robot", "start dashed", "loop", "target"].map((colour) => order.indexOf(colour));
  assert.ok(first.every((at) => at >= 0), order.join());
  assert.deepEqual(first.filter((_, k) => k !== 2), [...first.filter((_, k) => k !== 2)].sort((a, b) => a - b));
  assert.ok(order.lastIndexOf("loop") > order.lastIndexOf("robot"), "the ring is below the loop");
});

test("marks are drawn in the order of the specification", () => {
  const names = Object.keys(MARKS);
  for (const [below, above] of [["floor", "wall"], ["wall", "touched"], ["band", "witness"], ["end", "loop"], ["approach", "loop"], ["witness", "loop"], ["loop", "target"]])
    assert.ok(names.indexOf(below) < names.indexOf(above), `${below} below ${above}`);
});

test("a small picture of a large world shows what happens at a visible size", () => {
  const world = roomOf(300, 200);
  const run = runOf({ at: [0, 9, 10, 11, 12], x: [5, 250, 252, 252, 250], y: [5, 150, 150, 152, 150], loop: [9, 3] });
  const view = eventView({ world, run, step: 12, show: SHOW, number: null, whole: true }, 190, 190);
  assert.ok(Math.abs(view.x - 251) < 2 && Math.abs(view.y - 151) < 3, JSON.stringify(view));
  assert.ok(2 * world.radius * view.scale >= 17.9);
  assert.equal(eventView({ world: roomOf(8, 8), run, step: 12, show: SHOW, number: null, whole: true }, 190, 190), null);
});

test("robots that block each other each have an arrow, side by side, once their loop has begun", () => {
  const room = roomOf(10, 10);
  const robot = (from, to, blocked_by) => ({ ...runOf({ at: [0, 5, 6], x: [from, to, to], y: [5, 5, 5], loop: [5, 1] }), blocked_by });
  const arrows = (step, blockers) => {
    const pen = penOf(room, { scale: 100 });
    drawBlocked(pen, drivenIn({ world: room, run: robot(2, 4.3, blockers[0]), number: 1, others: [{ run: robot(8, 5.7, blockers[1]), number: 2 }], step, show: SHOW }));
    // Each arrow is a line and a head of four corners.
    return pen.context.of("moveTo").map(({ given }) => given);
  };
  assert.deepEqual([arrows(4, [[2], [1]]).length, arrows(6, [[], []]).length, arrows(6, [[2], []]).length], [0, 0, 1]);
  const [two, one] = arrows(6, [[2], [1]]); // the one in front is drawn last
  assert.ok(one[0] < two[0] && one[1] > 500 && two[1] < 500, "each keeps to its own right");
  assert.equal(arrows(6, [[7], []]).length, 0, "a robot that is not drawn has no arrow to it");
});

test("a single robot has no number, and without the trail the path has none", () => {
  const path = Array.from({ length: 60 }, (_, k) => 1 + k);
  const run = runOf({ at: path.map((_, k) => k), x: path });
  const count = (more) => {
    const pen = penOf(roomOf(64, 10), { scale: 20 });
    drawNumbers(pen, roomOf(64, 10), drivenIn({ world: roomOf(64, 10), run, step: 59, number: null, show: SHOW, ...more }), SHOW.trail && !more.show);
    return pen.context.of("fillText").length;
  };
  assert.deepEqual([count({}), count({ number: 1, show: { ...SHOW, trail: false } })], [0, 1]);
});

test("a large world is shrunk without a picture larger than itself or twice its size on the screen", () => {
  const made = [];
  const Usual = globalThis.OffscreenCanvas;
  globalThis.OffscreenCanvas = class extends Usual {
    constructor(width, height) {
      super(width, height);
      made.push(width * height);
    }
  };
  const side = 1000,
    world = { width: side, height: side, open: { done: 0 } };
  assert.ok(drawManyCells(penOf({ ...room, width: side, height: side }, { scale: 0.3 }), world, new Uint8Array(side * side)));
  globalThis.OffscreenCanvas = Usual;
  assert.ok(made.length > 1);
  assert.ok(made.every((size) => size <= side * side), made.join(" "));
});

/* Makes a path with many corners, up and down through a large world. */
const LONG = 12_000;
const columns = { x: Float64Array.from({ length: LONG }, (_, k) => 1 + (k % 97)), y: Float64Array.from({ length: LONG }, (_, k) => 1 + ((k * 31) % 89)) };
const large = roomOf(100, 92);

/* Draws the path up to a row; returns the corners drawn on the page's canvas
   and on its own pictures. */
function corners(pen, to, more = {}) {
  let made = 0;
  const { lineTo } = Object.getPrototypeOf(pen.context);
  Object.getPrototypeOf(pen.context).lineTo = () => (made += 1);
  try {
    drawLine(pen, more.columns || columns, "way", { from: 0, to, colour: "way", width: 2, alpha: 1, ...more });
  } finally {
    Object.getPrototypeOf(pen.context).lineTo = lineTo;
  }
  return made;
}

test("a long path is drawn once, and then only extended", () => {
  const pen = penOf(large);
  const own = { columns: { ...columns } };
  const all = corners(pen, 9_000, own);
  assert.ok(all > 8_000);
  assert.equal(corners(pen, 9_000, own), 0);
  assert.ok(corners(pen, 9_010, own) < 200);
  assert.ok(pen.context.of("drawImage").length === 3);
});

test("a long path is drawn again when the view has changed, or it has become shorter", () => {
  const own = { columns: { ...columns } };
  corners(penOf(large), 9_000, own);
  assert.ok(corners(penOf(large, { scale: 11, wide: 1000, high: 920 }), 9_000, own) > 5_000);
  assert.ok(corners(penOf(large, { scale: 11, wide: 1000, high: 920 }), 4_000, own) > 2_000);
});

test("a view that follows the robot makes no picture for each frame", () => {
  const own = { columns: { ...columns } };
  let all = 0;
  for (let k = 0; k < 20; k += 1) {
    const canvas = document.createElement("canvas");
    Object.assign(canvas, { clientWidth: 600, clientHeight: 500 });
    all += corners(penFor(canvas, { x: 50 + 0.3 * k, y: 46, scale: 10 }, large), 9_000, own);
  }
  const anew = corners(penOf(large), 9_000, { columns: { ...columns } });
  assert.ok(all < 20 * anew * 0.6, `${all} corners in 20 frames, ${anew} in one that is drawn from nothing`);
});

test("a short line needs no picture", () => {
  const pen = penOf(large);
  assert.ok(corners(pen, 200, { columns: { ...columns } }) > 150);
  assert.equal(pen.context.of("drawImage").length, 0);
});

test("a picture is described in words", () => {
  assert.equal(pictureLabel({ size: "9 x 3", solid: 21, events: 2, run: { steps: 1331 } }), "World of 9 x 3 cells, 21 solid, 2 changes of cells, the robot's path of 1,331 steps");
  assert.equal(pictureLabel({ size: "9 x 3", solid: 1021, events: 0, run: null }), "World of 9 x 3 cells, 1,021 solid");
});

test("a picture without space between its edges is still drawn at a positive scale", () => {
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { clientWidth: 640, clientHeight: 10 });
  assert.ok(penFor(canvas, null, roomOf(9, 5)).scale > 0);
});

test("robots of one world have their numbers at their starts, and where their runs end", () => {
  const one = { start: [6.5, 2.5, 0], target: [2.5, 2.5, 0.5], radius: 0.7 };
  const world = { ...roomOf(9, 5), others: [one] };
  const run = () => runOf({ at: [0, 3], x: [2, 6] });
  for (const drawn of [{}, { run: run(), others: [{ run: run(), number: 2 }], step: 3 }]) {
    const canvas = document.createElement("canvas");
    Object.assign(canvas, { clientWidth: 640, clientHeight: 480 });
    drawScene(canvas, { world, show: {}, ...drawn });
    const written = canvas.getContext("2d").calls.filter(({ name }) => name === "fillText").map(({ given }) => given[0]);
    // Each number is at the target as well.
    for (const number of ["1", "2"]) assert.equal(written.filter((words) => words === number).length, 2, number);
  }
});

/* Returns the places of the points of a path, in cells, that was filled or stroked in a colour. */
function polygonsIn(pen, world, colour) {
  const found = [];
  let points = [];
  for (const { name, given, fillStyle, strokeStyle } of pen.context.calls) {
    if (name === "beginPath") points = [];
    if (name === "lineTo" || name === "moveTo") points.push([given[0] / pen.scale, world.height - given[1] / pen.scale]);
    if ((name === "fill" && fillStyle === colour) || (name === "stroke" && strokeStyle === colour)) found.push(points);
  }
  return found;
}

const near = (points, wanted) => points.length === wanted.length && points.every(([x, y], k) => Math.hypot(x - wanted[k][0], y - wanted[k][1]) < 1e-9);

test("a body is drawn as its polygon at its heading, where it starts, drives and has to stand", () => {
  const footprint = [[2, 0.5], [-1, 0.5], [-1, -0.5], [2, -0.5]];
  const body = { ...room, footprint, start: [3, 2, Math.PI / 2], target: [11, 7, 0.5], aim: 0 };
  const pen = penOf(body);
  drawStart(pen, body);
  drawTarget(pen, body);
  drawHeadings(pen, body);
  assert.ok(polygonsIn(pen, body, "start").some((points) => near(points, [[2.5, 4], [2.5, 1], [3.5, 1], [3.5, 4]])));
  assert.ok(polygonsIn(pen, body, "target").some((points) => near(points, [[13, 7.5], [10, 7.5], [10, 6.5], [13, 6.5]])));
  const [one] = drivenIn({ world: body, run: runOf({ at: [0, 1], x: [5, 5], y: [5, 5] }), step: 1, number: null, show: SHOW });
  drawRobot(pen, one);
  assert.ok(polygonsIn(pen, body, "robot").some((points) => near(points, [[7, 5.5], [4, 5.5], [4, 4.5], [7, 4.5]])));
});

test("a disc stays a disc, and a goal without a heading has no wedge", () => {
  const pen = penOf(room);
  drawStart(pen, room);
  drawTarget(pen, room);
  const arcs = pen.context.of("arc").length;
  assert.equal(arcs, 3);
  const aimed = penOf(room);
  drawTarget(aimed, { ...room, aim: 1 });
  assert.equal(aimed.context.of("closePath").length, 1);
  assert.equal(pen.context.of("closePath").length, 0);
});
