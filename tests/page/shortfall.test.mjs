// How near a robot that repeats itself gets: the same as tests/worldgen/test_shortfall.py.

import assert from "node:assert/strict";
import { test } from "node:test";
import "./stand_in.mjs";
import { drivenIn } from "#player/picture/scene_robots.js";
import { shortfallOf } from "#player/picture/shortfall.js";
import { numbers, roomOf, runOf } from "./samples.mjs";

const run = () => runOf({ at: [0, 1, 2, 3], x: [3.5, 5.5, 9.5, 5.5], y: [5.5, 5.5, 5.5, 5.5], bump: [0, 0, 0, 0], loop: [1, 2] });

function nearest(world, drawn = run()) {
  const [one] = drivenIn({ world, run: drawn, step: drawn.steps, number: null, others: [], show: {}, whole: true });
  return shortfallOf(world, one);
}

const room = (solid = [], more = {}) => roomOf(20, 11, solid, { start: [3.5, 5.5, 0], target: [15.5, 5.5, 0.5], radius: 0.7, witness: null, ...more });

test("without a wall in between, the rest of the way is measured", () => {
  const short = nearest(room());
  assert.equal(short.row, 2);
  assert.equal(short.contact, null);
  assert.ok(Math.abs(short.end[0] - 15) < 1e-9);
});

test("a wall in between stops the robot where its rim touches it", () => {
  const short = nearest(room([[12, 5]]));
  assert.ok(Math.abs(short.end[0] - 11.3) < 0.1);
  assert.deepEqual(short.contact, [12, 5.5]);
});

test("a wall that comes later is in between, and one that goes is not", () => {
  const change = (state) => ({ events: { ms: numbers([1000]), ix: numbers([12]), iy: numbers([5]), state: numbers([state]) } });
  assert.ok(nearest(room([], change(1))).contact);
  assert.equal(nearest(room([[12, 5]], change(0))).contact, null);
});

test("a target at a wall is not behind it", () => {
  const target = [15.5, 1.2, 0.5];
  assert.ok(nearest(room([], { target })).contact);
  const witness = { ms: numbers([0, 1]), x: numbers([350, 1550]), y: numbers([550, 170]), per_cell: 100 };
  assert.equal(nearest(room([], { target, witness })).contact, null);
});

test("a run that ends, and a coverage task, have none", () => {
  assert.equal(nearest(room(), { ...run(), loop: null, open: undefined }), null);
  assert.equal(nearest(room(), { ...run(), covers: true }), null);
});
