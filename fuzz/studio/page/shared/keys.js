// The keyboard shortcuts of all pages.

import { cameraKeys, clockKeys, keepsKey, keyTable, layerKeys, openKeys } from "#player/keys.js";
import { byId, el } from "#player/dom.js";
import { TOOLS } from "#player/edit/tools.js";

const EVERYWHERE = [
  ["?", "Show these keys"],
  ["d", "Dark or light"],
  ["1, 2, 3, 4", "Draw, play, campaign, compare"],
  ["Ctrl+S", "Save the drawn world"],
  ["Ctrl+Enter", "Run the robots in the drawn world; restart a run"],
  ["Ctrl+M, Ctrl+I", "Go to the board; go to the run in the drawn world"],
  ["Ctrl+O, Ctrl+L", "Open a file"],
  ["Ctrl+B", "Go to the settings of the robots' behaviours"],
  ["Arrows", "Move among tools, and among tabs"],
];
const DRAWING = [
  ...Object.values(TOOLS).map(([words, key]) => [key, words]),
  ["Ctrl+Z, Ctrl+Y", "Undo, redo"],
  ["[ ]", "Make brush or stamp smaller, larger"],
  ["Shift", "While dragging: straight lines, across, up or slanted"],
  ["Arrows, Space", "On the board: move the cursor, use the tool; Shift+Space erases"],
  ["x y .", "Mirror, flip, turn the selection or the stamp"],
  ["Ctrl+C, X, V", "Copy, cut, paste the selection"],
  ["Enter, Delete", "Fill, clear the selection"],
  ["Escape", "Cancel the current stroke"],
  ["# u w v i n", "Grid, ruler, path or cut, the robot's run, signal, its noise filter"],
  ["+ − 0 z", "Zoom; show the whole world; the run; drag with the middle button to move it"],
];
const PLAYING = [
  ["Space, Ctrl+P", "Play, pause"],
  ["← →", "One step; with Shift ten"],
  ["Home End", "Go to the start, to the end"],
  ["l", "Repeat one period of a loop"],
  ["e", "Go to the next marked step"],
  ["> < |", "Timeline: less of the run, more of it, all of it"],
  ["r z", "Follow the robot; zoom to what happens"],
  ["b", "Show or hide the flow chart of the robot's behaviours"],
  ["h", "Drive a robot by hand, with the arrow keys; Escape stops"],
  ["t u s i m w c", "Trail, touched walls, sensors, signal, the robot's memory, witness, changes to come"],
  ["+ − 0", "Zoom; show the whole world"],
];

export function showKeys() {
  const table = (title, rows) => el("div", {}, el("h3", {}, title), keyTable(rows));
  const others = el("div", {}, table("Play", PLAYING), table("Everywhere", EVERYWHERE));
  openKeys(el("div", { class: "key-tables" }, table("Draw", DRAWING), others));
}

/**
 * Starts listening to keys.
 * @param {Studio} studio
 */
export function listen(studio) {
  addEventListener("keydown", (event) => {
    if (byId("keys").open || moveAmong(event)) return;
    const act = commandFor(studio, event) || plainFor(studio, event);
    if (!act) return;
    event.preventDefault();
    act();
  });
}

function commandFor(studio, event) {
  if (!(event.ctrlKey || event.metaKey) || event.altKey) return null;
  const key = event.key.toLowerCase();
  if (key === "s") return () => studio.page() !== "campaign" && settled(event.target, studio.save);
  if (key === "enter") return () => settled(event.target, studio.run);
  const far = {
    m: () => toBoard(studio),
    i: () => studio.go("play"),
    b: () => toSettings(studio),
    o: () => toFiles(studio),
    l: () => toFiles(studio),
    p: studio.page() === "play" && studio.play.player() ? clockKeys(studio.play.player(), 1)[" "] : null,
  }[key];
  if (far && !event.shiftKey) return far;
  if (event.target.matches("input, select, textarea") || studio.page() !== "draw") return null;
  if (key === "z") return event.shiftKey ? studio.redo : studio.undo;
  if (key === "y") return studio.redo;
  const what = { c: "copy", x: "cut", v: "paste" }[key];
  return what ? () => studio.draw.act(what) : null;
}

function toBoard(studio) {
  studio.go("draw");
  studio.draw.canvas.focus();
}

function toFiles(studio) {
  studio.go("draw");
  studio.draw.panel("files");
  byId("tab-files").focus();
}

function toSettings(studio) {
  studio.go("play");
  setTimeout(() => studio.play.settings()); // after the page becomes visible
}

// Moves among the buttons of a toolbar or a row of tabs with arrow keys; a tab opens immediately.
function moveAmong(event) {
  const group = event.target.closest("[role=tablist], [role=toolbar]");
  const by = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 }[event.key];
  if (!group || !by || event.ctrlKey || event.metaKey || event.altKey) return false;
  const all = [...group.querySelectorAll("button")],
    next = all[(all.indexOf(event.target) + by + all.length) % all.length];
  next.focus();
  if (group.role === "tablist") next.click();
  event.preventDefault();
  return true;
}

// Makes a field accept the typed value before an action, by moving the focus away for a moment.
function settled(target, act) {
  if (target.matches("input")) {
    target.blur();
    target.focus();
  }
  act();
}

function plainFor(studio, event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return null;
  const { target, key } = event;
  if (keepsKey(target, key)) return null;
  const keys = {
    "?": showKeys,
    d: () => byId("theme").click(),
    1: () => studio.go("draw"),
    2: () => studio.go("play"),
    3: () => studio.go("campaign"),
    4: () => studio.go("compare"),
  };
  const pages = { draw: () => drawKeys(studio.draw), play: () => playKeys(studio.play, event), campaign: () => ({}), compare: () => ({}) };
  return keys[key] || pages[studio.page()]()[key] || null;
}

function drawKeys(draw) {
  const keys = { "[": () => draw.resize(-1), "]": () => draw.resize(1) };
  for (const [tool, [, key]] of Object.entries(TOOLS)) keys[key] = () => draw.choose(tool);
  Object.assign(keys, {
    "+": () => draw.board.zoom(1.4),
    "=": () => draw.board.zoom(1.4),
    "-": () => draw.board.zoom(1 / 1.4),
    0: () => draw.board.fit(),
    z: () => draw.board.toRun(),
    "#": () => draw.toggle("grid"),
    u: () => draw.toggle("ruler"),
    w: () => draw.toggle("proof"),
    v: () => draw.toggle("run"),
    i: () => draw.toggle("signal"),
    n: () => draw.toggle("noise"),
    x: () => draw.act("mirror"),
    y: () => draw.act("flip"),
    ".": () => draw.act("turn"),
    Delete: () => draw.act("clear"),
    Backspace: () => draw.act("clear"),
    Escape: () => draw.cancel() || draw.choose(draw.tool),
  });
  if (draw.tool === "select" && draw.board.selection) keys.Enter = () => draw.act("fill");
  return keys;
}

function playKeys(play, event) {
  const player = play.player();
  if (!player) return { h: play.drive };
  const keys = { h: play.drive, b: play.chart, ...cameraKeys(player) };
  return Object.assign(keys, layerKeys(player), clockKeys(player, event.shiftKey ? 10 : 1));
}
