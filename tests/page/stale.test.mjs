// Results are grey unless they are about the world, the settings and the code on the screen, in
// whatever order the answers arrive.

import assert from "node:assert/strict";
import { test } from "node:test";
import { type } from "./stand_in.mjs";
import { askAbout, askToOpen } from "#studio/shared/asking.js";
import { Ended } from "#studio/shared/connection.js";
import { Refused } from "#studio/shared/refusals.js";
import { makePlay } from "#studio/play/play.js";
import { Model } from "#player/edit/model.js";
import { LIMITS, blank, roomOf, runOf } from "./samples.mjs";

const CODE = { file: "/robots/mine.py", name: "mine.py", controllers: ["mine.py:Robot"] };
const CONTROLLERS = [
  { name: "mine.py:Robot", also: "", thesis: true, lattice: true, fault: null, named: true, motion: "swept" },
  { name: "bug1", also: "", thesis: false, lattice: true, fault: null, named: false, motion: "swept" },
];
const settled = () => new Promise((done) => setImmediate(done));
let folders = 0;

// The page Play with one robot, whose requests wait until the test answers them.
function play() {
  const asked = [];
  const ask = (kind, message, part) => {
    let settle;
    const answer = Object.assign(new Promise((done, fail) => (settle = { done, fail })), { stop: () => {} });
    asked.push({ kind, message, part, ...settle });
    return answer;
  };
  const offered = { controllers: CONTROLLERS, motions: [{ name: "swept", thesis: false, about: "exact", options: [] }], time_step: 0.015 };
  const studio = { folder: `stale ${(folders += 1)}`, code: [{ ...CODE, digest: "old" }], showLink: () => {}, page: () => "play", connection: { ask }, offered, limits: LIMITS };
  studio.model = new Model(blank(9, 9), () => studio.play?.changed());
  const section = document.createElement("section");
  document.body.append(section);
  studio.play = makePlay(section, studio);
  studio.play.refresh();
  const begun = () => asked.filter(({ kind }) => kind === "run").at(-1);
  const give = (code, request = begun()) => {
    request.part({ world: roomOf(9, 9), impossible: "" }, code ?? {});
    request.part({ number: 0, name: "mine.py:Robot", verdict: "loop", why: "", frames: [], steps: 2, time: 0.03, path: 0, collisions: 0, digest: "d", run: runOf({ at: [0, 2], x: [1, 2] }), others: [], sensors: null, arbitration: null }, code ?? {});
  };
  const finish = async (code, request = begun()) => {
    give(code, request);
    request.done({});
    await settled();
  };
  const isGrey = () => section.querySelector("ol").classList.contains("stale");
  return {
    studio, begun, give, finish, isGrey, asked,
    drive: () => studio.play.drive(),
    said: () => section.querySelector("#run-said").textContent,
    run: () => studio.play.run(),
    edit: () => (studio.model.paint([{ x: 3, y: 3, width: 1, height: 1 }], 1), studio.model.lift("wall")),
    set: () => type(section.querySelectorAll("input[type=number]")[1], "77"),
    recode: (digest) => {
      studio.code = [{ ...CODE, digest }];
      studio.play.changed();
    },
  };
}

const CHANGES = { world: (page) => page.edit(), settings: (page) => page.set(), code: (page) => page.recode("new") };

for (const [what, change] of Object.entries(CHANGES)) {
  test(`a result is grey once its ${what} has changed`, async () => {
    const page = play();
    page.run();
    await page.finish();
    assert.equal(page.isGrey(), false);
    change(page);
    assert.equal(page.isGrey(), true);
  });

  test(`a result is grey if its ${what} changed before it arrived`, async () => {
    const page = play();
    page.run();
    change(page);
    await page.finish();
    assert.equal(page.isGrey(), true);
  });
}

test("a result is about the screen again after the change has been undone", async () => {
  const page = play();
  page.run();
  await page.finish();
  page.edit();
  page.studio.model.undo();
  assert.equal(page.isGrey(), false);
  page.recode("new");
  page.recode("old");
  assert.equal(page.isGrey(), false);
});

test("saving the world does not make its result grey", async () => {
  const page = play();
  page.run();
  await page.finish();
  page.studio.model.markSaved("w.grid", "its text", "its digest", page.studio.model.mark());
  assert.equal(page.isGrey(), false);
});

test("a result names the code that ran, whether the page has heard of the edit before or after", async () => {
  const page = play();
  page.run(); // the server loads the new code, and reports the edit later
  await page.finish({ [CODE.file]: "new" });
  assert.equal(page.isGrey(), true);
  page.recode("new");
  assert.equal(page.isGrey(), false);

  page.run(); // the server had loaded the old code already
  page.recode("newer");
  await page.finish({ [CODE.file]: "new" });
  assert.equal(page.isGrey(), true);
});

test("a result of an earlier run does not replace that of a later one", async () => {
  const page = play();
  page.run();
  const first = page.begun();
  page.edit();
  page.run();
  await page.finish();
  await page.finish(undefined, first);
  assert.equal(page.isGrey(), false);
});

test("what is said about driving stays when the run is over during which it was begun", async () => {
  const page = play();
  page.run();
  page.give();
  page.drive();
  page.begun().done({});
  await settled();
  const said = page.said();
  page.studio.play.pause(); // ends the drive, and with it its clock
  assert.match(said, /arrow keys/);
});

test("another world is run as soon as it is there, and only once", async () => {
  const page = play();
  page.studio.play.begin();
  await page.finish();
  page.studio.model.change("open another", blank(11, 11));
  page.studio.play.begin();
  page.studio.play.begin();
  assert.equal(page.asked.filter(({ kind }) => kind === "run").length, 2);
  await page.finish();
  assert.equal(page.isGrey(), false);
});

// Requests whose answers wait for the test.
function waiting() {
  const asked = [];
  const ask = (kind, message, part) => new Promise((done, fail) => asked.push({ done, fail, part }));
  return { asked, connection: { ask } };
}

test("an answer about something that has changed is dropped, with its parts and its error", async () => {
  for (const end of ["done", "fail"]) {
    const { asked, connection } = waiting();
    let version = 1;
    const parts = [];
    const answer = askAbout(connection, () => version, "decide", {}, (part) => parts.push(part));
    asked[0].part("before");
    version = 2;
    asked[0].part("after");
    asked[0][end](end === "done" ? {} : new Refused("no"));
    await assert.rejects(answer, Ended);
    assert.deepEqual(parts, ["before"]);
  }
});

test("an answer about what is still there arrives, and so does its error", async () => {
  const { asked, connection } = waiting();
  const answers = ["done", "fail"].map(() => askAbout(connection, () => 1, "decide", {}));
  asked[0].done("proof");
  asked[1].fail(new Refused("no"));
  assert.equal(await answers[0], "proof");
  await assert.rejects(answers[1], Refused);
});

test("of two worlds that are opened, the last one asked for is shown, in either order", async () => {
  for (const order of [[0, 1], [1, 0]]) {
    const { asked, connection } = waiting();
    const shown = [];
    const opens = ["generate", "open"].map((kind) => askToOpen(connection, kind, {}).then((world) => shown.push(world), () => {}));
    for (const k of order) {
      asked[k].done(`world ${k}`);
      await settled();
    }
    await Promise.all(opens);
    assert.deepEqual(shown, ["world 1"]);
  }
});
