// What the browser stores: choices, each tab's drafts, and recent requests.

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import "./stand_in.mjs";
import { keep, keepInTab, keptInTab, keptOf } from "#studio/shared/kept.js";
import { Model } from "#player/edit/model.js";
import { messageOf } from "#studio/shared/world_message.js";
import { proofWords } from "#studio/draw/proof.js";
import { Recent } from "#studio/shared/recent.js";
import { blank } from "./samples.mjs";

const DRAFT = "worldgen-studio-draft-";
const held = new Set(); // the locks of open tabs
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

/* Loads the page's drafts as another tab does, with its own state and session. */
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

/* Makes a draft of a closed tab. */
function left(name, model, at) {
  const { world } = model;
  localStorage.setItem(DRAFT + name, JSON.stringify({ name: world.name, file: null, at, world: messageOf(world) }));
}

beforeEach(() => {
  localStorage.clear();
  localStorage.room = Infinity;
  held.clear();
});

test("a full cache keeps the most recently used entries", () => {
  const recent = new Recent(3);
  for (const name of ["a", "b", "c"]) recent.set(name, name);
  recent.get("a");
  recent.set("d", "d");
  assert.deepEqual(["a", "b", "c", "d"].filter((name) => recent.get(name) !== undefined), ["a", "c", "d"]);
});

test("a choice is kept only for its folder", () => {
  keep("/one", "form", { seed: 7 });
  assert.deepEqual([keptOf("/one", "form"), keptOf("/two", "form"), keptOf("/one", "other")], [{ seed: 7 }, null, null]);
});

test("a browser whose storage is disabled or full causes no error", () => {
  localStorage.room = 0;
  keep("/one", "form", { seed: 7 });
  assert.equal(keptOf("/one", "form"), null);
  localStorage.room = Infinity;
  localStorage.setItem("worldgen-studio-kept-form-/one", "{");
  assert.equal(keptOf("/one", "form"), null);
});

test("an invalid draft does not prevent a page from starting", async () => {
  for (const text of ["{", "{}", "null", "[]", '{"world": {"cells": "", "width": 9, "height": 9}}', '{"world": 7}']) {
    localStorage.clear();
    localStorage.setItem(`${DRAFT}gone`, text);
    assert.equal(await (await newTab()).findDraft(), null, text);
  }
});

test("a new tab continues the newest draft of a closed tab", async () => {
  left("old", drawing([2, 2]), 1);
  left("new", drawing([2, 2], [3, 3]), 2);
  const found = await (await newTab()).findDraft();
  assert.equal(found.cells.reduce((sum, cell) => sum + cell), 34);
});

test("a tab does not touch the draft of another open tab", async () => {
  left("there", drawing([2, 2]), 1);
  held.add(`${DRAFT}there`);
  assert.equal(await (await newTab()).findDraft(), null);
});

test("a reloaded tab continues its own drawing", async () => {
  const model = drawing([2, 2]);
  const first = await newTab();
  await first.findDraft();
  assert.ok(first.keepDraft(model));
  const name = sessionStorage.getItem("worldgen-studio-tab");
  held.clear(); // the tab is closed
  left("newer", drawing([2, 2], [3, 3]), Date.now() + 1000);
  const again = await newTab();
  sessionStorage.setItem("worldgen-studio-tab", name);
  assert.deepEqual((await again.findDraft()).cells, model.world.cells);
});

test("a reloaded tab knows how its world was generated, until it was changed", async () => {
  const shows = { family: "maze", world_seed: "3", parameters: "" };
  for (const isChanged of [false, true]) {
    localStorage.clear();
    held.clear();
    const model = drawing([2, 2]);
    model.markMade(shows);
    if (isChanged) {
      model.paint([{ x: 4, y: 4, width: 1, height: 1 }], 1);
      model.lift("brush");
    }
    const first = await newTab();
    await first.findDraft();
    assert.ok(first.keepDraft(model));
    held.clear();
    const again = await newTab();
    await again.findDraft();
    assert.deepEqual(again.linkOfDraft(), isChanged ? null : shows);
  }
});

test("the set-up of a tab is its own, and a new tab begins with the last one", () => {
  keep("/tabs", "play", { steps: 1 });
  keepInTab("/tabs", "play", { steps: 1 });
  keep("/tabs", "play", { steps: 2 }); // in another tab
  assert.deepEqual(keptInTab("/tabs", "play"), { steps: 1 });
  sessionStorage.clear();
  assert.equal(keptInTab("/tabs", "play"), null);
  assert.deepEqual(keptOf("/tabs", "play"), { steps: 2 });
});

test("a draft that was taken over is not offered to a third tab", async () => {
  left("gone", drawing([2, 2]), 1);
  const second = await newTab();
  const found = await second.findDraft();
  const model = new Model(found, () => {});
  model.paint([{ x: 4, y: 4, width: 1, height: 1 }], 1);
  model.lift("brush");
  second.takeOver(model);
  assert.equal(await (await newTab()).findDraft(), null); // the second tab is open and has it
});

test("a saved drawing needs no draft", async () => {
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

test("if the storage is full, the page says that the drawing is not kept", async () => {
  const tab = await newTab();
  await tab.findDraft();
  localStorage.room = 10;
  assert.equal(tab.keepDraft(drawing([2, 2])), false);
  assert.equal(tab.keepDraft(drawing()), true); // nothing to keep
});

test("the oldest drafts of closed tabs make room, and no more of them than necessary", async () => {
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

test("the proof is described in words, with the width that a robot needs", () => {
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
