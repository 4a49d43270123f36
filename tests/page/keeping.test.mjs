// What the browser keeps: choices, drafts of each tab, and what was asked for lately.

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import "./stand_in.mjs";
import { keep, keptOf } from "#studio/shared/kept.js";
import { Model, messageOf } from "#studio/draw/model.js";
import { proofWords } from "#studio/draw/proof.js";
import { Recent } from "#studio/shared/recent.js";
import { blank } from "./samples.mjs";

const DRAFT = "worldgen-studio-draft-";
const held = new Set(); // the locks of tabs that are there
let tabs = 0;

Object.defineProperty(globalThis, "navigator", {
  configurable: true,
  value: {
    locks: {
      query: async () => ({ held: [...held].map((name) => ({ name })) }),
      request: async (name, _, act) => {
        if (held.has(name)) return act(null);
        held.add(name);
        await act({ name });
        held.delete(name);
      },
    },
  },
});

/* The page's drafts as another tab loads them: with a state and a session of its own. */
async function newTab() {
  tabs += 1;
  sessionStorage.clear();
  return import(`../../fuzz/studio/page/shared/drafts.js?tab=${tabs}`);
}

function drawing(...walls) {
  const model = new Model(blank(9, 9), () => {});
  for (const [x, y] of walls) {
    model.paint([{ x, y, width: 1, height: 1 }], 1);
    model.lift("brush");
  }
  return model;
}

/* A draft of a tab that is gone. */
function left(name, model, at) {
  const { world } = model;
  localStorage.setItem(DRAFT + name, JSON.stringify({ name: world.name, file: null, at, world: messageOf(world) }));
}

beforeEach(() => {
  localStorage.clear();
  localStorage.room = Infinity;
  held.clear();
});

test("of many things those are kept that were wanted lately", () => {
  const recent = new Recent(3);
  for (const name of ["a", "b", "c"]) recent.set(name, name);
  recent.get("a");
  recent.set("d", "d");
  assert.deepEqual(["a", "b", "c", "d"].filter((name) => recent.get(name) !== undefined), ["a", "c", "d"]);
});

test("a choice is kept for its folder alone", () => {
  keep("/one", "form", { seed: 7 });
  assert.deepEqual([keptOf("/one", "form"), keptOf("/two", "form"), keptOf("/one", "other")], [{ seed: 7 }, null, null]);
});

test("a browser that keeps nothing, or is full, disturbs nobody", () => {
  localStorage.room = 0;
  keep("/one", "form", { seed: 7 });
  assert.equal(keptOf("/one", "form"), null);
  localStorage.room = Infinity;
  localStorage.setItem("worldgen-studio-kept-form-/one", "{");
  assert.equal(keptOf("/one", "form"), null);
});

test("a draft that is none keeps no page from beginning", async () => {
  for (const text of ["{", "{}", "null", "[]", '{"world": {"cells": "", "width": 9, "height": 9}}', '{"world": 7}']) {
    localStorage.clear();
    localStorage.setItem(`${DRAFT}gone`, text);
    assert.equal(await (await newTab()).findDraft(), null, text);
  }
});

test("a new tab goes on with what a tab has left that is gone, the newest of several", async () => {
  left("old", drawing([2, 2]), 1);
  left("new", drawing([2, 2], [3, 3]), 2);
  const found = await (await newTab()).findDraft();
  assert.equal(found.cells.reduce((sum, cell) => sum + cell), 34);
});

test("a tab does not touch what another one has that is there", async () => {
  left("there", drawing([2, 2]), 1);
  held.add(`${DRAFT}there`);
  assert.equal(await (await newTab()).findDraft(), null);
});

test("a tab that is loaded again goes on with its own drawing", async () => {
  const model = drawing([2, 2]);
  const first = await newTab();
  await first.findDraft();
  assert.ok(first.keepDraft(model));
  const name = sessionStorage.getItem("worldgen-studio-tab");
  held.clear(); // it has ended
  left("newer", drawing([2, 2], [3, 3]), Date.now() + 1000);
  const again = await newTab();
  sessionStorage.setItem("worldgen-studio-tab", name);
  assert.deepEqual((await again.findDraft()).cells, model.world.cells);
});

test("what was taken over is not there for a third tab", async () => {
  left("gone", drawing([2, 2]), 1);
  const second = await newTab();
  const found = await second.findDraft();
  const model = new Model(found, () => {});
  model.paint([{ x: 4, y: 4, width: 1, height: 1 }], 1);
  model.lift("brush");
  second.takeOver(model);
  assert.equal(await (await newTab()).findDraft(), null); // the second one is there, and has it
});

test("what is saved needs no draft", async () => {
  const model = drawing([2, 2]);
  const tab = await newTab();
  await tab.findDraft();
  tab.keepDraft(model);
  assert.equal(Object.keys(localStorage).length, 1);
  model.markSaved("mine.grid", null, "digest", model.mark());
  assert.ok(tab.keepDraft(model));
  assert.equal(Object.keys(localStorage).length, 0);
  assert.equal(tab.openedBefore(), "mine.grid");
});

test("without room the page says that what is drawn is not kept", async () => {
  const tab = await newTab();
  await tab.findDraft();
  localStorage.room = 10;
  assert.equal(tab.keepDraft(drawing([2, 2])), false);
  assert.equal(tab.keepDraft(drawing()), true); // there is nothing to keep
});

test("the oldest of what tabs have left makes room, and no more of it than is needed", async () => {
  for (const [name, at] of [["a", 1], ["b", 2], ["c", 3]]) left(name, drawing([2, 2]), at);
  const tab = await newTab();
  const { setItem } = localStorage;
  await tab.findDraft();
  Object.defineProperty(localStorage, "setItem", {
    configurable: true,
    value(key, text) {
      if (Object.keys(localStorage).length > 2 && !(key in localStorage)) throw new Error("QuotaExceededError");
      setItem.call(localStorage, key, text);
    },
  });
  try {
    assert.ok(tab.keepDraft(drawing([5, 5])));
    assert.deepEqual(["a", "b", "c"].filter((name) => localStorage.getItem(DRAFT + name)), ["b", "c"]);
  } finally {
    delete localStorage.setItem;
  }
});

test("the proof is told in words, with what a robot needs", () => {
  assert.deepEqual(proofWords(null), { head: "", words: "…", kind: "waiting" });
  assert.deepEqual(proofWords({ result: "reachable", length: 4.5678, duration: 2.2839, clearance: 0.123456 }), {
    head: "✓ reachable:",
    words: " 4.57 m, 2.28 s; clearance of the path shown 0.1235 m",
    kind: "good",
  });
  const cut = { result: "blocked", cut: [], ring: 40, reason: "a ring of cells, so and so" };
  assert.deepEqual(proofWords(cut), { head: "✗ blocked:", words: " a ring of 40 wall cells, with gaps too narrow for this robot, separates the start from the target", kind: "bad" });
  assert.deepEqual(proofWords({ result: "undecided", reason: "too large" }), { head: "? undecided:", words: " too large", kind: "waiting" });
  assert.equal(proofWords({ error: "no world" }).kind, "bad");
});
