// Worlds that change: future changes, where a timed path waits, and how the board shows a moment.

import assert from "node:assert/strict";
import { test } from "node:test";
import "./stand_in.mjs";
import { drawOpenings } from "#player/picture/changes.js";
import { cellsAt } from "#player/decode.js";
import { makeBoard } from "#player/edit/board.js";
import { drawnOf } from "#player/edit/drawn_world.js";
import { Model } from "#player/edit/model.js";
import { makeTime } from "#studio/draw/time.js";
import { makeTools } from "#player/edit/tools.js";
import { rangeWords } from "#studio/shared/fields.js";
import { blank } from "./samples.mjs";

// A wall across a world of 9 x 5 cells, whose middle opens after two seconds.
function gate() {
  const world = { ...blank(9, 5), events: { times: [2, 3], ix: [4, 4], iy: [2, 1], state: [0, 2] } };
  for (let iy = 0; iy < 5; iy += 1) world.cells[iy * 9 + 4] = 1;
  return world;
}

function withPath(world) {
  const drawn = drawnOf(world);
  drawn.open.witness = { ms: Float64Array.of(0, 4000), x: Float64Array.of(1.5, 7.5), y: Float64Array.of(2.5, 2.5) };
  return drawn;
}

// Returns the text next to the path at a moment, as [words, column].
function openings(drawn, ms) {
  const written = [];
  const context = { save() {}, restore() {}, strokeText() {}, measureText: () => ({ width: 10 }), fillText: (words, x) => written.push([words, x - 8]) };
  const pen = { context, width: 1000, scale: 1, px: (x) => x, py: (y) => y, colours: {} };
  drawOpenings(pen, drawn, cellsAt(drawn, ms));
  return written;
}

test("a timed path shows where and when it goes through a wall that opens", () => {
  const drawn = withPath(gate());
  const [[words, column], ...more] = openings(drawn, 0);
  assert.deepEqual([words, Math.floor(column), more], ["opens at 2.0 s", 4, []]);
  assert.deepEqual(openings(drawn, 2500), []);
});

test("the slider ends with the last change, or with the path if that takes longer, and is hidden in a static world", () => {
  for (const [world, duration, words] of [[gate(), undefined, "3.0 s"], [gate(), 9, "9.0 s"]]) {
    const board = { time: 0, proof: duration ? { duration } : null, draw() {} };
    const time = makeTime({ board, studio: { model: { world } } });
    time.refresh();
    const slider = time.element.querySelector("#board-time");
    slider.value = slider.getAttribute("max");
    slider.dispatchEvent(new Event("input"));
    assert.equal(time.element.querySelector("output").textContent, words);
    assert.equal(time.element.hidden, false);
  }
  const still = makeTime({ board: {}, studio: { model: { world: blank(5, 5) } } });
  still.refresh();
  assert.equal(still.element.hidden, true);
});

test("the board draws one moment of the world, and editing does not change the time", () => {
  const model = new Model(gate(), () => {});
  const canvas = document.createElement("canvas");
  const board = makeBoard(canvas, model, { grid: true, ruler: true, proof: true });
  board.time = 2.5;
  board.draw();
  model.paint([{ x: 1, y: 1, width: 1, height: 1 }], 1);
  model.lift("brush");
  board.draw();
  assert.equal(board.time, 2.5);
  // the cell opens later, and is still drawn as a wall
  assert.equal(model.world.cells[2 * 9 + 4], 1);
});

test("with Shift, brush and line are horizontal, vertical or at 45 degrees", () => {
  const straight = { erase: false, exact: false, straight: true };
  for (const tool of ["brush", "line"]) {
    const model = new Model(blank(20, 20), () => {});
    const board = { model, marks: [], draw() {} };
    const tools = makeTools(board, { size: 1, hollow: false, stamp: "U trap", stampSize: 12 }, () => {});
    const drawTo = (x, y) => {
      tools[tool].begin([5.5, 5.5], straight);
      tools[tool].drag([x + 0.5, y + 0.5], straight);
      tools[tool].end(straight);
      return [...model.world.cells.keys()].filter((k) => model.world.cells[k] && k % 20 > 0 && k % 20 < 19 && k > 20 && k < 380);
    };
    const rows = new Set(drawTo(12, 7).map((k) => Math.floor(k / 20)));
    assert.deepEqual([...rows], [5], tool);
    model.undo();
    const slanted = drawTo(11, 10);
    assert.ok(slanted.every((k) => k % 20 === Math.floor(k / 20)) && slanted.length >= 6, tool);
  }
});

test("a range is described in words, without the number that means automatic", () => {
  const parameter = { low: 1, high: 20, unit: "cells", chosen: -1 };
  assert.equal(rangeWords(parameter), "1 to 20 cells; empty for automatic");
  assert.equal(rangeWords({ low: 0, high: null, above: true, chosen: null }), "more than 0");
  assert.equal(rangeWords({ low: 0, high: null, unit: "s" }), "at least 0 s");
  assert.equal(rangeWords({ low: null, high: null, chosen: -1 }), "empty for automatic");
});
