// The page for drawing worlds: tools, board and panels, and facts about the world below them.

import { choice, el, grouped, keepFocus, keyButton, shortName, verdictDot } from "#player/dom.js";
import { proofWords, runWords } from "#player/edit/answer.js";
import { makeBoard } from "#player/edit/board.js";
import { showTabs } from "#studio/shared/fields.js";
import { makeFiles } from "#studio/draw/files.js";
import { makeMaker } from "#studio/draw/maker.js";
import { markAt, robotsIn } from "#player/edit/model.js";
import { askSignal } from "#studio/draw/proof.js";
import { SELECTION, withSelection } from "#player/edit/selection.js";
import { STAMPS } from "#player/edit/shapes.js";
import { makeTime } from "#studio/draw/time.js";
import { TOOLS, makeTools, toolButton } from "#player/edit/tools.js";
import { makeWorldPanel } from "#studio/draw/world_panel.js";

const VIEWS = {
  grid: ["Grid", "#"],
  ruler: ["Ruler", "u"],
  proof: ["Path", "w"],
  signal: ["Signal", "i"],
  noise: ["Noise", "n"],
};
const SOON = 80; // ms
const PANELS = { world: "World", maker: "Generate", files: "Files" };

/**
 * Makes the page.
 * @param {HTMLElement} section
 * @param {Studio} studio
 * @returns {any}
 */
export function makeDraw(section, studio) {
  const canvas = el("canvas", {
    id: "board",
    tabindex: "0",
    role: "application",
    "aria-label": "Drawing board",
    "aria-describedby": "place proof board-keys",
  });
  const show = { grid: true, ruler: true, proof: true, run: true, signal: false, noise: false };
  const board = makeBoard(canvas, studio.model, show);
  const setting = { size: 1, hollow: false, stamp: "U trap", stampSize: 12 };
  const draw = { studio, say: studio.say, board, canvas, show, setting, tool: "brush", tools: makeTools(board, setting, studio.say) };
  /** @type {Record<string, any>} */
  const parts = { options: el("div", { class: "options" }), ...statusParts() };
  parts.time = makeTime(draw);
  section.replaceChildren(
    palette(draw, parts),
    el("div", { class: "middle" }, parts.options, el("div", { class: "stage board" }, canvas), parts.time.element, parts.status),
    panels(draw, parts),
  );
  Object.assign(draw, {
    choose: (tool) => choose(draw, parts, tool),
    act: (what) => act(draw, parts, what),
    resize: (by) => resize(draw, parts, by),
    toggle: (name) => toggle(draw, parts, name),
    refresh: () => refresh(draw, parts),
    panel: (name) => openPanel(draw, parts, name),
    redraw: () => (board.draw(), parts.bodies.maker.redraw()),
    where: (point) => showPlace(draw, parts, point),
    senseSignal: () => senseSignal(draw),
    showRun: (run, robot, why) => showRun(draw, parts, run, robot, why),
    bring: (dropped) => {
      draw.panel("files");
      parts.bodies.files.bring(dropped);
    },
  });
  draw.choose("brush");
  draw.panel("world");
  new ResizeObserver(() => board.draw()).observe(canvas);
  return draw;
}

function palette(draw, parts) {
  parts.tools = Object.keys(TOOLS).map((name) => toolButton(name, () => draw.choose(name)));
  return el(
    "div",
    { class: "palette", role: "toolbar", "aria-label": "Tools", "aria-orientation": "vertical" },
    parts.tools,
  );
}

function choose(draw, parts, tool) {
  draw.cancelKeys?.(); // not yet defined while the page is being made
  draw.tool = tool;
  draw.board.ghost = null;
  draw.board.marks = [];
  if (tool !== "select") draw.board.selection = null;
  if (tool !== "measure") draw.board.measure = null;
  if (tool !== "stamp") draw.tools.kit.turns = [];
  for (const button of parts.tools) {
    button.setAttribute("aria-pressed", String(button.dataset.tool === tool));
    button.tabIndex = button.dataset.tool === tool ? 0 : -1; // arrow keys lead to the others
  }
  draw.canvas.dataset.tool = tool;
  showOptions(draw, parts);
  draw.board.draw();
}

// Shows the settings of the current tool, and what the board displays.
function showOptions(draw, parts) {
  const { setting, tool } = draw,
    shown = [];
  if (["brush", "erase", "line"].includes(tool)) shown.push(range("Width", "[ ]", setting, "size", 1, 15, draw));
  if (tool === "rectangle") shown.push(box("Outline only", setting, "hollow"));
  if (tool === "stamp") {
    const names = Object.keys(STAMPS).map((name) => [name, name]);
    if (draw.tools.kit.clipboard) names.unshift(["clipboard", "Copied"]);
    const list = choice(names, setting.stamp, (event) => {
      setting.stamp = event.target.value;
    });
    list.setAttribute("aria-label", "Stamp");
    shown.push(list, range("Size", "[ ]", setting, "stampSize", 5, 60, draw));
    shown.push(["mirror", "flip", "turn"].map((what) => actButton(draw, what)));
  }
  if (tool === "select") shown.push(Object.keys(SELECTION).map((what) => actButton(draw, what)));
  const help = (matchMedia("(pointer: coarse)").matches ? TOUCH_HELP : HELP)[tool];
  const zoom = [
    keyButton("−", "Zoom out", "-", () => draw.board.zoom(1 / 1.4)),
    keyButton("+", "Zoom in", "+", () => draw.board.zoom(1.4)),
    keyButton("Fit", "Fit the whole world", "0", () => draw.board.fit()),
  ];
  parts.options.replaceChildren(
    el(
      "div",
      { class: "tool-options" },
      el("b", {}, TOOLS[tool][0]),
      shown,
      help ? el("span", { class: "quiet" }, help) : null,
    ),
    el(
      "div",
      { class: "views", role: "group", "aria-label": "Show" },
      viewBoxes(draw),
      el("div", { class: "view" }, zoom),
    ),
  );
}

function viewBoxes(draw) {
  return Object.entries(VIEWS).map(([name, [words, key]]) => viewBox(draw, name, words, key));
}

function viewBox(draw, name, words, key) {
  const box = el("input", { type: "checkbox", checked: draw.show[name], "data-view": name, onchange: () => draw.toggle(name) });
  return el("label", { class: "check", title: `Key ${key}` }, box, words);
}

const HELP = {
  brush: "right button erases",
  fill: "click an open region",
  start: "drag to turn; Alt: anywhere",
  target: "Alt: anywhere",
  measure: "drag",
  pan: "drag; wheel zooms",
};
const TOUCH_HELP = {
  ...HELP,
  brush: "two fingers move and zoom",
  fill: "tap an open region",
  start: "drag to turn",
  target: "tap",
  pan: "drag; two fingers zoom",
};

function actButton(draw, what) {
  const [words, key, sign] = SELECTION[what];
  return keyButton(sign || words, words, key, () => draw.act(what), { class: "small" });
}

function range(words, keys, setting, name, low, high, draw) {
  const shown = el("output", {}, setting[name]);
  const input = el("input", {
    type: "range",
    min: low,
    max: high,
    value: setting[name],
    title: `Keys ${keys}`,
    oninput: (event) => {
      setting[name] = Number(event.target.value);
      shown.textContent = setting[name];
      draw.board.draw();
    },
  });
  return el("label", { class: "field" }, words, input, shown);
}

function box(words, setting, name) {
  const input = el("input", {
    type: "checkbox",
    checked: setting[name],
    onchange: (event) => {
      setting[name] = event.target.checked;
    },
  });
  return el("label", { class: "check" }, input, words);
}

function resize(draw, parts, by) {
  const name = draw.tool === "stamp" ? "stampSize" : "size",
    [low, high] = draw.tool === "stamp" ? [5, 60] : [1, 15];
  draw.setting[name] = Math.min(high, Math.max(low, draw.setting[name] + by));
  showOptions(draw, parts);
}

function toggle(draw, parts, name) {
  draw.show[name] = !draw.show[name];
  if (name === "noise" && draw.show.noise) draw.show.signal = true;
  if (name === "signal" && !draw.show.signal) draw.show.noise = false;
  if (name === "signal" || name === "noise") senseSignal(draw);
  const shown = parts.run.querySelector("input");
  if (shown) shown.checked = draw.show.run;
  showOptions(draw, parts);
  draw.board.draw();
}

// Requests the robot's readings while they are displayed, shortly after the last of several
// changes.
async function senseSignal(draw) {
  if (!draw.show.signal) return;
  draw.asked = (draw.asked || 0) + 1;
  const asked = draw.asked;
  await new Promise((done) => setTimeout(done, SOON));
  if (asked !== draw.asked) return;
  const { model } = draw.studio,
    about = () => `${model.version} ${draw.asked}`,
    then = about();
  const signal = await askSignal(draw.studio, draw.show.noise, about);
  if (then !== about()) return;
  draw.board.signal = signal;
  draw.board.draw();
}

function act(draw, parts, what) {
  draw.cancel();
  if (what === "paste" && draw.tools.kit.clipboard) {
    draw.setting.stamp = "clipboard";
    draw.choose("stamp");
    return;
  }
  withSelection(draw.tools.kit, what, draw.tool === "stamp");
  showOptions(draw, parts);
}

function panels(draw, parts) {
  parts.bodies = {
    world: makeWorldPanel(draw.studio, draw),
    maker: makeMaker(draw.studio),
    files: makeFiles(draw.studio),
  };
  parts.tabs = Object.entries(PANELS).map(([name, words]) =>
    el(
      "button",
      {
        type: "button",
        role: "tab",
        id: `tab-${name}`,
        "aria-controls": `panel-${name}`,
        onclick: () => draw.panel(name),
      },
      words,
    ),
  );
  parts.panels = Object.entries(parts.bodies).map(([name, panel]) =>
    el(
      "div",
      { class: "panel", role: "tabpanel", id: `panel-${name}`, "aria-labelledby": `tab-${name}` },
      panel.element,
    ),
  );
  const tabs = el("div", { class: "panel-tabs", role: "tablist", "aria-label": "Panels" }, parts.tabs);
  return el("div", { class: "side" }, tabs, parts.panels);
}

function openPanel(draw, parts, name) {
  showTabs(parts.tabs, `tab-${name}`);
  for (const panel of parts.panels) panel.hidden = panel.id !== `panel-${name}`;
  if (name === "files") parts.bodies.files.list();
}

function refresh(draw, parts) {
  for (const panel of Object.values(parts.bodies)) panel.refresh();
  parts.time.refresh();
  draw.board.draw();
  showPlace(draw, parts, parts.place);
}

// Shows the place of the pointer or the size of the world, and whether the target can be reached.
function showPlace(draw, parts, point) {
  parts.place = point;
  const { world } = draw.studio.model,
    side = world.cell_size;
  const changes = world.events ? `, ${grouped(world.events.times.length)} changes` : "";
  const robots = robotsIn(world),
    fleet = robots > 1 ? ` · ${robots} robots; the tools move robot 1` : "";
  const mark = markAt(world, point);
  draw.canvas.title = mark && `${mark}: drag it with the tool of this name`;
  const place = point
    ? `${mark && `${mark} · `}cell ${Math.floor(point[0])}, ${Math.floor(point[1])} · ${(point[0] * side).toFixed(3)}, ${(point[1] * side).toFixed(3)} m`
    : `${world.width} x ${world.height} cells, ${grouped(draw.studio.model.solid)} solid${changes} · ${(world.width * side).toFixed(2)} x ${(world.height * side).toFixed(2)} m${fleet}`;
  const { head, words, kind } = proofWords(draw.board.proof);
  parts.where.textContent = place;
  // so that a screen reader reads it only once
  if (parts.proof.textContent === head + words) return;
  parts.proof.className = `proof ${kind}`;
  parts.proof.title = head + words;
  parts.proof.replaceChildren(el("b", {}, head), words);
}

// Shows how a robot's run in the drawing ends, or why there is none. Play runs it with everything
// that can be seen of it.
function showRun(draw, parts, run, robot, why) {
  const { board } = draw;
  const name = viewBox(draw, "run", `${shortName(robot)}: `, "v");
  // In a world that changes, the board shows the moment of the slider instead.
  const isStill = !draw.studio.model.world.events;
  board.run = run && isStill ? { run: run.drawn, step: run.steps, show: { trail: true, touched: false, changes: true } } : null;
  const zoom = isStill && el("button", { type: "button", class: "link", "aria-keyshortcuts": "z", title: "Zoom to the run (z)", onclick: () => board.toRun() }, "zoom to it");
  const words = run ? [name, " ", verdictDot(run.verdict), " ", el("b", {}, run.verdict), ` ${runWords(run)} `, zoom || ""] : [why && `${shortName(robot)}: ${why}`];
  keepFocus(parts.run, () => parts.run.replaceChildren(...words));
}

// Makes the status below the board; it also describes the board to screen readers.
function statusParts() {
  const where = el("span", { class: "place", id: "place" }),
    run = el("span", { class: "drawn-run", id: "drawn-run" }),
    proof = el("span", { class: "proof", id: "proof", role: "status" }),
    keys = el("span", { class: "away", id: "board-keys" }, "Arrow keys move a cursor, Space uses the tool there.");
  return { where, run, proof, status: el("div", { class: "status" }, el("div", {}, where, run), proof, keys) };
}
