// What pointers and keys do on the drawing board: strokes, how they are cancelled,
// and what the user sees.

import assert from "node:assert/strict";
import { test } from "node:test";
import { element, point, press } from "./stand_in.mjs";
import { makeBoard } from "#player/edit/board.js";
import { Model } from "#player/edit/model.js";
import { listenToBoard } from "#player/edit/pointer.js";
import { makeTools } from "#player/edit/tools.js";
import { blank } from "./samples.mjs";

const BORDER = 156; // solid cells of an empty world of 40 x 40

/* A board of 508 x 468 pixels, which shows the whole world of 40 x 40 cells at 10 pixels per
   cell. */
function drawing(tool = "brush") {
  element("stage").replaceChildren();
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { clientWidth: 508, clientHeight: 468 });
  element("stage").append(canvas);
  const said = [];
  const model = new Model(blank(40, 40), () => {});
  const board = makeBoard(canvas, model, { grid: true, ruler: true, proof: true, signal: false });
  const setting = { size: 1, hollow: false, stamp: "U trap", stampSize: 12 };
  const draw = { canvas, board, tool, tools: makeTools(board, setting, (words) => said.push(words)), say: (words) => said.push(words), where() {} };
  listenToBoard(draw);
  return { draw, canvas, board, model, said, setting };
}

/* Returns the position of a cell's middle in the window. */
const pixel = ([x, y]) => [508 / 2 + (x + 0.5 - 20) * 10, 468 / 2 - (y + 0.5 - 20) * 10];

function drag({ canvas }, from, to, more = {}) {
  point(canvas, "pointerdown", pixel(from), more);
  point(canvas, "pointermove", pixel(to), more);
  point(canvas, "pointerup", pixel(to), more);
}

function keys({ canvas }, ...all) {
  canvas.focus();
  for (const key of all) {
    const [name, ...held] = key.split("+").reverse();
    press(name === "Space" ? " " : name, { at: canvas, shiftKey: held.includes("Shift") });
  }
}

function pinch({ canvas }, ...cells) {
  cells.forEach((cell, k) => point(canvas, "pointerdown", pixel(cell), { pointerId: k + 1 }));
  cells.forEach((cell, k) => point(canvas, "pointerup", pixel(cell), { pointerId: k + 1 }));
}

test("the brush draws, and erases with the right button; the eraser does the opposite", () => {
  const page = drawing();
  drag(page, [5, 5], [9, 5]);
  assert.equal(page.model.solid, BORDER + 5);
  drag(page, [6, 5], [8, 5], { buttons: 2 });
  assert.equal(page.model.solid, BORDER + 2);
  page.draw.tool = "erase";
  drag(page, [6, 5], [8, 5], { buttons: 2 });
  drag(page, [5, 5], [5, 5]);
  assert.equal(page.model.solid, BORDER + 4);
});

test("a brush leaves no gap, however fast it moves", () => {
  const page = drawing();
  drag(page, [5, 5], [25, 12]);
  assert.equal(page.model.solid, BORDER + 21);
});

test("a line and an outline are drawn when the button is released", () => {
  const page = drawing("line");
  point(page.canvas, "pointerdown", pixel([5, 10]));
  point(page.canvas, "pointermove", pixel([5, 19]));
  assert.equal(page.model.solid, BORDER);
  point(page.canvas, "pointerup", pixel([5, 19]));
  assert.equal(page.model.solid, BORDER + 10);
  Object.assign(page.setting, { hollow: true });
  page.draw.tool = "rectangle";
  drag(page, [10, 10], [19, 14]);
  assert.equal(page.model.solid, BORDER + 10 + 26);
});

test("a fill and a stamp are one step each", () => {
  const page = drawing("stamp");
  drag(page, [20, 20], [20, 20]);
  assert.equal(page.model.solid, BORDER + 34);
  page.draw.tool = "fill";
  drag(page, [5, 20], [5, 20]);
  assert.equal(page.model.solid, 1600);
  page.model.undo();
  page.model.undo();
  assert.equal(page.model.solid, BORDER);
});

test("a selection moves with its contents", () => {
  const page = drawing();
  drag(page, [5, 5], [9, 5]);
  page.draw.tool = "select";
  drag(page, [4, 4], [10, 6]);
  drag(page, [5, 5], [5, 15]);
  assert.deepEqual(page.board.selection, { x: 4, y: 14, width: 7, height: 3 });
  assert.deepEqual([page.model.world.cells[5 * 40 + 5], page.model.world.cells[15 * 40 + 5], page.model.solid], [0, 1, BORDER + 5]);
});

test("dragging from the start turns it in steps of five degrees", () => {
  const page = drawing("start");
  drag(page, [10, 10], [13, 13]);
  const [x, y, heading] = page.model.world.start;
  assert.deepEqual([x, y], [1.05, 1.05]);
  assert.ok(Math.abs(heading - Math.PI / 4) < 1e-6);
});

test("each drag of the target is undone separately", () => {
  const page = drawing("target");
  drag(page, [30, 30], [20, 20]);
  drag(page, [25, 25], [10, 10]);
  page.model.undo();
  assert.deepEqual(page.model.world.target.slice(0, 2), [2.05, 2.05]);
});

test("with Alt, start and target can be anywhere in the world, but never outside", () => {
  const page = drawing("target");
  const [x, y] = pixel([10, 10]);
  for (const [place, there] of [[[x + 2, y], [1.07, 1.05]], [[5000, y], [4, 1.05]]]) {
    point(page.canvas, "pointerdown", place, { altKey: true });
    point(page.canvas, "pointerup", place, { altKey: true });
    assert.deepEqual(page.model.world.target.slice(0, 2), there);
  }
});

test("measurements are shown in metres", () => {
  const page = drawing("measure");
  drag(page, [5, 5], [8, 9]);
  assert.equal(page.said.at(-1), "0.500 m");
});

test("a tool chosen while drawing waits for the end of the stroke", () => {
  const page = drawing();
  point(page.canvas, "pointerdown", pixel([5, 30]));
  page.draw.tool = "line";
  point(page.canvas, "pointermove", pixel([9, 30]));
  point(page.canvas, "pointerup", pixel([9, 30]));
  assert.equal(page.model.solid, BORDER + 5);
});

test("Escape cancels what was begun with keys, and the next stroke is a new one", () => {
  const page = drawing("line");
  keys(page, "Space", "Shift+ArrowRight");
  assert.ok(page.draw.cancel());
  keys(page, "ArrowUp", "Space", "ArrowRight", "Space");
  assert.equal(page.model.solid, BORDER + 2);
});

test("Escape cancels what the mouse is drawing, and the mouse draws nothing until it is pressed again", () => {
  const page = drawing();
  point(page.canvas, "pointerdown", pixel([5, 30]));
  point(page.canvas, "pointermove", pixel([9, 30]));
  assert.ok(page.draw.cancel());
  point(page.canvas, "pointermove", pixel([15, 30]));
  point(page.canvas, "pointerup", pixel([15, 30]));
  assert.equal(page.model.solid, BORDER);
  assert.equal(page.draw.cancel(), false);
});

test("after a cancelled stroke, earlier undone steps can still be redone", () => {
  const page = drawing();
  drag(page, [5, 5], [9, 5]);
  page.model.undo();
  point(page.canvas, "pointerdown", pixel([5, 30]));
  page.draw.cancel();
  assert.equal(page.model.redo(), "brush");
  assert.equal(page.model.solid, BORDER + 5);
});

test("a tool begun with keys ends when the board loses focus", () => {
  const page = drawing("line");
  keys(page, "Space", "Shift+ArrowRight");
  page.canvas.blur();
  keys(page, "ArrowUp", "Space"); // this begins another one
  assert.equal(page.model.solid, BORDER);
});

test("a pointer pressed while keys draw begins its own stroke", () => {
  const page = drawing("line");
  keys(page, "Space", "Shift+ArrowRight");
  drag(page, [5, 30], [9, 30]);
  assert.equal(page.model.solid, BORDER + 5);
});

test("two fingers change neither the drawing, nor the selection, nor the steps that can be redone", () => {
  const page = drawing();
  for (const x of [5, 10]) drag(page, [x, 20], [x, 20]);
  page.model.undo();
  pinch(page, [20, 20], [24, 20]);
  assert.equal(page.model.solid, BORDER + 1);
  assert.equal(page.model.redo(), "brush");
  page.draw.tool = "select";
  drag(page, [4, 19], [11, 21]);
  const { selection } = page.board;
  pinch(page, [30, 30], [34, 30]);
  assert.deepEqual(page.board.selection, selection);
});

test("two fingers move and zoom, and the point between them stays between them", () => {
  const page = drawing();
  const before = page.board.pointAt({ clientX: 254, clientY: 234 });
  point(page.canvas, "pointerdown", [204, 234], { pointerId: 1 });
  point(page.canvas, "pointerdown", [304, 234], { pointerId: 2 });
  point(page.canvas, "pointermove", [154, 234], { pointerId: 1 });
  point(page.canvas, "pointermove", [354, 234], { pointerId: 2 });
  const after = page.board.pointAt({ clientX: 254, clientY: 234 });
  assert.ok(Math.hypot(after[0] - before[0], after[1] - before[1]) < 1e-9);
  assert.equal(page.board.now().scale, 20);
  assert.equal(page.model.solid, BORDER);
});

test("the cursor begins in the middle, and its position and cell are announced", () => {
  const page = drawing();
  keys(page, "ArrowRight", "ArrowRight");
  assert.deepEqual(page.board.cursor, [21, 20]);
  assert.equal(page.said.at(-1), "21, 20: free");
  page.board.cursor = [2, 2];
  keys(page, "ArrowLeft", "ArrowRight");
  assert.match(page.said.at(-1), /^2, 2: free, start$/);
  page.board.cursor = [1, 0];
  keys(page, "ArrowLeft");
  assert.equal(page.said.at(-1), "0, 0: wall");
});

test("the cursor stays in the world", () => {
  const page = drawing();
  keys(page, ...Array(12).fill("Shift+ArrowRight"), ...Array(12).fill("Shift+ArrowDown"));
  assert.deepEqual(page.board.cursor, [39, 0]);
});

test("the view follows the cursor, just far enough to show it", () => {
  const page = drawing();
  for (let k = 0; k < 6; k += 1) page.board.zoom(1.4);
  keys(page, ...Array(4).fill("Shift+ArrowRight"), "Shift+ArrowUp", "Shift+ArrowUp");
  const { x, y, scale } = page.board.now(),
    [ix, iy] = page.board.cursor;
  const left = 254 + (ix - x) * scale,
    top = 234 - (iy + 1 - y) * scale;
  assert.ok(left >= 40 && left + scale <= 508 && top >= 20 && top + scale <= 468, `${left}, ${top}`);
  assert.ok(ix > 30);
});

test("a preview of the stamp is drawn at the cursor", () => {
  const page = drawing("stamp");
  keys(page, "ArrowRight");
  assert.equal(page.board.ghost.pattern.width, 12);
  const { context } = page.canvas;
  const before = context.of("drawImage").length;
  keys(page, "ArrowRight");
  assert.ok(context.of("drawImage").length > before);
});

test("the wheel zooms in at the pointer", () => {
  const page = drawing();
  const at = { clientX: 100, clientY: 100 };
  const before = page.board.pointAt(at);
  page.canvas.dispatchEvent(Object.assign(new Event("wheel", { cancelable: true }), { ...at, deltaY: -200 }));
  const after = page.board.pointAt(at);
  assert.ok(page.board.now().scale > 10 && Math.hypot(after[0] - before[0], after[1] - before[1]) < 1e-9);
});
