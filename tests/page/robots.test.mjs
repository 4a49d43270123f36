// The panel of robots and their settings, including those from a failure's file.

import assert from "node:assert/strict";
import { test } from "node:test";
import { tick, type } from "./stand_in.mjs";
import { Model } from "#player/edit/model.js";
import { Refused } from "#studio/shared/refusals.js";
import { makeRobots } from "#studio/play/robots.js";
import { makeSettings } from "#studio/play/settings.js";
import { sizePart } from "#studio/draw/size_form.js";
import { LIMITS, blank } from "./samples.mjs";

const both = { thesis: true, lattice: true, fault: null, named: false, motion: "swept" };
const CONTROLLERS = [
  { ...both, name: "thesis-1", also: "turn-right", lattice: false, motion: "stepped" },
  { ...both, name: "thesis-2", also: "turn-left", lattice: false, motion: "stepped" },
  { ...both, name: "turn-left", also: "thesis-2" },
  { ...both, name: "turn-right", also: "thesis-1" },
  { ...both, name: "bug1", also: "", thesis: false },
  { ...both, name: "mine", also: "", thesis: false, fault: { code: "no-such-file", problem: "no such file" }, named: false },
];
const angle = { name: "turn_angle", group: "Behaviours", kind: "float", unit: "rad", default: Math.PI / 2, low: 0, high: Math.PI, choices: [], help: "Angle of a turn." };
const OPTIONS = [
  { name: "drive_ticks", group: "Behaviours", kind: "int", unit: "", default: 4, low: 1, high: 100, choices: [], help: "How long." },
  angle,
  { name: "noise", group: "Sensor", kind: "bool", unit: "", default: false, low: null, high: null, choices: [], help: "Whether it is." },
];
const MOTIONS = [
  { name: "stepped", thesis: true, about: "the thesis's", options: OPTIONS },
  { name: "swept", thesis: false, about: "exact", options: [] },
];

let panels = 0; // each has a folder of its own, so that no set-up is kept for the next one

function panel({ controllers = CONTROLLERS, answer = async () => ({}) } = {}) {
  const asked = [];
  const model = new Model(blank(9, 9), () => {});
  const ask = (kind, message) => {
    asked.push([kind, message]);
    return answer(kind, message);
  };
  const studioPart = { model, folder: `folder ${(panels += 1)}`, showLink: () => {}, connection: { ask }, offered: { controllers, motions: MOTIONS, time_step: 0.015 }, limits: LIMITS };
  const runs = [];
  const robots = makeRobots(studioPart, () => runs.push(robots.message()));
  document.body.append(robots.element);
  robots.refresh();
  const labels = () => robots.element.querySelectorAll(".robots label").map((label) => label.textContent);
  const box = (name) => robots.element.querySelector(`.robots input[value=${name}]`);
  return { robots, labels, box, asked, runs, model, studio: studioPart, part: (selector) => robots.element.querySelector(selector) };
}

const next = () => new Promise((done) => setImmediate(done));

test("a robot with two names is offered once under the thesis's model, with both", () => {
  assert.deepEqual(panel().labels(), ["thesis-1 (turn-right)", "thesis-2 (turn-left)"]);
});

test("a note names the controllers that are not in the list, and the model that they need", () => {
  assert.equal(panel().part("#other-controllers").textContent, "1 more under swept. ");
  const named = CONTROLLERS.map((one) => (one.name === "bug1" ? { ...one, named: true } : one));
  const { robots, part } = panel({ controllers: named });
  assert.equal(robots.message().controllers[0], "bug1");
  const list = robots.element.querySelector(".motion select");
  type(list, "stepped");
  assert.equal(part("#other-controllers").textContent, "1 more under swept, including bug1. ");
});

test("a controller that was named at the start is the first to drive, in its own model", () => {
  const named = [{ ...both, name: "bug2", also: "", named: true, thesis: false }, ...CONTROLLERS];
  const { controllers, motion } = panel({ controllers: named }).robots.message();
  assert.deepEqual([controllers, motion], [["bug2"], "swept"]);
});

test("Run can be pressed whenever a robot is chosen", () => {
  const { box, part, robots } = panel();
  tick(box("thesis-2"), false);
  assert.ok(part("#run").disabled);
  // one of this model's robots is chosen
  type(robots.element.querySelector(".motion select"), "swept");
  assert.ok(!part("#run").disabled);
  assert.equal(robots.message().controllers.length, 1);
});

test("robots that are chosen but not yet run are due", () => {
  const { robots, box, part } = panel();
  robots.running(robots.message());
  assert.equal(part("#run-due").textContent, "");
  tick(box("thesis-1"));
  assert.equal(part("#run-due").textContent, "Not run yet.");
  tick(box("thesis-1"), false);
  assert.equal(part("#run-due").textContent, "");
});

test("a robot with options is added and changed as text, and is listed once", async () => {
  const { part, asked, robots } = panel();
  const field = part("#another");
  const add = async (label) => {
    field.value = label;
    part(".another").dispatchEvent(Object.assign(new Event("submit", { cancelable: true })));
    await next();
  };
  await add("thesis-1+slip=0.3");
  await add("thesis-1+slip=0.3");
  assert.equal(asked[0][1].controller, "thesis-1+slip=0.3");
  assert.deepEqual(robots.message().controllers, ["thesis-2", "thesis-1+slip=0.3"]);
  assert.equal(robots.element.querySelectorAll(".own").length, 1);
  part(".own button").click();
  assert.deepEqual([field.value, robots.element.querySelectorAll(".own").length], ["thesis-1+slip=0.3", 0]);
  assert.deepEqual(robots.message().controllers, ["thesis-2"]);
});

test("an invalid robot is refused at its field, and not added", async () => {
  const { part, robots } = panel({ answer: async () => Promise.reject(new Refused("no controller is called 'nope'")) });
  part("#another").value = "nope";
  part(".another").dispatchEvent(new Event("submit", { cancelable: true }));
  await next();
  assert.equal(part("#another-fault").textContent, "no controller is called 'nope'");
  assert.deepEqual(robots.message().controllers, ["thesis-2"]);
});

test("a failure's settings come and go with its file", () => {
  const { robots } = panel();
  const usual = robots.message();
  robots.prefer({ controller: "thesis-1", motion: "stepped", seed: 7, parameters: { steps: 300, time_step: 0.01, noise: true } });
  const { controllers, seed, steps, time_step: timeStep, options } = robots.message();
  assert.deepEqual([controllers, seed, steps, timeStep, options], [["thesis-1"], 7, 300, 0.01, { noise: true }]);
  robots.forget();
  assert.deepEqual([robots.message().seed, robots.message().steps], [usual.seed, usual.steps]);
});

test("settings typed since then stay when the failure is closed", () => {
  const { robots, part } = panel();
  robots.prefer({ controller: "thesis-1", motion: "stepped", seed: 7, parameters: { steps: 300 } });
  const seed = robots.element.querySelectorAll(".triple input")[2];
  type(seed, "8");
  robots.forget();
  assert.deepEqual([robots.message().seed, robots.message().steps], [8, 300]);
  assert.ok(part(".triple"));
});

test("a failure of a controller that is not offered changes nothing", () => {
  const { robots } = panel();
  const before = robots.message();
  robots.prefer({ controller: "gone", motion: "stepped", seed: 7, parameters: {} });
  assert.deepEqual(robots.message(), before);
});

test("walls are allowed to change places once, and a late answer is ignored", async () => {
  const waiting = [];
  const { robots, part, model, runs } = panel({ answer: (kind) => (kind === "shift" ? new Promise((done) => waiting.push(done)) : Promise.resolve({})) });
  const events = { times: [1], ix: [2], iy: [2], state: [1] };
  tick(part("#changes"));
  tick(part("#changes"), false);
  waiting.shift()({ events });
  await next();
  assert.deepEqual([model.world.events, part("#changes").checked, model.unsaved], [null, false, false]);
  tick(part("#changes"));
  waiting.shift()({ events });
  await next();
  assert.deepEqual([model.world.events, runs.length], [events, 1]);
  robots.refresh();
  assert.match(part(".changes").textContent, /The world changes \(1 change\)/);
  tick(part("#changes"), false);
  assert.equal(robots.message().still, true);
});

test("angles are shown in degrees and sent in radians, with the number of changed settings", () => {
  let changes = 0;
  const settings = makeSettings(() => (changes += 1));
  const values = {};
  settings.offer(OPTIONS, values);
  const [ticks, turn] = settings.element.querySelectorAll("input[type=number]");
  assert.deepEqual([ticks.value, turn.value, turn.max], ["4", "90", "180"]);
  type(turn, "45");
  type(ticks, "6");
  assert.ok(Math.abs(values.turn_angle - Math.PI / 4) < 1e-12 && values.drive_ticks === 6);
  tick(settings.element.querySelector("input[type=checkbox]"));
  const headings = () => settings.element.querySelectorAll(".headings button").map((one) => one.textContent);
  assert.deepEqual(headings(), ["Behaviours 2 changed", "Sensor 1 changed"]);
  type(turn, "90");
  assert.deepEqual([headings()[0], "turn_angle" in values, changes > 2], ["Behaviours 1 changed", false, true]);
});

test("one heading is open at a time", () => {
  const settings = makeSettings(() => {});
  settings.offer(OPTIONS, {});
  const open = () => settings.element.querySelectorAll(".group").filter((one) => !one.hidden).map((one) => one.id);
  const [behaviours, sensor] = settings.element.querySelectorAll(".headings button");
  behaviours.click();
  assert.deepEqual(open(), ["settings-behaviours"]);
  sensor.click();
  assert.deepEqual(open(), ["settings-sensor"]);
  sensor.click();
  assert.deepEqual(open(), []);
});

function sizes() {
  const events = { times: [1, 2], ix: [2, 30], iy: [2, 30], state: [2, 0] };
  const model = new Model({ ...blank(40, 40), events }, () => {});
  const parts = {},
    form = sizePart({ model, limits: LIMITS }, { board: {} }, parts);
  const press = (words) => form.querySelectorAll("button").find((one) => one.textContent === words).click();
  const sized = (width, height) => Object.assign(parts.width, { value: width }) && Object.assign(parts.height, { value: height });
  return { model, form, press, sized, said: () => form.querySelector("#size-said").textContent };
}

test("deleting a schedule with its cells is reported, and undo restores it", () => {
  for (const [act, words] of [
    [({ press }) => press("Clear"), "The world no longer changes: undo restores its 2 changes."],
    [({ press, sized }) => (sized(10, 10), press("New")), "The world no longer changes: undo restores its 2 changes."],
    [({ press, sized }) => (sized(20, 20), press("Resize")), "1 change was outside: undo restores its 2 changes."],
    [({ press, sized }) => (sized(50, 50), press("Resize")), ""],
  ]) {
    const page = sizes();
    act(page);
    assert.equal(page.said(), words);
    page.model.undo();
    assert.equal(page.model.world.events.times.length, 2);
  }
});

test("a world has at least one row and at most four million cells", () => {
  const { model, press, sized, said } = sizes();
  for (const [width, height] of [[50, 1], [1, 50], [20_000, 209]]) {
    sized(width, height);
    press("New");
    assert.deepEqual([model.world.width, model.world.height, model.world.cells.length], [width, height, width * height]);
  }
  for (const [width, height] of [[20_001, 1], [2048, 2049], [0, 5], ["", 5], [2.5, 5]]) {
    sized(width, height);
    press("Resize");
    assert.match(said(), /at most 4,194,304 cells in total/);
    assert.equal(model.world.width, 20_000);
  }
});

test("before the server has sent its limits, no size is accepted", () => {
  const model = new Model(blank(9, 9), () => {}),
    parts = {},
    form = sizePart({ model, limits: null }, { board: {} }, parts);
  Object.assign(parts.width, { value: 5 });
  Object.assign(parts.height, { value: 5 });
  form.querySelectorAll("button").find((one) => one.textContent === "New").click();
  assert.match(form.querySelector("#size-said").textContent, /does not answer yet/);
  assert.equal(model.world.width, 9);
});

test("as many robots can be chosen as the server accepts", () => {
  const { robots, studio, box } = panel();
  studio.limits = { ...LIMITS, robots: 1 };
  robots.refresh();
  tick(box("thesis-2"), false);
  tick(box("thesis-1"));
  assert.deepEqual(robots.message().controllers, ["thesis-1"]);
  assert.equal(box("thesis-2").disabled, true);
});

test("a link with too many robots is not said to have unknown ones", () => {
  const { robots, studio } = panel();
  studio.limits = { ...LIMITS, robots: 1 };
  const follow = (...names) => robots.follow({ robots: names, motion: "stepped", seed: 0 }, {});
  assert.deepEqual(follow("thesis-1", "thesis-2"), ["At most 1 robot can run at once, so only 1 of the link's 2 will."]);
  assert.deepEqual(robots.message().controllers, ["thesis-1"]);
  assert.match(follow("gone", "thesis-1").join(), /^This studio cannot run gone from the link[^A]*$/);
  assert.deepEqual(follow("thesis-2"), []);
});

test("resizing keeps the part that was chosen in its place", () => {
  const { model, form, press, sized } = sizes();
  tick(form.querySelectorAll("input[type=radio]").find((one) => one.title === "Upper right"));
  sized(44, 30);
  press("Resize");
  assert.equal(model.world.start[0], 0.65);
});
