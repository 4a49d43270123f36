// The comparison's worlds and table.

import assert from "node:assert/strict";
import { test } from "node:test";
import "./stand_in.mjs";
import { makeTable } from "#studio/compare/table.js";
import { sourcesOf, worldsOf } from "#studio/compare/worlds.js";
import { joinNames, splitNames } from "#studio/shared/links.js";

const FILES = [
  { name: "a.grid", world: true, found: false },
  { name: "maps/b.grid", world: true, found: false },
  { name: "maps/c.grid", world: true, found: false },
  { name: "maps/d.png", world: false, found: false },
];
const OPEN = { name: "", world: /** @type {any} */ ({ width: 3 }) };

test("folders are listed with their numbers of worlds", () => {
  const words = Object.fromEntries(sourcesOf(FILES));
  assert.equal(words["folder:"], "The opened folder (1 world)");
  assert.equal(words["folder:maps"], "maps (2 worlds)");
});

test("only the folder's own worlds are listed, and unknown values are omitted", () => {
  assert.deepEqual(worldsOf(["folder:maps", "folder:gone", "nonsense"], FILES, OPEN).map(({ file }) => file), ["maps/b.grid", "maps/c.grid"]);
  assert.deepEqual(worldsOf(["open"], FILES, OPEN), [{ name: "the open world", world: OPEN.world }]);
});

test("names with commas survive a link", () => {
  const names = ["behaviours:avoid+angle=2,follow", "bug2", "50%2C"];
  assert.deepEqual(splitNames(joinNames(names)), names);
});

test("each cell shows its verdict as a colour and a word, with the details in words", () => {
  const chosen = [];
  const table = makeTable((row, column) => chosen.push([row, column]));
  table.begin(["bug2", "vfh"], [{ name: "trap" }, { name: "broken" }]);
  const cell = { row: 0, detail: "period 104", steps: 1511, time: null, runs: 1, reached: 0, seed: 4 };
  table.take({ row: 0, column: 0, verdict: "loop", ...cell });
  table.take({ row: 0, column: 1, verdict: "reached", ...cell, time: 4.95, detail: "", runs: 20, reached: 19 });
  table.take({ row: 0, best: [1] });
  table.take({ row: 1, error: { problem: "it is broken", remedy: "mend it" } });
  table.totals([{ reached: 0, runs: 1, wins: 0, shared: 0 }, { reached: 19, runs: 20, wins: 1, shared: 0 }], 1);
  const [loop, reached] = table.element.querySelectorAll(".cell");
  assert.equal(loop.parentElement.dataset.verdict, "loop");
  assert.match(loop.textContent, /↻ loopperiod 104, 1,511 steps/);
  assert.match(reached.textContent, /reachedfastest19 of 20, 4.95 s/);
  assert.match(table.element.textContent, /it is broken/);
  assert.match(table.element.textContent, /All \(1 of 2 worlds\)0 of 1 arrive19 of 20 arrive, fastest in 1/);
  loop.hear({ type: "click" });
  assert.deepEqual(chosen, [[0, 0]]);
  assert.equal(table.seedOf(0, 0), 4);
});
