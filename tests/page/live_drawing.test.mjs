// The drawing is judged in the page: what that asks of the server, and when the server decides.

import assert from "node:assert/strict";
import { gzipSync } from "node:zlib";
import { test } from "node:test";
import "./stand_in.mjs";
import { Model } from "#player/edit/model.js";
import { makeJudge } from "#studio/draw/judge.js";
import { blank } from "./samples.mjs";

const packed = (text) => gzipSync(text).toString("base64");
const CORE = { prover: packed("p"), simulator: packed("s"), script: packed("w") };
const PROOF = { reachable: true, reason: "a path", witness: { t: [0, 2], x: [0.1, 0.5], y: [0.1, 0.4], clearance: 0.1 }, cut: null };
const RUN = { verdict: "loop", steps: 12, entry: 2, period: 10, drawn: { steps: 12 } };

// A worker that answers at once, or fails.
class Worker_ {
  static questions = [];
  static fault = "";

  postMessage({ number, question, modules }) {
    const answer = { proof: PROOF, run: question?.run ? RUN : null, live: { proof: "", run: "" } };
    if (question) Worker_.questions.push(question);
    const data = modules ? { ready: true } : Worker_.fault ? { number, failed: Worker_.fault } : { number, answer };
    setTimeout(() => this.onmessage({ data }));
  }

  terminate() {}
}

const until = async (holds) => {
  while (!holds()) await new Promise((done) => setTimeout(done, 1));
};

async function drawing(world = blank(9, 9)) {
  globalThis.Worker = Worker_;
  URL.createObjectURL ??= () => "blob:";
  URL.revokeObjectURL ??= () => {};
  Object.assign(Worker_, { questions: [], fault: "" });
  const asked = [],
    seen = [],
    setup = { controllers: ["turn-left", "bug1"], motion: "swept", time_step: 0.015, seed: 0, steps: null, options: {}, still: false };
  const ask = async (kind, message) => {
    asked.push([kind, message]);
    return kind === "core" ? CORE : { world: { speed: 2 }, run: { steps: 50 }, why: "" };
  };
  let failed = 0;
  const studio = { model: new Model(world, () => {}), connection: { ask }, play: { setup: () => setup }, say() {} };
  const judge = makeJudge(studio, (...given) => seen.push(given), () => (failed += 1));
  await judge.open();
  return { judge, studio, asked, seen, setup, failed: () => failed };
}

test("nothing is judged in the page before it has the core", async () => {
  const studio = { model: new Model(blank(9, 9), () => {}), play: { setup: () => ({}) } };
  assert.equal(makeJudge(studio, () => {}, () => {}).judge(), false);
});

test("each change of the drawing is judged in the page, with the run of the first robot", async () => {
  const { judge, studio, asked, seen } = await drawing();
  await until(() => seen.some(([, run]) => run));
  const count = asked.length;
  studio.model.paint([{ x: 4, y: 4, width: 1, height: 1 }], 1);
  assert.equal(judge.judge(), true);
  const before = seen.length;
  await until(() => seen.length > before);
  const [proof, run, robot] = seen.at(-1);
  assert.deepEqual([proof.result, proof.duration, run.verdict, robot], ["reachable", 2, "loop", "turn-left"]);
  assert.equal(Worker_.questions.at(-1).world.cells[4], "#...#...#");
  assert.deepEqual(asked.slice(count), []); // the server was not asked again
});

test("other settings or another robot are asked for once, whatever is drawn", async () => {
  const { judge, asked, seen, setup } = await drawing();
  await until(() => seen.some(([, run]) => run));
  setup.controllers = ["bug1"];
  judge.judge();
  judge.judge();
  const recipes = asked.filter(([kind]) => kind === "recipe");
  assert.deepEqual(recipes.map(([, message]) => message.controller), ["turn-left", "bug1"]);
  assert.deepEqual(Object.keys(recipes[1][1]).sort(), ["controller", "motion", "options", "seed", "steps", "still", "time_step", "world"]);
});

test("the server decides large worlds, several robots, and worlds that change", async () => {
  const changing = { ...blank(9, 9), events: { times: [1], ix: [4], iy: [4], state: [1] } };
  assert.equal((await drawing(changing)).judge.judge(), false);
  assert.equal((await drawing(blank(600, 600))).judge.judge(), false);
  const fleet = { ...blank(9, 9), others: [{ start: [0.15, 0.15, 0], target: [0.5, 0.5, 0.05], radius: 0.05 }] };
  assert.equal((await drawing(fleet)).judge.judge(), false);
});

test("after a fault in the worker, the server decides", async () => {
  const page = await drawing();
  await until(() => page.seen.some(([, run]) => run));
  Worker_.fault = "out of memory";
  assert.equal(page.judge.judge(), true);
  await until(() => page.failed() === 1);
  assert.equal(page.judge.judge(), false);
});
