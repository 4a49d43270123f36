// What each key does, on which page, and which elements handle keys themselves.

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { element, point, press } from "./stand_in.mjs";
import { showTabs } from "#studio/shared/fields.js";
import { listen } from "#studio/shared/keys.js";
import { TOOLS } from "#player/edit/tools.js";

const done = [];
const note = (what) => () => done.push(what);
const player = { drawn: { run: { marks: [], loop: null } }, show: {}, playing: false, step: 5, play: (on) => done.push(`play ${on}`), go: (step) => done.push(`go ${step}`), update() {}, fit: note("fit"), zoom: (by) => done.push(`zoom ${by > 1}`) };
const draw = {
  tool: "brush",
  board: { selection: null, zoom: (by) => done.push(`board ${by > 1}`), fit: note("board fit") },
  choose: (tool) => done.push(`tool ${tool}`), act: (what) => done.push(`act ${what}`), resize: (by) => done.push(`size ${by}`),
  canvas: { focus: note("board") },
  toggle: (name) => done.push(`toggle ${name}`), cancel: () => false, panel: (name) => done.push(`panel ${name}`),
};
let page = "draw";
let there = player;
const all = {
  page: () => page, draw, play: { player: () => there, settings: note("settings") },
  undo: note("undo"), redo: note("redo"), save: note("save"), run: note("run"), go: (name) => done.push(`go ${name}`),
};

element("keys", "dialog");
element("theme", "button").addEventListener("click", note("theme"));
element("tab-files", "button");
listen(all);

function does(key, held = {}, at = document.body) {
  done.length = 0;
  press(key, { at, ...held });
  return done.join();
}

const CTRL = { ctrlKey: true };
beforeEach(() => {
  page = "draw";
  there = player;
});

test("every tool has its own key, which nothing else uses", () => {
  const names = Object.keys(TOOLS);
  assert.deepEqual(names.map((name) => does(TOOLS[name][1])), names.map((name) => `tool ${name}`));
  assert.equal(new Set(names.map((name) => TOOLS[name][1])).size, names.length);
});

test("on the board, keys undo, save, copy and switch pages", () => {
  const keys = { z: "undo", y: "redo", s: "save", c: "act copy", x: "act cut", v: "act paste", m: "go draw,board", i: "go play", Enter: "run" };
  assert.deepEqual(Object.keys(keys).map((key) => does(key, CTRL)), Object.values(keys));
  assert.equal(does("Z", { ...CTRL, shiftKey: true }), "redo");
  assert.deepEqual(["1", "2", "3", "d"].map((key) => does(key)), ["go draw", "go play", "go campaign", "theme"]);
});

test("a selection can be filled with Enter, cleared, mirrored and turned", () => {
  assert.deepEqual(["Delete", "x", "y", "."].map((key) => does(key)), ["act clear", "act mirror", "act flip", "act turn"]);
  assert.equal(does("Enter"), "");
  Object.assign(draw, { tool: "select", board: { ...draw.board, selection: {} } });
  assert.equal(does("Enter"), "act fill");
  Object.assign(draw, { tool: "brush" });
});

test("the thesis's keys do what they did, if the browser passes them to the page", () => {
  page = "play";
  assert.equal(does("p", CTRL), "play true");
  assert.equal(does("m", CTRL), "go draw,board");
  assert.equal(does("l", CTRL), "go draw,panel files");
  assert.equal(document.activeElement.id, "tab-files");
  assert.equal(does("b", CTRL), "go play");
  document.body.focus();
});

test("on the Play page, keys play, step and switch layers", () => {
  page = "play";
  assert.deepEqual([" ", "ArrowRight", "Home"].map((key) => does(key)), ["play true", "play false,go 6", "play false,go 0"]);
  assert.equal(does("ArrowRight", { shiftKey: true }), "play false,go 15");
  assert.deepEqual(["+", "-", "0"].map((key) => does(key)), ["zoom true", "zoom false", "fit"]);
  there = null;
  assert.equal(does(" "), "");
});

test("Space plays after a click on a button, a box or a list, and presses a control that was reached with Tab", () => {
  page = "play";
  const box = element("box", "input");
  box.type = "checkbox";
  for (const one of [box, element("theme"), element("speed", "select")]) {
    point(document.body, "pointerdown", [0, 0]);
    assert.equal(does(" ", {}, one), "play true");
    press("Tab");
    assert.equal(does(" ", {}, one), "");
  }
  point(document.body, "pointerdown", [0, 0]);
});

test("Space presses a button of a dialog even if a script has moved the focus there", () => {
  page = "play";
  point(document.body, "pointerdown", [0, 0]);
  const dialog = element("question", "dialog");
  const button = document.createElement("button");
  dialog.append(button);
  assert.equal(does(" ", {}, button), "");
  const outside = element("outside", "button");
  assert.equal(does(" ", {}, outside), "play true");
});

test("a key of one page does nothing on another", () => {
  page = "campaign";
  assert.deepEqual(["b", "g", " ", "Delete"].map((key) => does(key)), ["", "", "", ""]);
  assert.deepEqual([does("s", CTRL), does("z", CTRL)], ["", ""]);
});

test("Space plays from a number's field too, because a number has no spaces", () => {
  page = "play";
  const field = element("steps", "input");
  field.type = "number";
  assert.deepEqual([does(" ", {}, field), does("ArrowLeft", {}, field)], ["play true", ""]);
});

test("in a field, keys type letters, and Ctrl+Z belongs to the field", () => {
  const field = element("field", "input");
  field.type = "text";
  assert.deepEqual(["b", "1", "?"].map((key) => does(key, {}, field)), ["", "", ""]);
  assert.equal(does("z", CTRL, field), "");
  assert.equal(does("s", CTRL, field), "save");
});

test("while the list of keys is open, no key does anything else", () => {
  element("keys").open = true;
  assert.equal(does("b"), "");
  element("keys").open = false;
  assert.equal(does("b"), "tool brush");
});

test("arrow keys cycle through tools and tabs, and open a tab at once", () => {
  const opened = [];
  const group = (role, tabs) => {
    const place = element(role);
    place.role = role;
    place.replaceChildren(...tabs.map((name) => {
      const button = document.createElement("button");
      button.id = name;
      button.addEventListener("click", () => opened.push(name));
      return button;
    }));
    return place.children;
  };
  const [brush, eraser] = group("toolbar", ["brush", "eraser"]);
  press("ArrowDown", { at: brush });
  assert.equal(document.activeElement, eraser);
  press("ArrowDown", { at: eraser });
  assert.deepEqual([document.activeElement, opened], [brush, []]);
  const [world] = group("tablist", ["world", "maker", "files"]);
  press("ArrowLeft", { at: world });
  assert.deepEqual([document.activeElement.id, opened], ["files", ["files"]]);
});

test("the Tab key stops only at the open tab", () => {
  const tabs = ["a", "b"].map((id) => Object.assign(document.createElement("button"), { id }));
  showTabs(tabs, "b");
  assert.deepEqual(tabs.map((tab) => [tab.tabIndex, tab.getAttribute("aria-selected")]), [[-1, "false"], [0, "true"]]);
});
