// The page on which robots run: their settings, and the same player as in reports.

import { askAbout } from "#studio/shared/asking.js";
import { buildPlayer, dragToMove } from "#player/controls.js";
import { bytesOf } from "#player/decode.js";
import { el, say } from "#player/dom.js";
import { besideIn } from "#player/pair.js";
import { endingOf, sceneOf, showInstruments, showRobots } from "#player/robots.js";
import { keep } from "#player/saving.js";
import { Ended } from "#studio/shared/connection.js";
import { messageOf } from "#studio/shared/world_message.js";
import { joinNames, splitNames } from "#studio/shared/links.js";
import { Refused, refusalWords } from "#studio/shared/refusals.js";
import { makeArbitration } from "#studio/play/arbitration.js";
import { makeCodeNote } from "#studio/play/code_note.js";
import { makeDriving } from "#studio/play/driving.js";
import { drawnOf } from "#player/edit/drawn_world.js";
import { makeRobots } from "#studio/play/robots.js";
import { isSame, noteCode, noteReported, runsOneOf, stampOf } from "#studio/shared/edits.js";

const SLOW = 1500; // ms after which a run can be stopped
const PREPARING = "Preparing: the studio starts a process, loads the controllers and proves the world.";
const WRONG = "Not run: a setting is not valid. Press Run to go to it.";
const NONE_RAN = "No robot ran, so only the world is shown.";
const PARTED = "No robot of this size can reach the target: the cut in the picture separates it from the start.";

/**
 * Makes the page.
 * @param {HTMLElement} section
 * @param {Studio} studio
 * @returns {any}
 */
export function makePlay(section, studio) {
  const parts = {
    canvas: el("canvas", { id: "stage", role: "img", "aria-label": "The run" }),
    under: el("div", { class: "under" }),
    list: el("ol", { "aria-label": "Results" }),
    said: el("p", { class: "said", role: "status", id: "run-said" }),
    instruments: el("p", { class: "instruments", id: "instruments" }),
  };
  parts.stop = el("button", { type: "button", id: "stop-run", hidden: true, onclick: () => stop(play) }, "Stop");
  parts.stage = el("div", { class: "stage" }, parts.canvas);
  parts.beside = el("button", { type: "button", id: "beside", hidden: true, "aria-pressed": "false", onclick: () => toggleBeside(play) }, "Compare with the original, before shrinking");
  /** @type {any} */
  const play = { studio, before: null, both: false, parts, player: null, running: null, saving: null, bare: null, isWrong: false, wantedStep: null, cut: false, way: false, runs: [], world: null, impossible: "", message: null, looked: 0, shown: null, under: null, asked: 0 };
  play.code = makeCodeNote(studio, () => run(play, true));
  play.driving = makeDriving({
    begin: () => beginDriving(play),
    ask: (message) => studio.connection.ask("drive", message),
    show: (robot) => showDriven(play, robot),
    tell: (words, isBad) => tell(play, words, isBad),
  });
  parts.stage.append(play.driving.pad);
  play.arbitration = makeArbitration(studio);
  play.robots = makeRobots(studio, () => run(play, true), play.driving.button, play.code.setting);
  section.replaceChildren(
    el("div", { class: "middle" }, el("div", { class: "sight" }, parts.stage, play.arbitration.element), el("div", { class: "told" }, parts.instruments, play.arbitration.button), parts.under),
    el("div", { class: "side" }, play.robots.element, play.code.element, parts.said, parts.stop, el("div", { class: "results" }, parts.list, parts.beside)),
  );
  play.robots.element.addEventListener("change", () => play.isWrong && play.robots.good(false) && tell(play, ""));
  dragToMove(parts.stage, play);
  parts.stage.addEventListener("wheel", (event) => wheel(play, event), { passive: false });
  new ResizeObserver(() => (play.player || play.bare)?.draw()).observe(parts.canvas);
  return {
    player: () => play.player,
    run: () => run(play, true),
    begin: () => begin(play),
    changed: () => play.studio.page() === "play" && showStale(play),
    pause: () => {
      play.driving.end();
      play.player?.play(false);
    },
    drive: () => play.driving.button.click(),
    chart: play.arbitration.toggle,
    redraw: () => (play.player || play.bare)?.draw(),
    refresh: () => {
      play.code.offer();
      play.robots.refresh();
    },
    edited: (files) => edited(play, files),
    link: () => linkOf(play),
    setup: () => play.robots.message(),
    own: () => play.robots.own(),
    follow: (shows) => follow(play, shows),
    prefer: (failure) => {
      play.robots.prefer(failure);
      askBefore(play);
    },
    forget: () => play.robots.forget(),
    settings: (heading) => play.robots.settings(heading),
    runs: () => play.runs,
    played: () => played(play),
  };
}

function wheel(play, event) {
  if (!play.player) return;
  event.preventDefault();
  play.player.zoom(event.deltaY < 0 ? 1.15 : 1 / 1.15);
}

// Returns the robot in front and its run; null before the first run.
function played({ message, runs, looked }) {
  const front = runs[looked];
  return front && front.run && !front.isDriven ? { controller: front.name, motion: message.motion, time_step: message.time_step } : null;
}

// Opens the page, and runs the robots immediately if anything has changed since the last run.
function begin(play) {
  play.robots.refresh();
  showStale(play);
  const isDone = isSame(play.under ?? play.shown, now(play), true);
  if (!isDone) run(play);
  else if (!play.under && play.player) play.player.draw();
}

// Returns what a run that is asked for now depends on.
const now = ({ studio, robots }) => stampOf(studio, robots.message());

// Returns what a link to the set-up contains; nothing before the first run.
function linkOf({ message, robots }) {
  if (!message) return {};
  const { controllers, motion, seed } = robots.message();
  return { robots: joinNames(controllers), motion, seed: seed || null };
}

// Takes the robots that a link or a comparison names, and their time step; `more` has settings that
// a link does not change. Returns sentences about the robots that cannot run here.
function follow(play, { robots, motion, seed, step, ...more }) {
  play.wantedStep = step === undefined ? null : Number(step);
  return play.robots.follow({ robots: robots ? splitNames(robots) : [], motion, seed: Number(seed ?? 0) }, more);
}

// Handles edited files: marks results of the old code as outdated, and runs them again.
function edited(play, files) {
  const robots = [...play.robots.message().controllers, ...play.runs.map(({ name }) => name)];
  const own = files.filter(({ controllers }) => robots.some((robot) => runsOneOf(robot, controllers)));
  if (own.length === 0) return;
  showStale(play);
  if (play.code.edited(own)) run(play);
}

// Runs the world as it is. If a setting is not valid, pressing Run leads to it.
async function run(play, pressed = false) {
  const { studio, parts } = play;
  if (!studio.offered) return;
  play.driving.end();
  const stamp = now(play);
  if (!play.robots.good(pressed)) {
    showWrong(play, stamp);
    return;
  }
  play.asked += 1;
  play.under = stamp;
  const { asked } = play;
  play.both = false;
  parts.beside.hidden = true;
  tell(play, PREPARING);
  showStale(play);
  if (!play.player) showBare(play, drawnOf(studio.model.world), PREPARING);
  const slow = setTimeout(() => asked === play.asked && (parts.stop.hidden = false), SLOW);
  const asks = play.robots.message();
  play.robots.running(asks);
  const message = { ...asks, world: messageOf(studio.model.world) };
  try {
    play.running = studio.connection.ask("run", message, (part, code) => asked === play.asked && take(play, part, code, message, stamp));
    await play.running;
    if (asked !== play.asked) return;
    finish(play);
    showBeside(play);
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    if (asked !== play.asked) return;
    tell(play, error.message, error instanceof Refused);
  } finally {
    clearTimeout(slow);
    if (asked === play.asked) endRun(play);
  }
}

function tell(play, words, isBad = false) {
  play.isWrong = false; // until showWrong says otherwise
  play.parts.said.className = isBad ? "said bad" : "said quiet";
  play.parts.said.textContent = words;
}

// Runs the chosen robots if needed, and returns the settings of their run for the robot that the
// user drives.
async function beginDriving(play) {
  // A run in progress ends first, because its last words would replace those about driving.
  if (isSame(play.under, now(play))) {
    tell(play, "You drive when this run has ended.");
    await play.running.catch(() => {});
  }
  if (!isSame(play.shown, now(play))) await run(play, true);
  if (!isSame(play.shown, now(play)) || play.studio.page() !== "play") return null;
  play.player?.play(false);
  play.runs = play.runs.filter((one) => !one.isDriven);
  play.looked = Math.max(0, Math.min(play.looked, play.runs.length - 1));
  if (play.world) showTable(play);
  const { controllers: _, ...message } = play.message;
  return message;
}

// Shows the robot that the user drives in front of the others, at the end of its run so far.
function showDriven(play, robot) {
  play.runs = [...play.runs.filter((one) => !one.isDriven), { ...robot, isDriven: true }];
  look(play, play.runs.length - 1);
  play.player.go(robot.steps); // others may have driven longer
}

function finish(play) {
  const { parts, runs, player } = play;
  tell(play, "");
  if (isSame(play.shown, now(play))) play.code.ran();
  play.studio.showLink();
  if (Number.isFinite(play.wantedStep) && player) player.go(play.wantedStep);
  play.wantedStep = null;
  if (runs.some((one) => one.run)) return;
  // An earlier picture would show code that no longer runs.
  player?.play(false);
  play.player = null;
  parts.instruments.replaceChildren();
  play.arbitration.offer(null);
  showBare(play, play.world, NONE_RAN);
}

// Marks results of another world, shown or in progress, as outdated; runs nothing.
function showWrong(play, stamp) {
  if (!isSame(play.under, stamp)) {
    play.asked += 1;
    endRun(play);
    showStale(play);
  }
  tell(play, WRONG, true);
  play.isWrong = true;
}

// Greys the results unless they are about the world, the settings and the code on the screen.
function showStale(play) {
  const { parts, shown } = play;
  const current = now(play);
  noteReported(shown, current);
  const stale = shown !== null && !isSame(shown, current);
  for (const part of [parts.stage, parts.list]) part.classList.toggle("stale", stale);
}

function endRun(play) {
  play.under = null;
  hideStop(play.parts.stop);
}

// Stops the runs that are in progress; finished ones stay.
function stop(play) {
  play.running.stop();
  tell(play, "Stopping …");
}

function hideStop(button) {
  if (document.activeElement === button) document.getElementById("run")?.focus();
  button.hidden = true;
}

// Handles a part of the answer: the world, which replaces earlier results, or a robot's run.
function take(play, part, code, message, stamp) {
  noteCode(stamp, code);
  if (part.world !== undefined) {
    Object.assign(play, { world: part.world, impossible: part.impossible, message, runs: [], looked: 0 });
    tell(play, runningWords(message.controllers, 0));
    if (!play.player) showBare(play, part.world, "The robots are running.");
    showStale(play);
    return;
  }
  if (part.error) Object.assign(part, { error: refusalWords(part.error), frames: part.error.frames });
  play.runs.push(part);
  play.shown = stamp;
  tell(play, runningWords(message.controllers, play.runs.length));
  showStale(play);
  say(play.runs.map((one) => `${one.name}: ${endingOf(one)}`).join(". "));
  showTable(play);
  if (!part.error)
    look(play, play.runs[play.looked] && play.runs[play.looked].run ? play.looked : play.runs.length - 1);
}

const runningWords = (robots, done) => (done < robots.length ? `Running ${robots[done]} …` : "");

// Shows the world alone, with the reason.
function showBare(play, world, why) {
  const drawn = { world, run: null, why };
  play.bare = buildPlayer(play.parts.canvas, play.parts.under, drawn, null);
  play.parts.canvas.style.height = "";
  play.bare.draw();
}

// Shows the cut in a blocked world until the user hides it,
// and restores the earlier choice in the next reachable one.
function showCut(play) {
  const { player, world } = play;
  if (Boolean(world.cut) === play.cut) return;
  play.cut = Boolean(world.cut);
  if (play.cut) play.way = player.show.witness;
  player.show.witness = play.cut || play.way;
  player.update();
}

// Shows the runs with one of them in front.
function look(play, number) {
  const { parts, runs } = play,
    front = runs[number];
  if (!front || !front.run) return;
  play.looked = number;
  /** @type {Drawn} */
  const drawn = { ...sceneOf(play.world, runs, number), name: play.studio.model.world.name, saves: front.isDriven ? [] : savesOf(play), stopSaving: () => play.saving && play.saving.stop(), beside: besideOf(play) };
  const former = play.player,
    seen = former && former.drawn.world === play.world && former.step < former.last ? former : null;
  const playing = seen && seen.playing;
  if (former) former.play(false);
  play.arbitration.offer(front);
  const shown = (player) => {
    showInstruments(parts.instruments, player);
    play.arbitration.at(player);
  };
  play.player = buildPlayer(parts.canvas, parts.under, drawn, former, shown);
  // the page lays it out
  for (const canvas of parts.stage.querySelectorAll("canvas")) canvas.style.height = "";
  if (seen) goOn(play.player, seen, playing);
  else play.player.fit();
  showCut(play);
  parts.canvas.setAttribute("aria-label", `${front.name}: ${endingOf(front)}`);
  showTable(play);
}

// Continues with another robot of the same world at the same time and place.
function goOn(player, seen, playing) {
  player.view = seen.view;
  player.speed = seen.speed;
  player.go((seen.step * seen.drawn.run.dt) / player.drawn.run.dt);
  if (seen.follow) player.robot();
  player.play(playing);
}

function showTable(play) {
  showRobots(play.parts.list, play.runs, play.looked, (number) => look(play, number), noteOf(play));
}

// Returns why no controller could have arrived; empty if one can.
function noteOf({ world, impossible }) {
  if (world.cut && !world.others?.length) return PARTED;
  return impossible && `${impossible[0].toUpperCase()}${impossible.slice(1)}.`;
}

// Asks whether the campaign has the original of the opened failure, if the failure has not changed
// since.
async function askBefore(play) {
  const { model, connection } = play.studio;
  const world = model.digest;
  play.before = null;
  try {
    const before = await askAbout(connection, () => model.digest, "before", { name: model.world.name });
    if (before && before.run && before.world) play.before = { ...before, of: world };
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
  }
  showBeside(play);
}

function showBeside(play) {
  const there = play.before && play.before.of === play.shown?.world && play.runs.length === 1 && play.player;
  play.parts.beside.hidden = !there;
  play.parts.beside.setAttribute("aria-pressed", String(play.both));
}

function toggleBeside(play) {
  play.both = !play.both;
  look(play, play.looked);
  showBeside(play);
}

function besideOf(play) {
  return besideIn(play.parts.stage, play.both ? play.before : null, ["As found", "Shrunk"]);
}

// Returns the files that the server can make of the same runs: pictures and pages.
/** @returns {NonNullable<Drawn["saves"]>} */
function savesOf(play) {
  // refers to these runs, even if others start in the meantime
  const message = { ...play.message, looked: play.looked };
  /** @type {(words: string, kind: string) => [string, () => Promise<string>]} */
  const file = (words, kind) => [words, () => keepPicture(play, kind, message)];
  return [file("Animation, GIF", "gif"), file("Drawing, SVG", "svg"), file("Replay, one HTML file", "html")];
}

async function keepPicture(play, kind, message) {
  const { studio, asked } = play;
  const name = (studio.model.world.name || "run").replace(/^.*\//, "").replace(/\.grid(\.gz)?$/, "");
  try {
    if (asked === play.asked) tell(play, "");
    play.saving = studio.connection.ask("picture", { ...message, kind, title: name });
    const answer = await play.saving;
    keep(`${name}.${kind}`, new Blob([bytesOf(answer)]));
    return `Saved ${name}.${kind}`;
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    const words = error instanceof Ended ? "Not saved." : error.message;
    if (asked === play.asked) tell(play, words, error instanceof Refused);
    return words;
  } finally {
    play.saving = null;
  }
}
