// The page on which robots drive: who, how, and the player that reports have, too.

import { buildPlayer, dragToMove } from "/player/controls.js";
import { behaviourAt, poseAt, rowAt, stepWithin } from "/player/decode.js";
import { el, grouped, verdictDot } from "/player/dom.js";
import { Ended, Refused } from "./connection.js";
import { messageOf } from "./model.js";
import { makeRobots } from "./robots.js";

/* The page.
     studio    { model, connection, offered, ... }: what all pages share */
export function makePlay(section, studio) {
  const parts = {
    canvas: el("canvas", { id: "stage", role: "img", "aria-label": "The run" }),
    under: el("div", { class: "under" }),
    table: el("div", { class: "results" }),
    said: el("p", { class: "said", role: "status", id: "run-said" }),
    instruments: el("p", { class: "instruments", id: "instruments" }),
  };
  const play = { studio, parts, player: null, runs: [], world: null, looked: 0, version: -1, asked: 0 };
  play.robots = makeRobots(studio, () => run(play));
  section.replaceChildren(
    el("div", { class: "middle" }, el("div", { class: "stage" }, parts.canvas), parts.instruments, parts.under),
    el("aside", { class: "side" }, play.robots.element, parts.said, parts.table),
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
    prefer: (failure) => play.robots.prefer(failure),
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
  parts.said.className = "said quiet";
  parts.said.textContent = "Running …";
  const message = { ...play.robots.message(), world: messageOf(studio.model.world) };
  try {
    await studio.connection.ask("run", message, (part) => asked === play.asked && take(play, part));
    play.version = version;
    if (asked === play.asked) parts.said.textContent = "";
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
  const alone = runs.filter((one) => one.run).length === 1;
  const colour = (k) => `robot-${k % 6}`;
  const drawn = {
    world: play.world,
    run: front.run,
    sensors: front.sensors,
    colour: alone ? null : colour(number),
    others: runs.map((one, k) => ({ run: one.run, colour: colour(k) })).filter((one, k) => k !== number && one.run),
  };
  const former = play.player,
    seen = former && former.drawn.world === play.world && former.step < former.last ? former : null;
  const playing = seen && seen.playing;
  if (former) former.play(false);
  play.player = buildPlayer(parts.canvas, parts.under, drawn, former, (player) => showInstruments(play, player));
  parts.canvas.style.height = ""; // the page lays it out
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
  const { parts, runs } = play;
  const several = runs.length > 1;
  const row = (one, number) => {
    const chip = several ? el("i", { class: `chip robot-${number % 6}` }) : null;
    if (one.error) return el("li", {}, chip, el("b", {}, one.name), el("p", { class: "bad" }, one.error));
    return el(
      "li",
      { "aria-current": number === play.looked ? "true" : null },
      el(
        "button",
        { type: "button", class: "result", "data-controller": one.name, onclick: () => look(play, number) },
        el("span", { class: "who" }, chip, el("b", {}, one.name), verdictDot(one.verdict), el("span", {}, one.verdict)),
        el(
          "span",
          { class: "quiet" },
          `${grouped(one.steps)} steps, ${one.time.toFixed(3)} s, ${one.path.toFixed(2)} m, ${one.collisions} collisions`,
        ),
        one.verdict === "reached" ? null : el("span", {}, one.words.replace(/^\w+\s*/, "")),
        el("code", { class: "digest", title: "Digest of every state of the run" }, one.digest),
      ),
    );
  };
  parts.table.replaceChildren(el("ol", { "aria-label": "Results" }, runs.map(row)));
}

const DEGREES = 180 / Math.PI;

// What the robot's own instruments would say at this time.
function showInstruments(play, player) {
  const { run, world } = player.drawn;
  const step = stepWithin(run, player.step),
    pose = poseAt(run, step),
    side = world.cell;
  const behaviour = behaviourAt(run, rowAt(run, step));
  const heading = (((pose.heading * DEGREES) % 360) + 360) % 360;
  const facts = [
    ["time", `${(player.step * run.dt).toFixed(3)} s`],
    ["x, y", `${(pose.x * side).toFixed(3)}, ${(pose.y * side).toFixed(3)} m`],
    ["heading", `${heading.toFixed(1)}°`],
    ["collision", pose.bump ? "yes" : "no"],
    ...(behaviour === null ? [] : [["behaviour", behaviour]]),
    ...(run.loop && step >= run.loop[0]
      ? [["loop", `period ${grouped(run.loop[1])}, step ${Math.floor(step - run.loop[0])} of it`]]
      : []),
  ];
  play.parts.instruments.replaceChildren(
    ...facts.map(([name, value]) => el("span", {}, `${name} `, el("b", {}, value))),
  );
}
