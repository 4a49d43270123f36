// The player's clock, its marks and words, and what its keys do.

import assert from "node:assert/strict";
import { test } from "node:test";
import { frame } from "./stand_in.mjs";
import { rangeOf, rounded, short } from "#player/archive.js";
import { buildPlayer } from "#player/controls.js";
import { breakable, grouped, plural } from "#player/dom.js";
import { cameraKeys, clockKeys, keepsKey, layerKeys } from "#player/keys.js";
import { usualSpeed } from "#player/player.js";
import { sceneOf, showInstruments, showRobots } from "#player/robots.js";
import { roomOf, runOf } from "./samples.mjs";

const world = roomOf(9, 5);
const MARKS = [{ step: 29, kind: "entry", name: "Entry", text: "the loop is entered" }];
const loop = () => runOf({ at: Array.from({ length: 134 }, (_, k) => k), x: Array.from({ length: 134 }, (_, k) => 2 + (k % 5)), loop: [29, 104], marks: MARKS });
const still = (steps) => runOf({ at: [0, steps], x: [2, 6] });

function played(drawn) {
  const stage = document.createElement("canvas"),
    under = document.createElement("div");
  const made = buildPlayer(stage, under, { world, ...drawn });
  return { stage, under, made, readout: () => under.querySelector("#readout")?.textContent, scrub: under.querySelector("#scrub") };
}

test("a run is shown at its end, with its step and time", () => {
  const { readout, made } = played({ run: still(300) });
  assert.equal(made.step, 300);
  assert.equal(readout(), "step 300 of 300, 30.000 s");
});

test("the next mark is shown with its words; the first one follows the last", () => {
  const marks = [...MARKS, { step: 77, kind: "novel", name: "Last new cell", text: "the last new cell" }];
  const { readout, made } = played({ run: { ...loop(), marks } });
  made.go(0);
  clockKeys(made, 1).e();
  clockKeys(made, 1).e();
  assert.match(readout(), /^step 77 of 133, 7\.700 s: the last new cell$/);
  clockKeys(made, 1).e();
  assert.match(readout(), /^step 29 of 133, 2\.900 s: the loop is entered$/);
  made.go(133);
  clockKeys(made, 1).e();
  assert.match(readout(), /^step 29 /);
});

test("scrubbing is announced to screen readers, even within a period", () => {
  const { scrub, made } = played({ run: loop() });
  made.go(40);
  assert.equal(scrub.getAttribute("aria-valuetext"), "step 40 of 133, 11 into the period");
  made.go(133);
  assert.match(scrub.getAttribute("aria-valuetext"), /the entry state again/);
});

test("entry and period are marked on the bar", () => {
  const { under } = played({ run: loop() });
  const period = under.querySelector(".period");
  const [x, width] = ["x", "width"].map((name) => Number(period.getAttribute(name)));
  assert.ok(Math.abs(x - (1000 * 29) / 133) < 1e-9 && Math.abs(width - (1000 * 104) / 133) < 1e-9);
});

test("a breach has a tick at its step", () => {
  const marks = [{ step: 30, kind: "breach", name: "Breach", text: "goes through this wall", cell: [4, 2] }];
  const tick = played({ run: { ...still(60), marks } }).under.querySelector(".breach");
  assert.equal(Number(tick.getAttribute("x")) + Number(tick.getAttribute("width")) / 2, 500);
  assert.equal(tick.textContent, "step 30: goes through this wall");
});

test("a played loop continues at its entry, one period later", () => {
  const { made } = played({ run: loop() });
  made.go(0);
  made.speed = 1;
  made.play(true);
  frame(performance.now());
  const steps = [];
  for (let ms = 200; ms < 40_000; ms += 200) {
    frame(performance.now() + ms);
    steps.push(made.step);
  }
  assert.ok(made.playing && Math.max(...steps) < 133);
  const back = steps.findIndex((step, k) => k > 0 && step < steps[k - 1]);
  assert.ok(back > 0 && steps[back] >= 29 && steps[back] < 60, `${steps[back]}`);
});

test("a single period is played repeatedly from its entry", () => {
  const { made, under } = played({ run: loop() });
  clockKeys(made, 1).l();
  assert.deepEqual([made.step, made.playing], [29, true]);
  assert.equal(under.querySelector("[aria-pressed=true]").textContent, "One period");
  made.play(false);
});

test("a run that ends stops there, and play begins it again", () => {
  const { made } = played({ run: still(10) });
  made.go(9);
  made.play(true);
  for (let ms = 200; ms < 2000; ms += 200) frame(performance.now() + ms);
  assert.deepEqual([made.step, made.playing], [10, false]);
  made.play(true);
  assert.ok(made.step < 10 && made.playing);
  made.play(false);
});

test("arrows move one step, or ten with Shift, within the run", () => {
  const { made } = played({ run: still(300) });
  clockKeys(made, 1).Home();
  clockKeys(made, 1).ArrowRight();
  clockKeys(made, 10).ArrowRight();
  assert.equal(made.step, 11);
  clockKeys(made, 10).ArrowLeft();
  clockKeys(made, 10).ArrowLeft();
  assert.equal(made.step, 0);
  clockKeys(made, 1).End();
  assert.equal(made.step, 300);
});

test("from the middle of a step, an arrow moves to the next whole step", () => {
  const { made } = played({ run: still(300) });
  made.go(10.4);
  clockKeys(made, 1).ArrowRight();
  assert.equal(made.step, 11);
  made.go(10.4);
  clockKeys(made, 1).ArrowLeft();
  assert.equal(made.step, 10);
});

test("with several robots, the longest run is played to its end, at a speed that suits it", () => {
  const { made, readout } = played({ run: still(20), others: [{ run: still(4_000), number: 2 }] });
  assert.match(readout(), /^step 4,000 of 4,000/);
  assert.equal(made.speed, usualSpeed(4_000, 0.1));
});

test("a loop next to a longer run is described within its period", () => {
  const { made, readout } = played({ run: loop(), others: [{ run: still(20_000), number: 2 }] });
  made.go(20_000);
  assert.match(readout(), new RegExp(`, ${(20_000 - 29) % 104} into the period$`));
});

test("a replay takes at most twelve seconds, at the slowest possible speed", () => {
  assert.deepEqual([usualSpeed(100, 0.1), usualSpeed(600, 0.1), usualSpeed(10, 0.01), usualSpeed(1e9, 1)], [1, 5, 0.05, 500]);
});

test("each of the run's layers can be switched by its key", () => {
  const { made, under } = played({ run: loop(), sensors: { beams: 4, field: 0, range: 3, signal: true } });
  const names = ["trail", "touched", "sensors", "signal"];
  assert.equal(under.querySelectorAll(".layers input").length, names.length);
  for (const [key, name] of [["t", "trail"], ["u", "touched"], ["s", "sensors"], ["i", "signal"]]) {
    const before = made.show[name];
    layerKeys(made)[key]();
    assert.equal(made.show[name], !before);
  }
});

test("earlier choices stay for the next run", () => {
  const { made } = played({ run: loop() });
  made.show.trail = false;
  const next = buildPlayer(document.createElement("canvas"), document.createElement("div"), { world, run: still(5) }, made);
  assert.equal(next.show.trail, false);
});

test("a world without a run explains why", () => {
  const { under } = played({ run: null });
  assert.match(under.textContent, /could not be run here/);
});

test("zooming out ends at the whole world, which also ends following", () => {
  const { made } = played({ run: loop() });
  clockKeys(made, 1).r();
  assert.ok(made.follow && made.view.scale > 0);
  for (let k = 0; k < 20; k += 1) cameraKeys(made)["-"]();
  assert.deepEqual([made.view, made.follow], [null, false]);
});

test("typing, moving a slider or pressing a button does nothing else", () => {
  const field = (tag, type) => {
    const one = document.createElement(tag);
    if (type) one.type = type;
    return one;
  };
  assert.deepEqual(["d", " ", "ArrowLeft"].map((key) => keepsKey(field("input", "text"), key)), [true, true, true]);
  assert.deepEqual(["d", " ", "ArrowLeft"].map((key) => keepsKey(field("input", "range"), key)), [false, false, true]);
  assert.deepEqual(["d", " ", "ArrowLeft"].map((key) => keepsKey(field("input", "radio"), key)), [false, false, true]);
  assert.deepEqual([" ", "Enter"].map((key) => keepsKey(field("button"), key)), [false, true]);
  assert.deepEqual(["d", " ", "Enter"].map((key) => keepsKey(field("canvas"), key)), [false, false, false]);
});

test("the instruments show the robot's place, heading and step in a loop", () => {
  const line = document.createElement("p");
  showInstruments(line, { drawn: { run: loop(), world }, step: 40 });
  assert.match(line.textContent, /time 4\.000 s.*x, y 0\.200, 0\.100 m.*heading 0\.0°.*collision no.*loop period 104, step 11 of it/);
});

test("a robot that could not drive shows the reason, and the others show their results", () => {
  const list = document.createElement("ol");
  const good = { name: "thesis-1+slip=0.2", verdict: "loop", why: "for ever, every 104 steps", steps: 1331, time: 1.5, path: 2, collisions: 3, digest: "abc" };
  let looked = null;
  showRobots(list, [good, { name: "mine", error: "no such file" }], 0, (number) => (looked = number), "No robot of this size can reach the target.");
  assert.match(list.textContent, /1 thesis-1\+slip=0\.2.*loop.*abc.*1,331 steps, 1\.500 s, 2\.00 m, 3 collisions.*every 104 steps.*No robot of this size/);
  assert.match(list.querySelector(".failed").textContent, /mine did not run.*no such file/);
  list.querySelector("button").click();
  assert.equal(looked, 0);
});

test("each robot has its own number, unless there is only one", () => {
  const robots = [{ name: "a", verdict: "loop", run: loop() }, { name: "b", verdict: "reached", run: still(5) }, { name: "c", error: "no" }];
  const { number, others } = sceneOf(world, robots, 1);
  assert.deepEqual([number, others.map((one) => one.number)], [2, [1]]);
  assert.deepEqual(sceneOf(world, robots, 1).says, ["a: loop", "b: reached", "c: no"]);
  assert.equal(sceneOf(world, [robots[0]], 0).number, null);
});

test("counts are followed by the singular or plural", () => {
  assert.deepEqual([plural(1, "failure"), plural(0, "failure"), plural(2345, "mesh", "meshes")], ["1 failure", "0 failures", "2,345 meshes"]);
  assert.deepEqual([grouped(1234567.6), short(1234567), short(12345), short(0.12345), rounded(1 / 3)], ["1,234,568", "1.23 M", "12.3 k", "0.123", "0.3333"]);
  assert.deepEqual([0, 1, 2].map((k) => rangeOf([1.5, 2], k)), ["below 1.5", "1.5 to 2", "2 and above"]);
  assert.equal(rangeOf([], 0), "any");
});

test("a name can be wrapped before each of its options", () => {
  assert.deepEqual(breakable("thesis-1+slip=0.2+noise").filter((part) => typeof part === "string"), ["thesis-1", "+slip=0.2", "+noise"]);
});
