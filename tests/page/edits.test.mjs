// Edited code: which files have changed, which robots that affects, and what is still offered.

import assert from "node:assert/strict";
import { test } from "node:test";
import "./stand_in.mjs";
import { fileWords, isSame, listenToEdits, noteReported, runsOneOf, stillOffered } from "#studio/shared/edits.js";
import { drawnOf } from "#player/edit/drawn_world.js";
import { cellsAt } from "#player/decode.js";
import { shortName } from "#player/dom.js";
import { refusalWords } from "#studio/shared/refusals.js";
import { blank } from "./samples.mjs";

const file = (name, digest) => ({ file: `/robots/${name}`, name, digest, controllers: ["/robots/mine.py:Robot"] });

// Returns the edits reported when the server sends these lists of files on one connection.
async function edits(known, ...parts) {
  const heard = [];
  const ask = async (kind, message, part) => parts.forEach((files) => part(files));
  await listenToEdits({ ask }, known, (files) => heard.push(files.map(({ name }) => name)));
  return heard;
}

test("a file that is new to the page has not been edited", async () => {
  assert.deepEqual(await edits(new Map(), [file("mine.py", "1")]), []);
  assert.deepEqual(await edits(new Map(), [file("mine.py", "1")], [file("mine.py", "1"), file("gains.py", "1")]), []);
});

test("a file has been edited if its contents differ, even from an earlier connection", async () => {
  const known = new Map();
  const before = [file("mine.py", "1"), file("gains.py", "1")];
  assert.deepEqual(await edits(known, before, [file("mine.py", "1"), file("gains.py", "2")]), [["gains.py"]]);
  assert.deepEqual(await edits(known, [file("mine.py", "3"), file("gains.py", "2")]), [["mine.py"]]);
});

test("a robot with options runs the code of its controller", () => {
  assert.ok(runsOneOf("./mine.py:Robot+slip=0.1", ["./mine.py:Robot"]));
  assert.ok(runsOneOf("behaviours+priority=./mine.py:Robot,wander", ["./mine.py:Robot"]));
  assert.ok(!runsOneOf("bug1", ["./mine.py:Robot"]));
});

test("a robot whose name only contains a controller's name does not run its code", () => {
  for (const other of ["mine.py:Bot2", "./other_mine.py:Bot", "other/mine.py:Bot", "behaviours:wander,mine.py:Bots"])
    assert.ok(!runsOneOf(other, ["mine.py:Bot"]), other);
  for (const same of ["mine.py:Bot", "mine.py:Bot+slip=0.1", "behaviours:wander,mine.py:Bot+gain=2,avoid", "behaviours+by=vote:mine.py:Bot"])
    assert.ok(runsOneOf(same, ["mine.py:Bot"]), same);
});

test("each file is named once", () => {
  assert.equal(fileWords([{ name: "mine.py" }]), "mine.py");
  assert.equal(fileWords([{ name: "a.py" }, { name: "b.py" }, { name: "a.py" }]), "a.py and b.py");
});

test("a controller broken by an edit is still offered, and one that was never loaded is not", () => {
  const mine = { name: "mine", named: true, fault: null, motion: "stepped" };
  const broken = { ...mine, fault: { problem: "it does not compile" }, motion: "swept" };
  assert.deepEqual(stillOffered({ controllers: [mine] }, { controllers: [broken] }).controllers, [mine]);
  assert.deepEqual(stillOffered(null, { controllers: [broken] }).controllers, [broken]);
  assert.deepEqual(stillOffered({ controllers: [broken] }, { controllers: [mine] }).controllers, [mine]);
});

test("the drawn world can be shown before the server has answered, with its changes", () => {
  const world = { ...blank(5, 5), events: { times: [1.5], ix: [2], iy: [3], state: [2] } };
  const drawn = drawnOf(world);
  assert.equal(cellsAt(drawn, 1000)[3 * 5 + 2], 0);
  assert.equal(cellsAt(drawn, 1500)[3 * 5 + 2], 2);
  assert.equal(world.cells[3 * 5 + 2], 0);
});

test("a robot is named after its file without the folders, whatever its options are", () => {
  assert.equal(shortName("/home/me/robots/mine.py:Robot+gain=1/2"), "mine.py:Robot+gain=1/2");
  assert.equal(shortName("lib:./build/mine.so:drive"), "lib:mine.so:drive");
  for (const name of ["bug1", "thesis-1+repaired", "cmd:python robots/mine.py", "robots.mine:Robot"]) assert.equal(shortName(name), name);
});

test("the refusal of failing code says where it fails", () => {
  const refusal = { code: "code-failed", problem: "loading it failed", facts: { kind: "NameError", reason: "name 'x' is not defined" }, line: null, source: null, frames: [{ file: "mine.py", line: 3 }] };
  assert.equal(refusalWords(refusal), "mine.py:3: NameError: name 'x' is not defined");
  assert.equal(refusalWords({ ...refusal, frames: [] }), "loading it failed");
});

const stamp = (code) => ({ world: "w", settings: "s", code: new Map(Object.entries(code)) });

test("a question about a result does not change the result", () => {
  const then = stamp({ a: "1" });
  assert.equal(isSame(then, stamp({ a: "1", b: "2" })), true);
  assert.deepEqual(then, stamp({ a: "1" }));
});

test("a file that is reported later is the result's, and its next edit outdates the result", () => {
  const then = stamp({ a: "1" });
  noteReported(then, stamp({ a: "2", b: "2" }));
  assert.deepEqual(then, stamp({ a: "1", b: "2" }));
  assert.equal(isSame(then, stamp({ a: "1", b: "3" })), false);
});
