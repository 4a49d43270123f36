// The world that is drawn and its history.

import assert from "node:assert/strict";
import { test } from "node:test";
import "./stand_in.mjs";
import { Model, bordered, markAt, resized } from "#player/edit/model.js";
import { messageOf, worldOf } from "#studio/shared/world_message.js";
import { blank } from "./samples.mjs";

function drawing(width = 40, height = 40) {
  const changes = [];
  const model = new Model(blank(width, height), () => changes.push(model.version));
  return { model, changes };
}

const box = (x, y, width, height) => ({ x, y, width, height });

function stroke(model, label, ...boxes) {
  model.paint(boxes, 1);
  model.lift(label);
}

test("an empty world has a border of walls if there is room for one", () => {
  assert.equal(drawing().model.solid, 156);
  assert.equal(bordered(2, 5).reduce((sum, cell) => sum + cell), 4); // the two rows at the ends
  assert.equal(bordered(1, 1)[0], 0);
});

test("an empty world's start and target are in opposite corners, however small it is", () => {
  for (const [width, height] of [[1, 1], [2, 7], [5, 5], [40, 30]]) {
    const { start, target, cell_size: cell } = blank(width, height);
    for (const [x, y] of [start, target]) assert.ok(x > 0 && x < width * cell && y > 0 && y < height * cell);
  }
});

test("each stroke is undone and redone separately", () => {
  const { model } = drawing();
  stroke(model, "brush", box(5, 5, 5, 1));
  stroke(model, "line", box(5, 10, 1, 10));
  assert.equal(model.solid, 171);
  assert.deepEqual([model.undo(), model.solid], ["line", 161]);
  assert.deepEqual([model.undo(), model.solid], ["brush", 156]);
  assert.equal(model.undo(), null);
  assert.deepEqual([model.redo(), model.redo(), model.redo(), model.solid], ["brush", "line", null, 171]);
});

test("drawing after an undo replaces what was undone", () => {
  const { model } = drawing();
  stroke(model, "brush", box(5, 5, 5, 1));
  model.undo();
  stroke(model, "brush", box(5, 5, 1, 1));
  assert.equal(model.redo(), null);
  assert.equal(model.solid, 157);
});

test("a stroke that changes nothing is not a step of the history", () => {
  const { model } = drawing();
  stroke(model, "brush", box(0, 0, 40, 1));
  assert.equal(model.undo(), null);
});

test("an unfinished stroke is undone separately", () => {
  const { model } = drawing();
  stroke(model, "brush", box(5, 5, 5, 1));
  model.paint([box(5, 8, 3, 1)], 1);
  model.undo();
  assert.equal(model.solid, 161);
});

test("cells outside the world are ignored", () => {
  const { model } = drawing(10, 10);
  stroke(model, "brush", box(-3, -3, 5, 5), box(8, 8, 5, 5), box(20, 20, 2, 2));
  assert.equal(model.solid, 36 + 2); // (1, 1) and (8, 8); the rest is border
});

test("consecutive changes of one kind, such as a slider's, are one step", () => {
  const { model } = drawing();
  for (const radius of [0.08, 0.09, 0.1]) model.change("radius", { robot_radius: radius }, true);
  model.change("speed", { robot_speed: 3 }, true);
  model.undo();
  assert.equal(model.world.robot_radius, 0.1);
  model.undo();
  assert.equal(model.world.robot_radius, 0.07);
});

test("a change after saving is a separate step", () => {
  const { model } = drawing();
  model.change("radius", { robot_radius: 0.08 }, true);
  model.markSaved("mine.grid", null, "digest", model.mark());
  assert.ok(!model.unsaved);
  model.change("radius", { robot_radius: 0.09 }, true);
  assert.ok(model.unsaved);
  model.undo();
  assert.deepEqual([model.unsaved, model.world.robot_radius], [false, 0.08]);
});

test("drawing while a file is being saved counts as a change", () => {
  const { model } = drawing();
  stroke(model, "brush", box(5, 5, 5, 1));
  const mark = model.mark();
  stroke(model, "brush", box(5, 8, 5, 1));
  model.markSaved("mine.grid", null, "digest", mark);
  assert.ok(model.unsaved);
  model.undo();
  assert.ok(!model.unsaved);
});

test("undo after opening brings back the drawing and its name", () => {
  const { model } = drawing();
  stroke(model, "brush", box(5, 5, 5, 1));
  model.change("open", worldOf(messageOf(blank(9, 9)), "other.grid", "digest"));
  assert.deepEqual([model.world.name, model.world.width], ["other.grid", 9]);
  model.undo();
  assert.deepEqual([model.world.name, model.solid], ["", 161]);
});

test("saving names all versions of the drawing, and no other drawing", () => {
  const { model } = drawing();
  stroke(model, "brush", box(5, 5, 5, 1));
  model.change("open", worldOf(messageOf(blank(9, 9)), "other.grid", "digest"));
  model.change("radius", { robot_radius: 0.09 });
  model.markSaved("new.grid", null, "other digest", model.mark());
  model.undo();
  assert.equal(model.world.name, "new.grid");
  model.undo();
  assert.equal(model.world.name, "");
});

test("a world's cells survive its message", () => {
  // Even if a row, or the whole world, ends within a byte: eight cells are packed into each.
  for (const [width, height] of [[1, 1], [3, 5], [7, 9], [8, 8], [200, 131]]) {
    const world = blank(width, height);
    world.cells = world.cells.map((_, k) => Number((k * k + k) % 7 < 3));
    assert.deepEqual(worldOf(messageOf(world)).cells, world.cells);
  }
});

test("a message has nothing that only the page uses", () => {
  const sent = JSON.parse(JSON.stringify(messageOf(worldOf(messageOf(blank(9, 9)), "mine.grid", "digest"))));
  assert.deepEqual(["name", "file", "sheet"].filter((name) => name in sent), []);
});

test("a world grows away from the corner that stays", () => {
  const { model } = drawing();
  stroke(model, "brush", box(5, 5, 5, 1));
  const grown = resized(model.world, 44, 30, [1, 1]); // the upper right stays
  // below, border and stroke are gone
  assert.equal(grown.cells.reduce((sum, cell) => sum + cell), 161 - 40 - 2 * 9 - 5);
  // it moved with its cells, and was kept inside
  assert.deepEqual(grown.start.slice(0, 2), [0.65, 0.05]);
  assert.equal(grown.cells[29 * 44 + 43], 1);
});

test("a world that grows and shrinks around the same corner is as it was", () => {
  const { model } = drawing(9, 7);
  stroke(model, "brush", box(3, 3, 2, 1));
  for (const kept of [[0, 0], [1, 1], [0, 1]]) {
    const there = { ...model.world, ...resized(model.world, 20, 15, kept) };
    assert.deepEqual(resized(there, 9, 7, kept).cells, model.world.cells);
  }
});

test("changes move with their cells, and are deleted with them", () => {
  const world = { ...blank(9, 9), events: { times: [1, 2], ix: [2, 7], iy: [2, 7], state: [2, 0] } };
  assert.deepEqual(resized(world, 5, 5).events, { times: [1], ix: [2], iy: [2], state: [2] });
  assert.deepEqual(resized(world, 5, 5, [1, 1]).events, { times: [2], ix: [3], iy: [3], state: [0] });
  assert.equal(resized({ ...world, events: { times: [1], ix: [8], iy: [8], state: [2] } }, 5, 5).events, null);
});

test("a box contains all changes since a version, even after many strokes", () => {
  const { model } = drawing();
  stroke(model, "brush", box(5, 5, 5, 1));
  const then = model.version;
  stroke(model, "brush", box(10, 12, 2, 3));
  const { x, y, width, height } = model.boxSince(then);
  assert.ok(x <= 10 && y <= 12 && x + width >= 12 && y + height >= 15 && y > 5);
  for (let k = 0; k < 100; k += 1) stroke(model, "brush", box(k % 40, 20, 1, 1));
  assert.equal(model.boxSince(then), null); // no longer known: everything is drawn again
});

test("start and target have their names next to them", () => {
  const world = blank(40, 40);
  const cells = ([x, y]) => [x / world.cell_size, y / world.cell_size];
  assert.deepEqual([cells(world.start), cells(world.target), [20, 20], null].map((at) => markAt(world, at)), ["Start", "Target", "", ""]);
});
