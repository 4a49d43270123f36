// The page on which robots drive: who, how, and the player that reports have, too.

import { buildPlayer, dragToMove } from "/player/controls.js";
import { bytesOf } from "/player/decode.js";
import { el } from "/player/dom.js";
import { besideIn } from "/player/pair.js";
import { sceneOf, showInstruments, showRobots } from "/player/robots.js";
import { keep } from "/player/saving.js";
import { Ended, Refused } from "./connection.js";
import { messageOf } from "./model.js";
import { makeRobots } from "./robots.js";

/* The page.
     studio    { model, connection, offered, ... }: what all pages share */
export function makePlay(section, studio) {
  const parts = {
    canvas: el("canvas", { id: "stage", role: "img", "aria-label": "The run" }),
    under: el("div", { class: "under" }),
    list: el("ol", { "aria-label": "Results" }),
    said: el("p", { class: "said", role: "status", id: "run-said" }),
    instruments: el("p", { class: "instruments", id: "instruments" }),
  };
  parts.stage = el("div", { class: "stage" }, parts.canvas);
  parts.beside = el("button", { type: "button", id: "beside", hidden: true, "aria-pressed": "false", onclick: () => toggleBeside(play) }, "Beside it: as found, before shrinking");
  const play = { studio, before: null, both: false, parts, player: null, runs: [], world: null, message: null, looked: 0, version: -1, asked: 0 };
  play.robots = makeRobots(studio, () => run(play));
  section.replaceChildren(
    el("div", { class: "middle" }, parts.stage, parts.instruments, parts.under),
    el("aside", { class: "side" }, play.robots.element, parts.said, el("div", { class: "results" }, parts.list, parts.beside)),
  );
  dragToMove(parts.canvas, play);
  parts.canvas.addEventListener("wheel", (event) => wheel(play, event), { passive: false });
  new ResizeObserver(() => play.player && play.player.draw()).observe(parts.canvas);
  return {
    player: () => play.player,
    run: () => run(play),
    begin: () => begin(play),
    pause: () => play.player && play.player.play(false),
    redraw: () => play.player && play.player.draw(),
    refresh: () => play.robots.refresh(),
    prefer: (failure) => {
      play.robots.prefer(failure);
      askBefore(play);
    },
    runs: () => play.runs,
  };
}

function wheel(play, event) {
  if (!play.player) return;
  event.preventDefault();
  play.player.zoom(event.deltaY < 0 ? 1.15 : 1 / 1.15);
}

// The page was opened: what was drawn since the last run is run at once.
function begin(play) {
  play.robots.refresh();
  if (play.version !== play.studio.model.version) run(play);
  else if (play.player) play.player.draw();
}

async function run(play) {
  const { studio, parts } = play;
  if (!studio.offered) return;
  play.asked += 1;
  const asked = play.asked,
    version = studio.model.version;
  play.runs = [];
  play.both = false;
  parts.beside.hidden = true;
  parts.said.className = "said quiet";
  parts.said.textContent = "Running …";
  play.message = { ...play.robots.message(), world: messageOf(studio.model.world) };
  try {
    await studio.connection.ask("run", play.message, (part) => asked === play.asked && take(play, part));
    play.version = version;
    if (asked === play.asked) parts.said.textContent = "";
    showBeside(play);
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    if (asked !== play.asked) return;
    parts.said.className = error instanceof Refused ? "said bad" : "said quiet";
    parts.said.textContent = error.message;
  }
}

// One part of the answer: the world, or a robot's run.
function take(play, part) {
  if (part.world !== undefined) {
    play.world = part.world;
    play.looked = 0;
    return;
  }
  play.runs.push(part);
  showTable(play);
  if (!part.error)
    look(play, play.runs[play.looked] && play.runs[play.looked].run ? play.looked : play.runs.length - 1);
}

// Shows the runs with one of them in front.
function look(play, number) {
  const { parts, runs } = play,
    front = runs[number];
  if (!front || !front.run) return;
  play.looked = number;
  const drawn = { ...sceneOf(play.world, runs, number), name: play.studio.model.world.name, saves: savesOf(play), beside: besideOf(play) };
  const former = play.player,
    seen = former && former.drawn.world === play.world && former.step < former.last ? former : null;
  const playing = seen && seen.playing;
  if (former) former.play(false);
  const shown = (player) => showInstruments(parts.instruments, player);
  play.player = buildPlayer(parts.canvas, parts.under, drawn, former, shown);
  for (const canvas of parts.stage.querySelectorAll("canvas")) canvas.style.height = ""; // the page lays it out
  if (seen) goOn(play.player, seen, playing);
  else play.player.fit();
  parts.canvas.setAttribute("aria-label", `${front.name}: ${front.words}`);
  showTable(play);
}

// Another robot of the same world is looked at: at the same time, from the same place.
function goOn(player, seen, playing) {
  player.view = seen.view;
  player.speed = seen.speed;
  player.go((seen.step * seen.drawn.run.dt) / player.drawn.run.dt);
  if (seen.follow) player.robot();
  player.play(playing);
}

function showTable(play) {
  showRobots(play.parts.list, play.runs, play.looked, (number) => look(play, number));
}

// Whether the failure that was opened, and has not changed since, is there as it was found.
async function askBefore(play) {
  const { model, connection } = play.studio;
  const version = model.version;
  play.before = null;
  try {
    const { before } = await connection.ask("before", { name: model.world.name });
    if (before && before.run && before.world && version === model.version) play.before = { ...before, version };
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
  }
  showBeside(play);
}

function showBeside(play) {
  const there = play.before && play.before.version === play.version && play.runs.length === 1 && play.player;
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

// What the server can make of the same runs: files of pictures and pages.
function savesOf(play) {
  const message = { ...play.message, looked: play.looked }; // of these runs, whatever is asked meanwhile
  const file = (words, kind) => [words, () => keepPicture(play, kind, message)];
  return [file("Animation, GIF", "gif"), file("Drawing, SVG", "svg"), file("Replay, one HTML file", "html")];
}

async function keepPicture(play, kind, message) {
  const { studio, asked, parts } = play;
  const name = (studio.model.world.name || "run").replace(/^.*\//, "").replace(/\.grid(\.gz)?$/, "");
  try {
    const answer = await studio.connection.ask("picture", { ...message, kind, title: name });
    keep(`${name}.${kind}`, new Blob([bytesOf(answer.data)]));
    return `Saved ${name}.${kind}`;
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    if (asked === play.asked) {
      parts.said.className = "said bad";
      parts.said.textContent = error.message;
    }
    return error.message;
  }
}
