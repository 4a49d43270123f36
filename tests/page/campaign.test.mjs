// What the campaign page says about a campaign, and what its form requests.

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { tick, type } from "./stand_in.mjs";
import { makeForm } from "#studio/campaign/form.js";
import { makeStatus } from "#studio/campaign/status.js";
import { Model } from "#player/edit/model.js";
import { LIMITS, blank } from "./samples.mjs";

const RUNNING = {
  folder: "mine", controller: "turn-right", motion: "swept", seed: "1", worlds: 900, steps: 2_345_678, seconds: 3, running: true, error: null,
  budget: { units: 4, seconds: null }, units: 2, elapsed: null, archive: null, failures: 5,
  met: { "returns-to-a-wall": 17, "stands-still": 4, "crash-KeyError": 2 }, known: { "stands-still": 4 },
  activity: "searching", shrinking: 0, failed: 31,
  strategies: [{ strategy: "native", units: 1, worlds: 800, failures: 9, variants: 1 }, { strategy: "trap", units: 1, worlds: 100, failures: 14, variants: 2 }],
};
const DONE = { ...RUNNING, running: false, units: 4, activity: "done" };
const REFUSED = { code: "scheduler-lost", problem: "the scheduler is gone", remedy: "", terminal: false, opens: "", facts: {}, line: null, source: null };
const A = { group: "returns-to-a-wall", width: 9, height: 3, solid: 21, verdict: "loop" };
const NATURAL = { group: "wanders", width: 7, height: 3, solid: 19, verdict: "loop" };

function status() {
  const done = [];
  const campaign = {
    stopping: null, beginning: new Set(), read: 5, form: { workers: () => 2 },
    wall: { choose: (one) => done.push(one.group), only: (name) => done.push(name) },
    stop: () => done.push("stop"), halt: (folder) => done.push(`halt ${folder}`), goOn: (asked) => done.push(asked),
  };
  const made = makeStatus(campaign);
  const rows = (part) => made.element.querySelectorAll(".tables tbody")[part].children.map((row) => row.children.map((cell) => cell.textContent));
  return { campaign, made, done, rows, line: () => made.element.querySelector("#progress-line").textContent };
}

const smallest = (...failures) => new Map(failures.map((one) => [one.group, one]));

test("the status line and the table have the same causes, and say why one has no picture", () => {
  const { made, rows, line } = status();
  made.show(DONE);
  made.sizes(smallest(A, NATURAL));
  assert.deepEqual(rows(0), [["returns to a wall", "17", "9 x 3, 21 solid"], ["stands still", "4", "known"], ["crash-KeyError", "2", "not kept"], ["wanders", "not by the search", "7 x 3, 19 solid"]]);
  assert.match(line(), /23 failures met4 causes: 1 known, 1 not kept/);
});

test("while the folder is being read, no cause is said to wait for anything", () => {
  const { made, rows, line, campaign } = status();
  campaign.read = 4; // fewer failures than the folder has
  made.show(DONE);
  assert.deepEqual(rows(0).map(([, , size]) => size), ["…", "known", "…"]);
  assert.doesNotMatch(line(), /cause/);
});

test("while a campaign runs, causes without a picture are waiting to be shrunk", () => {
  const { made, rows, line } = status();
  made.show(RUNNING);
  made.sizes(smallest(A));
  assert.deepEqual(rows(0).map(([, , size]) => size), ["9 x 3, 21 solid", "known", "to be shrunk"]);
  assert.match(line(), /^Searching.*unit 2 of 4.*900 worlds2\.3 million steps/);
});

test("preparation does not count towards the budget, and shrinking says how many failures wait", () => {
  const { made, line } = status();
  made.show({ ...RUNNING, activity: "preparing", worlds: 0, budget: { units: null, seconds: 30 }, elapsed: 0 });
  assert.match(line(), /^Preparing.*the 30 s begin after that0 worlds/);
  made.show({ ...RUNNING, activity: "explaining" });
  assert.match(line(), /^Explaining.*natural worlds/);
  made.show({ ...RUNNING, activity: "shrinking", shrinking: 3 });
  assert.match(line(), /^Shrinking 3 failures.*31 not arrived/);
});

test("a single cause is described in the singular", () => {
  const { made, line } = status();
  made.show({ ...DONE, met: { "returns-to-a-wall": 1 } });
  made.sizes(smallest(A));
  assert.match(line(), /1 failure met1 cause\d/);
});

test("the state of the campaign is shown: done, stopped, given up, stopping", () => {
  const words = (state, stopping = null) => {
    const { made, line, campaign } = status();
    campaign.stopping = stopping;
    made.show(state);
    return line().split("turn-right")[0];
  };
  assert.deepEqual(
    [DONE, { ...DONE, activity: "stopped" }, { ...DONE, activity: "gave-up", error: REFUSED }].map((state) => words(state)),
    ["Done", "Stopped", "Gave up"],
  );
  assert.equal(words(RUNNING, "mine"), "Stopping");
});

test("a timed campaign says how much time it has left, and when that has run out", () => {
  const budget = (more) => {
    const { made, line } = status();
    made.show({ ...RUNNING, budget: { seconds: 30, units: null }, ...more });
    return /(seed 1)(.*?)900/.exec(line())[2];
  };
  assert.deepEqual([budget({ elapsed: 12.4 }), budget({ elapsed: 31 }), budget({ running: false, elapsed: null })], ["12 of 30 s", "the 30 s are over; finishing current work", "30 s"]);
});

test("the best so far is the smallest failure, or the longest path if there is none yet", () => {
  const { made, done } = status();
  const archive = { names: ["detour", "density"], edges: [[1.5, 2], [0.1]], cells: [[0, 0, 1, "reached"], [1, 1, 1, "reached"], [2, 0, 1, "loop"]] };
  made.show({ ...RUNNING, met: {}, archive });
  const best = made.element.querySelector("#best-so-far");
  assert.equal(best.textContent, "No failure yet. Longest path so far: 1.5 to 2 times the straight line");
  made.sizes(smallest(NATURAL, A));
  assert.equal(best.textContent, "Best so far:wanders7 x 3 cells, 19 solid");
  // It was hidden while the folder was being read.
  made.sizes(null);
  made.show({ ...RUNNING, archive });
  assert.equal(best.hidden, true);
  made.sizes(smallest(NATURAL, A));
  assert.equal(best.hidden, false);
  best.querySelector("button").click();
  assert.deepEqual(done, ["wanders"]);
});

test("the strategy whose counts grow is marked as the current one", () => {
  const { made, rows } = status();
  made.show(RUNNING);
  const [native, trap] = RUNNING.strategies;
  made.show({ ...RUNNING, strategies: [native, { ...trap, worlds: 160 }] });
  // the one with more variants comes first
  assert.deepEqual(rows(1).map(([name]) => name), ["trap now", "native"]);
});

test("a running campaign can be stopped, a stopped one resumed, and a finished one continued", () => {
  const { made, done } = status();
  const button = () => made.actions.querySelector("button");
  made.show(RUNNING);
  button().click();
  made.show({ ...DONE, units: 3 });
  assert.equal(button().textContent, "Resume");
  button().click();
  made.show(DONE);
  assert.equal(button().textContent, "Continue");
  button().click();
  assert.deepEqual(done, ["stop", { units: 4, known: true, workers: 2 }, { units: 8, known: true, workers: 2 }]);
});

test("a campaign that never begins can be stopped once", () => {
  const { made, done, campaign } = status();
  campaign.beginning.add("mine");
  made.show({ ...DONE, units: 0 });
  const button = made.actions.querySelector("button");
  button.click();
  button.click();
  assert.deepEqual([done, button.textContent], [["halt mine"], "Stop"]);
});

const both = { thesis: false, lattice: true, fault: null, named: false, motion: "swept", also: "" };
const option = { help: "What it does, or ./file.py:name.", default: 60 };
const OFFERED = {
  controllers: [{ ...both, name: "turn-right" }, { ...both, name: "bug1" }, { ...both, name: "./my robots/mine.py:Robot", fault: REFUSED }, { ...both, name: "thesis-1", thesis: true, lattice: false, motion: "stepped" }],
  motions: [{ name: "swept", thesis: false, about: "exact" }, { name: "stepped", thesis: true, about: "the thesis's" }],
  strategies: ["native", "archive"], families: [{ name: "maze" }, { name: "trap" }], cores: 2, known: "known", motion: "swept", time_step: 0.015,
  options: Object.fromEntries(["--robots", "--examples", "--epoch", "--oracle", "--vary", "--shrink", "--baseline"].map((name) => [name, option])),
};

function form({ offered = OFFERED, folder = "/here", played = null, folders = [], states = new Map() } = {}) {
  const begun = [];
  const model = new Model(blank(9, 9), () => {});
  const campaign = {
    studio: { offered, limits: LIMITS, folder, model, play: { played: () => played }, connection: { ask: async () => ({ command: "" }) } },
    folders, states, isListed: true, listed: Promise.resolve(),
    begin: async (message) => begun.push(message), halt() {},
  };
  const made = makeForm(campaign);
  document.body.append(made.element);
  made.refresh();
  const field = (words) => made.element.querySelectorAll(".labelled").find((one) => one.querySelector("label").textContent.startsWith(words)).querySelector("input, select");
  const radio = (value) => made.element.querySelector(`input[value=${value}]`);
  const send = async () => {
    made.element.dispatchEvent(new Event("submit", { cancelable: true }));
    await new Promise((done) => setImmediate(done));
    return begun.at(-1);
  };
  return { made, campaign, field, radio, send, begun, model };
}

beforeEach(() => {
  localStorage.clear();
  document.body.querySelector("form")?.remove();
});

test("an untouched form requests the defaults", async () => {
  const { send } = form();
  assert.deepEqual(await send(), {
    robots: null, time_step: null, examples: null, epoch: null, oracles: [], vary: [], baseline: [], shrink: null,
    folder: "turn-right-swept", controller: "turn-right", motion: "swept", strategies: [], world: null, world_name: null, seed: "1", workers: 2, known: true, seconds: 30,
  });
});

test("a filled form requests the values in it", async () => {
  const { field, radio, send, made } = form();
  type(field("Controller"), "bug1");
  tick(radio("some"));
  tick(radio("maze"));
  tick(radio("units"));
  type(made.element.querySelector("#campaign-amount"), "7");
  type(field("Seed"), " 12 ");
  type(field("Robots"), "3");
  type(field("Worlds per unit"), "9");
  type(field("Oracles"), "turn  wall=3 ");
  const { controller, strategies, units, seconds, seed, robots, examples, oracles, folder } = await send();
  assert.deepEqual([controller, strategies, units, seconds, seed, robots, examples, oracles, folder], ["bug1", ["maze"], 7, undefined, "12", 3, 9, ["turn", "wall=3"], "bug1-swept"]);
});

test("if no strategy is chosen, no campaign begins", async () => {
  const { radio, send, begun, made } = form();
  tick(radio("some"));
  await send();
  assert.equal(begun.length, 0);
  assert.ok(made.element.querySelectorAll(".fault").some((one) => one.textContent === "Choose at least one." && !one.hidden));
});

test("the drawn map is sent with its name if it equals its file", async () => {
  const { radio, send, model } = form();
  tick(radio("drawn"));
  model.change("radius", { robot_radius: 0.08 });
  let sent = await send();
  assert.deepEqual([sent.world.robot_radius, sent.world_name], [0.08, null]);
  model.markSaved("mine.grid", null, "digest", model.mark());
  sent = await send();
  assert.equal(sent.world_name, "mine.grid");
  model.change("radius", { robot_radius: 0.09 });
  sent = await send();
  assert.equal(sent.world_name, null);
});

test("the suggested folder is a new one, and its name has only allowed characters", () => {
  const named = (more) => form(more).field("Folder").value;
  assert.equal(named({ states: new Map([["turn-right-swept", {}]]), folders: [{ name: "turn-right-swept-2", worlds: 1 }] }), "turn-right-swept-3");
  const controllers = [{ ...both, name: "./my robots/mine.py:Robot", named: true }];
  assert.equal(named({ offered: { ...OFFERED, controllers } }), "mine.py-Robot-swept");
});

test("a form begins with what was played last, until the user chooses something", () => {
  const played = { controller: "thesis-1", motion: "stepped", time_step: 0.02 };
  const { field, made, campaign } = form({ played });
  assert.deepEqual([field("Controller").value, field("Motion model").value, field("Time step").value], ["thesis-1", "stepped", "0.02"]);
  type(field("Motion model"), "swept");
  campaign.studio.play.played = () => ({ ...played, controller: "bug1", motion: "swept" });
  made.refresh();
  assert.equal(field("Controller").value, "turn-right");
});

test("choices are remembered for each folder", async () => {
  const first = form();
  type(first.field("Controller"), "bug1");
  tick(first.radio("some"));
  tick(first.radio("maze"));
  type(first.field("Seed"), "12");
  type(first.field("Worlds per unit"), "9");
  const again = form();
  assert.deepEqual([again.field("Controller").value, again.radio("maze").checked, again.field("Seed").value, again.field("Worlds per unit").value], ["bug1", true, "12", "9"]);
  assert.equal(form({ folder: "/elsewhere" }).field("Controller").value, "turn-right");
});

test("a remembered choice that is no longer offered is replaced by the default", () => {
  const none = { state: { controller: "gone", motion: "gone" }, strategies: ["gone"], more: { gone: 1 } };
  localStorage.setItem("worldgen-studio-kept-campaign-form-/here", JSON.stringify(none));
  const { field } = form();
  assert.deepEqual([field("Controller").value, field("Motion model").value], ["turn-right", "swept"]);
});

test("if the studio starts with other controllers, the form begins with those", () => {
  const first = form();
  type(first.field("Controller"), "bug1");
  const mine = { ...both, name: "mine", named: true };
  assert.equal(form({ offered: { ...OFFERED, controllers: [mine, ...OFFERED.controllers] } }).field("Controller").value, "mine");
});

test("a controller that cannot run is not offered", () => {
  const names = form().field("Controller").querySelectorAll("option").map((one) => one.getAttribute("value"));
  assert.deepEqual(names, ["turn-right", "bug1"]);
});

test("pressing Begin twice begins one campaign", async () => {
  const { made, begun } = form();
  for (let k = 0; k < 2; k += 1) made.element.dispatchEvent(new Event("submit", { cancelable: true }));
  await new Promise((done) => setImmediate(done));
  assert.equal(begun.length, 1);
});
