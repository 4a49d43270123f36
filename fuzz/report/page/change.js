// Changing a failure's world: an editor on its picture. The core in the page judges each change at
// once: whether the target can be reached, and how the robot's run ends.

import { DECIDING, proofOf, proofWords, runWords } from "#player/edit/answer.js";
import { makeBoard } from "#player/edit/board.js";
import { drawnOf } from "#player/edit/drawn_world.js";
import { editedOf, gridText, rowsOf } from "#player/edit/grid_text.js";
import { Model } from "#player/edit/model.js";
import { listenToBoard } from "#player/edit/pointer.js";
import { radiusField } from "#player/edit/radius.js";
import { TOOLS, makeTools, toolButton } from "#player/edit/tools.js";
import { buildPlayer } from "#player/controls.js";
import { bytesOf } from "#player/decode.js";
import { el, keyButton, say, verdictDot } from "#player/dom.js";
import { keepsKey } from "#player/keys.js";
import { openLive } from "#player/live/live.js";
import { keep } from "#player/saving.js";
import { copyButton } from "#report/copy.js";

const HELP = "Draw or erase walls, drag the start, the tip of its heading, or the target: the verdict follows.";
const USED = ["change", "brush", "erase", "start", "target", "pan"];
const SLOW = 250; // ms after which the page says that an answer is not there yet
const QUIET = 150; // ms without another answer, after which the clock and its buttons show the new run
const NOT_HERE = "This browser cannot judge changes in the page.";

/** What was changed in each failure's world, by its id: it stays while the page is open. */
const sessions = new Map();
/** @type {Promise<Live | null> | null} */
let opened = null; // the core, once it has been used

/**
 * Returns whether the page can judge changes of a failure's world.
 * @param {LiveCore | null | undefined} core
 * @param {ReportFailure} failure
 * @returns {boolean}
 */
export function canChange(core, failure) {
  const needs = ["WebAssembly", "Worker", "DecompressionStream"];
  return Boolean(core && failure.live && failure.now.world) && needs.every((name) => name in globalThis);
}

/**
 * Makes the button Change it, with what it opens.
 * @param {ReportFailure} failure
 * @param {LiveCore} core
 * @param {{ stage: HTMLElement, canvas: HTMLCanvasElement, under: HTMLElement,
 *   state: { player: Player | null }, restore: () => void }} view - The picture of the failure;
 *   `restore` shows its recording
 * @returns {any}
 */
export function makeChange(failure, core, view) {
  /** @type {any} */
  const change = { failure, core, view, isOn: false, session: null, draw: null, asked: 0, timers: { slow: 0, rebuild: 0 }, frame: 0 };
  const parts = (change.parts = partsOf(change));
  change.element = el("div", { class: "change" }, parts.toggle, parts.help, parts.panel);
  return {
    element: change.element,
    tries: triesPart(change),
    end: () => end(change),
    open: () => begin(change, false),
    drive: (run) => drive(change, run),
  };
}

function partsOf(change) {
  /** @type {Record<string, any>} */
  const parts = {
    toggle: el("button", { type: "button", id: "change", class: "main", "aria-expanded": "false", "aria-controls": "change-panel", onclick: () => (change.isOn ? leave(change) : begin(change)) }, "Change it"),
    help: el("span", { class: "quiet" }, HELP),
    verdict: el("p", { id: "change-verdict", class: "verdict-line" }),
    proof: el("p", { id: "change-proof", class: "proof" }),
    note: el("p", { class: "quiet", hidden: true }),
    tools: USED.map((name) => toolButton(name, () => choose(change, name))),
    undo: keyButton("↶", "Undo", "Control+Z", () => step(change, "undo")),
    redo: keyButton("↷", "Redo", "Control+Y", () => step(change, "redo")),
    reset: el("button", { type: "button", onclick: () => reset(change) }, "Reset"),
    radius: radiusField(() => change.session?.model),
    save: el("button", { type: "button", onclick: () => save(change) }, "Save as .grid"),
    copy: copyButton("Copy test", () => testText(change)),
  };
  // a body has no radius to set
  parts.radius.element.hidden = Boolean(change.failure.now.world.footprint);
  parts.copy.hidden = !change.failure.test;
  const keys = el("span", { class: "away", id: "change-keys" }, "Arrow keys move a cursor, Space uses the tool there.");
  parts.panel = el(
    "div",
    { id: "change-panel", class: "change-panel", hidden: true },
    el(
      "div",
      { class: "change-tools", onkeydown: (event) => keyDown(change, event) },
      el("div", { class: "palette", role: "toolbar", "aria-label": "Tools" }, parts.tools),
      parts.radius.element,
      el("div", { class: "view" }, parts.undo, parts.redo, parts.reset),
    ),
    el("div", { class: "change-answer" }, el("div", {}, parts.verdict, parts.proof, parts.note), el("div", { class: "view" }, parts.save, parts.copy)),
    keys,
  );
  return parts;
}

// Makes a button for each single change after which the robot is known to arrive.
function triesPart(change) {
  const { tries } = change.failure;
  if (tries.length === 0) return null;
  const button = ([words, what]) => el("button", { type: "button", class: "small", onclick: () => tryIt(change, words, what) }, words);
  return el("p", { class: "words tries" }, "Try it: ", tries.map(button));
}

async function tryIt(change, words, { cell, heading, radius }) {
  if (!change.isOn) await begin(change);
  if (!change.session) return;
  const { model, first } = change.session;
  const cells = first.cells.slice();
  if (cell) cells[cell[1] * first.width + cell[0]] = 0;
  model.change(words, {
    ...first,
    cells,
    start: [first.start[0], first.start[1], heading ?? first.start[2]],
    robot_radius: radius ?? first.robot_radius,
  });
  reveal(change);
}

// Opens the editor with what was changed before, if anything was; may bring it into the window.
async function begin(change, reveals = true) {
  const { parts, view, failure } = change;
  view.restore();
  change.isOn = true;
  parts.toggle.textContent = "Done";
  parts.toggle.setAttribute("aria-expanded", "true");
  parts.help.hidden = true;
  parts.panel.hidden = false;
  showAnswer(change);
  if (reveals) reveal(change);
  opened ??= openLive(change.core);
  const [live, packed] = await Promise.all([opened, typeof failure.live === "string" ? unpacked(failure.live) : failure.live]);
  if (!change.isOn) return;
  if (!live) {
    giveUp(change);
    return;
  }
  change.live = live;
  change.session = sessions.get(failure.id) ?? newSession(failure, packed);
  sessions.set(failure.id, change.session);
  change.session.model.changed = () => changed(change);
  openBoard(change);
  changed(change);
}

// Closes the editor for good, and says so.
function giveUp(change) {
  leave(change);
  change.parts.toggle.disabled = true;
  change.parts.help.textContent = NOT_HERE;
}

// Runs another controller in the world as it is now; null for none.
function drive(change, run) {
  const { session } = change;
  if (!session || session.question.run === run) return;
  Object.assign(session, { question: { ...session.question, run }, answered: -1 });
  changed(change);
}

// Brings the whole picture into the window, below the verdict.
function reveal({ element, view }) {
  if (view.stage.getBoundingClientRect().bottom > innerHeight) element.scrollIntoView();
}

/** @type {(text: string) => Promise<{question: {world: LiveWorld, run: LiveRecipe | null, why: string}, source: string, label: string}>} */
async function unpacked(text) {
  const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return JSON.parse(await new Response(stream).text());
}

function newSession(failure, { question, source, label }) {
  const first = editedOf(question.world, source, failure.now.name);
  const model = new Model({ ...first, cells: first.cells.slice() }, () => {});
  return { model, first, original: model.digest, question, label, answer: null, answered: -1 };
}

function openBoard(change) {
  const { view, parts, session } = change;
  const canvas = el("canvas", { id: "board", tabindex: "0", role: "application", "aria-label": "The world, to be changed", "aria-describedby": "change-verdict change-keys" });
  // the view is moved with the tool of that name, not by dragging the picture
  canvas.addEventListener("pointerdown", (event) => event.stopPropagation());
  canvas.addEventListener("keydown", (event) => keyDown(change, event));
  view.stage.replaceChildren(canvas);
  const board = makeBoard(canvas, session.model, { proof: true });
  Object.defineProperty(board, "view", {
    get: () => view.state.player?.view ?? null,
    set: (to) => {
      if (view.state.player) view.state.player.view = to;
    },
  });
  change.draw = { canvas, board, say, where() {}, tool: "", tools: makeTools(board, { size: 1, hollow: false, stamp: "", stampSize: 0 }, say) };
  listenToBoard(change.draw);
  choose(change, "change");
  parts.radius.refresh();
  rebuild(change);
}

function choose(change, tool) {
  const { draw, parts } = change;
  draw.cancelKeys?.();
  Object.assign(draw, { tool });
  draw.canvas.dataset.tool = tool;
  for (const button of parts.tools) button.setAttribute("aria-pressed", String(button.dataset.tool === tool));
  draw.board.marks = [];
  draw.board.draw();
}

// Shows a change at once, and its verdict as soon as the core has judged it.
function changed(change) {
  const { session, parts } = change,
    { model } = session;
  parts.undo.disabled = model.past.length === 0;
  parts.redo.disabled = model.future.length === 0;
  parts.reset.disabled = model.digest === session.original;
  parts.radius.refresh();
  if (!change.isOn) return;
  change.frame ||= requestAnimationFrame(() => {
    change.frame = 0;
    change.draw.board.draw();
  });
  judge(change);
}

async function judge(change) {
  const { session, timers } = change,
    { model } = session,
    { version } = model;
  if (session.answered === version) return showAnswer(change);
  timers.slow ||= setTimeout(() => change.parts.verdict.classList.add("stale"), SLOW);
  let answer;
  try {
    answer = await change.live.judge(questionOf(session));
  } catch (fault) {
    giveUp(change);
    throw fault;
  }
  if (!answer || version !== model.version) return; // a newer one is on its way
  clearTimeout(timers.slow);
  timers.slow = 0;
  Object.assign(session, { answer, answered: version });
  if (change.isOn) showAnswer(change);
}

/** @returns {LiveQuestion} */
function questionOf({ model, original, question }) {
  const { start, target, robot_radius: radius } = model.world;
  return { world: { ...question.world, cells: rowsOf(model.world), start, target, radius }, run: question.run, edited: model.digest !== original };
}

// The run that the picture shows: the core's, or the recording of a controller that it cannot run.
const shownRun = ({ session, failure }) => (session?.question.run ? (session.answer?.run?.drawn ?? null) : failure.now.run);

// Returns whether the world is still that of the failure's file.
const isUnchanged = ({ model, original }) => model.digest === original;

// Returns the path of the file, while it is still that world's and the core cannot prove it itself.
function pathInFile({ session, failure }, answer) {
  return answer?.live.proof && isUnchanged(session) ? failure.now.world?.open?.witness : null;
}

function showAnswer(change) {
  const { parts, session, draw, failure, timers } = change,
    answer = session?.answer;
  parts.verdict.classList.remove("stale");
  const run = answer?.run;
  const verdict = run?.verdict ?? (answer && !session.question.run ? failure.verdict : "");
  const words = run ? runWords(run) : answer ? answer.live.run || (failure.now.run ? "in the recording" : "") : "…";
  parts.verdict.replaceChildren(...(verdict ? [verdictDot(verdict), " ", el("b", {}, verdict), " "] : []), words);
  const proof = answer ? proofOf(answer.proof, answer.live.proof, session.model.world) : DECIDING;
  const known = pathInFile(change, answer);
  if (known) proof.opened = known;
  const told = known ? { kind: "good", head: "✓ reachable:", words: " by the path in the file" } : proofWords(proof);
  parts.proof.className = `proof ${told.kind}`;
  parts.proof.replaceChildren(el("b", {}, told.head), told.words);
  parts.note.hidden = !session?.question.why;
  parts.note.textContent = session?.question.why ?? "";
  // A test needs a proof and, if the core runs the controller, a run.
  const cannotRun = Boolean(answer?.live.run);
  parts.copy.disabled = (cannotRun || Boolean(answer?.live.proof)) && !isUnchanged(session);
  parts.copy.title = !parts.copy.disabled ? "" : cannotRun ? answer.live.run : "Save the world, and prove it with worldgen verify";
  if (!answer || !draw) return;
  draw.board.proof = proof;
  draw.board.run = null;
  paint(change, change.view.state.player);
  clearTimeout(timers.rebuild);
  timers.rebuild = setTimeout(() => {
    rebuild(change);
    say(`${parts.verdict.textContent}. ${parts.proof.textContent}`);
  }, QUIET);
}

// Draws the board with the run at the player's step, or at its end while the player shows the one
// before.
function paint(change, player) {
  const { board } = change.draw,
    run = shownRun(change);
  const step = player?.drawn.run === run ? player.step : (run?.steps ?? 0);
  const show = { ...player?.show, witness: player?.show.witness ?? true };
  board.run = run && { run, step, sensors: change.failure.now.sensors, show };
  board.draw();
}

// Gives the clock and its buttons the run that the picture shows.
function rebuild(change) {
  if (!change.isOn) return;
  const { view, session, draw, failure } = change,
    former = view.state.player,
    run = shownRun(change),
    world = drawnOf(session.model.world);
  const { proof } = draw.board;
  if (proof && world.open) Object.assign(world.open, { witness: proof.opened });
  const drawn = { ...failure.now, named: [], world: { ...world, cut: proof?.cut, cut_poses: proof?.cut_poses }, run, paint: (player) => paint(change, player) };
  former?.play(false);
  if (former && !former.drawn.paint) former.show.witness = true;
  // the page below keeps its place when there are fewer buttons
  view.under.style.minHeight = `${view.under.offsetHeight}px`;
  const player = buildPlayer(draw.canvas, view.under, drawn, former);
  view.state.player = player;
  if (former?.view) Object.assign(player, { view: former.view });
  player.update();
}

function leave(change) {
  end(change);
  change.view.restore();
  change.parts.toggle.focus();
}

// Closes the editor; what was changed stays for the next time.
function end(change) {
  if (!change.isOn) return;
  const { parts, view, timers } = change;
  change.isOn = false;
  clearTimeout(timers.rebuild);
  change.draw?.cancel();
  change.draw = null;
  parts.toggle.textContent = "Change it";
  parts.toggle.setAttribute("aria-expanded", "false");
  parts.help.hidden = false;
  parts.panel.hidden = true;
  view.stage.replaceChildren(view.canvas);
  view.under.style.minHeight = "";
}

function step({ draw, session }, which) {
  const label = draw.cancel() ? "" : session.model[which]();
  if (label) say(`${which === "undo" ? "Undone" : "Redone"}: ${label}`);
}

function reset({ draw, session }) {
  draw.cancel();
  session.model.change("reset", { ...session.first, cells: session.first.cells.slice() });
}

// While the editor has the focus, keys choose its tools.
function keyDown(change, event) {
  if (event.altKey || !change.draw) return;
  const key = event.key.toLowerCase(),
    tool = USED.find((name) => TOOLS[name][1] === key);
  /** @type {(() => void) | null} */
  let act = null;
  if (event.ctrlKey || event.metaKey) {
    if (key === "z") act = () => step(change, event.shiftKey ? "redo" : "undo");
    if (key === "y") act = () => step(change, "redo");
  } else if (key === "escape") act = () => change.draw.cancel() || leave(change);
  else if (tool && !keepsKey(event.target, key)) act = () => choose(change, tool);
  if (!act) return;
  event.preventDefault();
  event.stopPropagation();
  act();
}

// The text of the world's file as it is now: with its proof and, if the run fails although the
// target can be reached, with the failure.
async function textOf(change, isTest = false) {
  const { session, failure } = change,
    { model } = session;
  if (isUnchanged(session)) return new TextDecoder().decode(bytesOf(failure.now.file));
  while (session.answered !== model.version) {
    await judge(change);
    await new Promise((done) => setTimeout(done));
  }
  const { proof, run } = session.answer;
  const fails = run && proof.witness && run.verdict !== "reached";
  return gridText(model.world, proof, fails || (run && isTest) ? run : null);
}

async function save(change) {
  const name = change.failure.now.name.replace(/(\.grid)?(\.gz)?$/, "");
  keep(`${name}-changed.grid`, new Blob([await textOf(change)]));
}

// The failure's test, with the world as it is now. A test of a controller that the core cannot run
// names it, because the world's file records no run of it.
async function testText(change) {
  const { failure, session } = change,
    { run } = session.answer ?? {},
    [head, rest] = failure.test.split('GRID = """\\\n'),
    tail = rest.slice(rest.indexOf('"""\n'));
  if (isUnchanged(session)) return failure.test;
  const text = escaped(await textOf(change, true));
  const named = session.question.run ? tail : tail.replace("fixed(FAILURE)", `fixed(FAILURE, ${JSON.stringify(session.label)})`);
  const titled = head.replace(/: [^:\n]*\."""/, `${run ? `: ${run.verdict}` : ""}, in a changed world."""`);
  return `${titled}GRID = """\\\n${text}${named}`;
}

// As fuzz/shrink/snippet.py: the text is the same to Python, and no editor hides a part of it.
function escaped(text) {
  const quoted = text.replaceAll("\\", "\\\\").replaceAll('"""', '\\"\\"\\"');
  return quoted.replace(/[^\P{C}\n\t]|(?! )\p{Z}/gu, (letter) => {
    const code = /** @type {number} */ (letter.codePointAt(0)).toString(16);
    return code.length > 4 ? `\\U${code.padStart(8, "0")}` : `\\u${code.padStart(4, "0")}`;
  });
}
