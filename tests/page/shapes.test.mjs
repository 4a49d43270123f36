// Shapes of cells, and the actions on a selection.

import assert from "node:assert/strict";
import { test } from "node:test";
import { kindOf } from "#player/edit/drawn_world.js";
import "./stand_in.mjs";
import { Model } from "#player/edit/model.js";
import { withSelection } from "#player/edit/selection.js";
import { KEEP, STAMPS, brushBox, flipped, floodCells, lineCells, mirrored, patternIn, rectangleBoxes, rectangleOf, turned } from "#player/edit/shapes.js";
import { blank } from "./samples.mjs";

// the letter L; rows go up
const L = { width: 2, height: 3, cells: Uint8Array.from([1, 1, 1, 0, 1, 0]) };

function kitOf(selection) {
  const said = [];
  const model = new Model(blank(12, 12), () => {});
  return { model, board: { selection, draw() {} }, clipboard: null, turns: [], said: (words) => said.push(words) };
}

function drawn(kit, { x, y, width, height }) {
  return [...patternIn(kit.model.world, { x, y, width, height }).cells];
}

test("a line has both ends and no gap, in whichever direction it is drawn", () => {
  for (const [from, to] of [[[0, 0], [9, 3]], [[9, 3], [0, 0]], [[2, 8], [1, -3]], [[4, 4], [4, 4]]]) {
    const cells = lineCells(from, to);
    assert.deepEqual([cells[0], cells.at(-1)], [from, to]);
    for (let k = 1; k < cells.length; k += 1) {
      const steps = [0, 1].map((axis) => Math.abs(cells[k][axis] - cells[k - 1][axis]));
      assert.equal(Math.max(...steps), 1);
    }
  }
});

test("a rectangle is the same from every corner", () => {
  for (const [from, to] of [[[2, 3], [5, 4]], [[5, 4], [2, 3]], [[2, 4], [5, 3]]])
    assert.deepEqual(rectangleOf(from, to), { x: 2, y: 3, width: 4, height: 2 });
});

test("an outline is the border of its rectangle, each cell once", () => {
  const count = new Map();
  for (const { x, y, width, height } of rectangleBoxes({ x: 0, y: 0, width: 6, height: 4 }, true))
    for (let iy = y; iy < y + height; iy += 1) for (let ix = x; ix < x + width; ix += 1) count.set(`${ix},${iy}`, (count.get(`${ix},${iy}`) || 0) + 1);
  assert.equal(count.size, 16);
  assert.deepEqual(new Set(count.values()), new Set([1]));
  assert.ok(!count.has("1,1"));
});

test("a brush is centred on its cell", () => {
  assert.deepEqual([1, 2, 3].map((size) => brushBox([5, 5], size)), [{ x: 5, y: 5, width: 1, height: 1 }, { x: 5, y: 5, width: 2, height: 2 }, { x: 4, y: 4, width: 3, height: 3 }]);
});

test("a fill spreads across sides, but not across corners", () => {
  const { cells, width, height } = blank(8, 8);
  // a diagonal: the halves touch by corners only
  for (let k = 1; k < 7; k += 1) cells[k * 8 + k] = 1;
  assert.equal(floodCells({ cells, width, height }, [5, 1]).length, 15);
  // the border, and only the two ends of the diagonal
  assert.equal(floodCells({ cells, width, height }, [0, 0]).length, 30);
});

test("a fill does not spread from the end of a row to the beginning of the next", () => {
  assert.deepEqual([...floodCells({ width: 3, height: 2, cells: Uint8Array.from([0, 1, 0, 0, 1, 1]) }, [2, 0])], [2]);
});

test("four turns, two mirrors and two flips leave a pattern as it was", () => {
  for (const acts of [[turned, turned, turned, turned], [mirrored, mirrored], [flipped, flipped], [turned, turned, mirrored, flipped]])
    assert.deepEqual(acts.reduce((pattern, act) => act(pattern), L), L);
});

test("a turn is a quarter turn to the left", () => {
  const { width, height, cells } = turned(L);
  assert.deepEqual([width, height, [...cells]], [3, 2, [1, 1, 1, 0, 0, 1]]);
});

test("outside the map, a pattern changes nothing", () => {
  const map = { width: 2, height: 1, cells: Uint8Array.from([1, 0]) };
  assert.deepEqual([...patternIn(map, { x: -1, y: 0, width: 4, height: 1 }).cells], [KEEP, 1, 0, KEEP]);
});

test("every stamp of every size has walls and room for a robot", () => {
  for (const [name, make] of Object.entries(STAMPS))
    for (const size of [5, 12, 13, 60]) {
      const { width, height, cells } = make(size);
      assert.equal(cells.length, width * height, name);
      assert.ok(cells.includes(1) && cells.some((cell) => cell !== 1), name);
    }
});

test("mirroring, flipping and turning a selection are one step of the history each", () => {
  const box = { x: 3, y: 3, width: 2, height: 3 };
  for (const [what, act] of [["mirror", mirrored], ["flip", flipped], ["turn", turned]]) {
    const kit = kitOf(box);
    kit.model.put(L, [3, 3]);
    kit.model.lift("stamp");
    withSelection(kit, what, false);
    assert.deepEqual(drawn(kit, kit.board.selection), [...act(L).cells], what);
    kit.model.undo();
    assert.deepEqual(drawn(kit, box), [...L.cells], what);
  }
});

test("copied cells stay; cut or cleared ones are deleted", () => {
  for (const [what, solid, copied] of [["copy", 4, true], ["cut", 0, true], ["clear", 0, false], ["fill", 6, false]]) {
    const kit = kitOf({ x: 3, y: 3, width: 2, height: 3 });
    kit.model.put(L, [3, 3]);
    kit.model.lift("stamp");
    withSelection(kit, what, false);
    assert.equal(kit.model.solid, 44 + solid, what);
    assert.deepEqual(kit.clipboard, copied ? L : null, what);
  }
});

test("while stamping, the stamp is turned and not the selection", () => {
  const kit = kitOf({ x: 3, y: 3, width: 2, height: 3 });
  assert.ok(withSelection(kit, "turn", true));
  assert.deepEqual([kit.turns, kit.model.solid], [[turned], 44]);
});

test("without a selection, nothing happens", () => {
  const kit = kitOf(null);
  assert.equal(withSelection(kit, "clear", false), false);
  assert.equal(kit.model.past.length, 0);
});

test("body, waypoints and heading of a goal come from the file's first robot", () => {
  const text = (more) => `%worldgen-grid 2\ncell_size = 0.5\n\n[[robot]]\nstart = [1.0, 1.0]\n${more}speed = 2.0\n%cells\n`;
  const kind = (more, source = text(more)) => kindOf({ source, cell_size: 0.5 });
  assert.deepEqual(kind("footprint = [[1.0, 0.5], [-1.0, 0.5], [-1.0, -0.5]]\ntarget_heading = -1.5\n"), {
    footprint: [[2, 1], [-2, 1], [-2, -1]],
    aim: -1.5,
  });
  const goals = '[{ target = [0.5, 1.5, 0.25], target_heading = 3.0, arrival = "stop" }, { target = [2.0, 1e0, 0.5] }]';
  assert.deepEqual(kind(`waypoints = ${goals}\n`), { waypoints: [[1, 3, 0.5], [4, 2, 1]] });
  assert.deepEqual(kind(""), {});
  assert.deepEqual(kind("", null), {});
});
