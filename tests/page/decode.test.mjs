// Streams of numbers and bits, worlds and runs, as the pages read them.

import assert from "node:assert/strict";
import { test } from "node:test";
import "./stand_in.mjs";
import { cellsAt, numbersOf, openWorld, poseAt, rowAt, stateAt, stepWithin, SOLID } from "#player/decode.js";
import { numbers, runOf, worldOf } from "./samples.mjs";

test("numbers are decoded exactly, including large, negative and evenly growing ones", () => {
  for (const values of [[], [0], [1, 2, 3, 4], [-5, 5, -5], [2 ** 50, 0, -(2 ** 40)], [64, 128, 8191, 8192]])
    assert.deepEqual([...numbersOf(numbers(values))], values);
});

test("bits are decoded if a row ends within a byte", () => {
  const cells = Array.from({ length: 15 }, (_, k) => k % 3 === 0);
  assert.deepEqual([...openWorld(worldOf(cells, 5)).cells], cells.map(Number));
});

test("everything outside the world is solid", () => {
  const world = worldOf([0, 0, 0, 0], 2);
  assert.deepEqual([[-1, 0], [0, -1], [2, 0], [0, 2]].map(([ix, iy]) => stateAt(cellsAt(world, 0), world, ix, iy)), [SOLID, SOLID, SOLID, SOLID]);
  assert.equal(stateAt(cellsAt(world, 0), world, 1, 1), 0);
});

test("cells change at their times, forwards and backwards", () => {
  const events = { ms: numbers([300, 600]), ix: numbers([1, 1]), iy: numbers([0, 0]), state: numbers([2, 0]) };
  const world = { ...worldOf([0, 0, 0, 1], 2), events };
  assert.deepEqual([0, 299, 300, 599, 600, 450, 0].map((ms) => cellsAt(world, ms)[1]), [0, 0, 2, 2, 0, 2, 0]);
});

test("a step's row is the last one that is not later", () => {
  const run = runOf({ at: [0, 1, 1.5, 4], x: [0, 1, 2, 3] });
  assert.deepEqual([0, 0.9, 1, 1.2, 1.5, 3.9, 4, 99].map((step) => rowAt(run, step)), [0, 0, 1, 1, 2, 2, 3, 3]);
});

test("between two rows, the robot is on the straight line that joins them", () => {
  const run = runOf({ at: [0, 2], x: [1, 3], y: [0, 4], heading: [0, Math.PI / 2] });
  const { x, y, heading } = poseAt(run, 0.5);
  assert.deepEqual([x, y], [1.5, 1]);
  assert.ok(Math.abs(heading - Math.PI / 8) < 1e-3);
});

test("after its end, a loop continues at its entry, and any other run stays where it is", () => {
  const run = runOf({ at: [0, 133], x: [0, 1], loop: [29, 104] });
  assert.deepEqual([100, 133, 134, 133 + 104, 133 + 105].map((step) => stepWithin(run, step)), [100, 133, 30, 29, 30]);
  assert.equal(stepWithin({ ...run, loop: null }, 500), 133);
});
