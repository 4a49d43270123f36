// What the plots of a run show, and which marks the legend explains.

import assert from "node:assert/strict";
import { test } from "node:test";
import "./stand_in.mjs";
import { legendOf } from "#player/legend.js";
import { seriesOf } from "#player/series.js";
import { drawnOf } from "#player/edit/drawn_world.js";
import { blank } from "./samples.mjs";

// A run straight to the right in a world of 9 x 5 cells of 0.1 m, one cell per step of 0.1 s;
// the last step is idle.
function straight() {
  const world = { ...drawnOf({ ...blank(9, 5), target: [0.75, 0.25, 0.05], robot_radius: 0.05 }) };
  const at = Float64Array.of(0, 1, 2, 3),
    x = Float64Array.of(2.5, 3.5, 4.5, 4.5),
    y = Float64Array.of(2.5, 2.5, 2.5, 2.5);
  const run = { steps: 3, dt: 0.1, loop: null, marks: [], memory: null, open: { at, x, y, heading: x, bump: new Uint8Array(4), active: null } };
  return { world, run };
}

const rounded = (values) => [...values].map((value) => Number(value.toFixed(6)));

test("speed, distance to the target and clearance are in metres and seconds", () => {
  const { world, run } = straight();
  const [speed, distance, clearance] = seriesOf(world, run);
  assert.deepEqual(rounded(speed.values), [1, 1, 1, 0]);
  assert.deepEqual(rounded(distance.values), [0.45, 0.35, 0.25, 0.25]);
  assert.deepEqual(rounded(clearance.values), [0.1, 0.1, 0.1, 0.1]);
  assert.deepEqual([speed.unit, distance.unit, clearance.capped], ["m/s", "m", true]);
  assert.equal(seriesOf(world, run)[0], speed);
});

test("a contact just after a step does not make the robot seem fast", () => {
  const { world, run } = straight();
  // The contact is 0.01 steps after the first step, and its place is rounded up.
  Object.assign(run.open, { at: Float64Array.of(0, 1, 1.01, 2), x: Float64Array.of(2.5, 3.5, 3.53, 4.5) });
  const [speed] = seriesOf(world, run);
  assert.ok(speed.most < 1.03, String(speed.most));
});

test("the legend explains only the marks that are drawn", () => {
  const words = (drawn) => legendOf(drawn).querySelectorAll("li").map((item) => item.textContent);
  const { world, run } = straight();
  assert.deepEqual(words({ world, run }), ["start; the tick is its heading", "target", "the robot's path", "still to be driven", "wall touched"]);
  const loops = { ...run, loop: [1, 2], marks: [{ step: 1, kind: "breach", name: "", text: "", cell: [1, 1] }] };
  const more = words({ world: { ...world, cut: [[1, 1]] }, run: loops });
  for (const item of ["the path into the loop", "the period, repeated forever", "wall entered, or cell that did harm", "the cut that separates start and target"]) assert.ok(more.includes(item), item);
  const burning = { ...world, open: { ...world.open, events: { ms: [1], ix: [1], iy: [1], state: Float64Array.of(2) } } };
  assert.ok(words({ world: burning, run }).includes("burnt floor"));
});
