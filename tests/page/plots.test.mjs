// What the plots of a run show, and which marks the legend explains.

import assert from "node:assert/strict";
import { test } from "node:test";
import "./stand_in.mjs";
import { MARKS } from "#player/picture/marks.js";
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

// The world with one more solid cell.
function withWall(world, ix, iy) {
  const cells = world.open.cells.slice();
  cells[iy * world.width + ix] = 1;
  return { ...world, open: { ...world.open, cells } };
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

test("clearance is negative in a wall, by how deep the robot is in it", () => {
  const { world, run } = straight();
  const inWall = withWall(world, 5, 2);
  const deep = { ...run, open: { ...run.open, series: undefined, x: Float64Array.of(2.5, 4.8, 5.5, 5.5) } };
  const clearance = seriesOf(inWall, deep)[2];
  assert.deepEqual(rounded(clearance.values), [0.1, -0.03, -0.1, -0.1]);
  assert.equal(rounded([clearance.least])[0], -0.1);
});

test("the clearance of a footprint is that of its corners and sides, at its heading", () => {
  const { world, run } = straight();
  const footprint = [[-1, -0.5], [1, -0.5], [1, 0.5], [-1, 0.5]];
  const robot = { target: world.target, radius: Math.hypot(1, 0.5), footprint };
  const at = (heading) => ({ ...run, open: { ...run.open, series: undefined, heading: Float64Array.of(heading, heading, heading, heading) } });
  // Sides are 1 cell from the walls above and below; standing upright, the ends are 0.5 cells away.
  assert.deepEqual(rounded(seriesOf(world, at(0), robot)[2].values), [0.05, 0.1, 0.1, 0.1]);
  assert.deepEqual(rounded(seriesOf(world, at(Math.PI / 2), robot)[2].values), [0.05, 0.05, 0.05, 0.05]);
  const turned = seriesOf(world, at(Math.PI / 4), robot)[2].values[1];
  assert.ok(Math.abs(turned - (1.5 - 1.5 * Math.SQRT1_2) * 0.1) < 1e-9, String(turned));
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
  assert.deepEqual(words({ world, run }), ["start", "began", "target", "trail", "ahead", "end"].map((name) => MARKS[name].label));
  const loops = { ...run, loop: [1, 2], marks: [{ step: 1, kind: "breach", name: "", text: "", cell: [1, 1] }] };
  const more = words({ world: { ...world, cut: [[1, 1]] }, run: loops });
  for (const item of ["the path into the loop", "the period, repeated forever", MARKS.pierced.label, MARKS.cut.label]) assert.ok(more.includes(item), item);
  const caught = words({ world, run: { ...loops, marks: [{ ...loops.marks[0], kind: "caught" }] } });
  assert.ok(caught.includes(MARKS.caught.label) && !caught.includes(MARKS.pierced.label));
  const near = words({ world, run: loops }).filter((item) => [MARKS.short.label, MARKS.barred.label].includes(item));
  assert.equal(near.length, 1);
  const burning = { ...world, open: { ...world.open, events: { ms: [1], ix: [1], iy: [1], state: Float64Array.of(2) } } };
  assert.ok(words({ world: burning, run }).includes("burnt floor"));
});
