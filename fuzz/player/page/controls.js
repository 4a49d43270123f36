// The controls below the stage: timeline, clock buttons, layers and camera.

import { openWorld } from "#player/decode.js";
import { choice, el, grouped, icon, keyButton } from "#player/dom.js";
import { legendOf } from "#player/legend.js";
import { hasMap } from "#player/picture/memory.js";
import { robotColour } from "#player/picture/pen.js";
import { SPEEDS, makePlayer, usualSpeed } from "#player/player.js";
import { makePlots } from "#player/plots.js";
import { saveMenu } from "#player/saving.js";
import { makeTimeline } from "#player/timeline.js";

export const LAYERS = {
  trail: ["Trail", "t"],
  touched: ["Touched walls", "u"],
  sensors: ["Sensors", "s"],
  signal: ["Signal", "i"],
  memory: ["Memory", "m"],
  witness: ["Witness", "w"],
  changes: ["Changes to come", "c"],
};

/**
 * Builds the controls below the stage. Keeps earlier choices, such as layers; calls `also` after
 * each change.
 * @param {HTMLCanvasElement} canvas
 * @param {HTMLElement} under
 * @param {Drawn} drawn
 * @param {Player | null} former
 * @param {(player: Player) => void} [also]
 * @returns {Player}
 */
export function buildPlayer(canvas, under, drawn, former, also = () => {}) {
  const parts = {};
  fitStage(canvas, drawn.world);
  if (drawn.beside) drawn.beside.canvas.style.height = canvas.style.height;
  const player = makePlayer(canvas, drawn, (now) => {
    showState(now, parts);
    also(now);
  });
  if (former) Object.assign(player.show, former.show);
  if (!drawn.run) {
    const why = "The controller could not be run here, so the world is shown without the robot's path.";
    under.replaceChildren(el("p", { class: "notice" }, drawn.why || why), viewButtons(player, parts), legendOf(drawn));
    player.draw();
    return player;
  }
  const jump = (step) => jumpTo(player, step);
  const fill = () => {
    parts.timeline = makeTimeline(player, jump);
    parts.plots = makePlots(player, parts.timeline, jump);
    player.zoomTime = parts.timeline.zoom;
    under.replaceChildren(
      parts.timeline.element,
      el("div", { class: "below-timeline" }, parts.plots.element, parts.timeline.buttons),
      controls(player, parts),
      robotButtons(player, (number) => {
        bringToFront(player, number);
        fill();
        /** @type {HTMLElement | null} */ (under.querySelector(`[data-robot="${number}"]`))?.focus();
      }),
      layers(player, parts),
      legendOf(drawn),
      ...thinNote([player.drawn.run, ...(drawn.others ?? []).map(({ run }) => run)]),
    );
    player.update();
  };
  fill();
  // Who blocks whom is small in a large world.
  if ([drawn.run, ...(drawn.others ?? []).map(({ run }) => run)].some((run) => run.blocked_by?.length)) player.event();
  return player;
}

/**
 * Makes a button for each of several robots of one world, which brings it to the front; none for
 * one robot, or if a list of the page does that.
 * @param {Player} player
 * @param {(number: number) => void} bring
 * @returns {HTMLElement | string}
 */
function robotButtons({ drawn }, bring) {
  if (!drawn.world.others?.length || !drawn.others?.length) return "";
  const front = drawn.number ?? 1,
    numbers = [front, ...drawn.others.map(({ number }) => number)].sort((a, b) => a - b);
  const chip = (number) => el("span", { class: `chip ${robotColour(number)}` }, String(number));
  return el(
    "div",
    { class: "controls", role: "group", "aria-label": "Robot in front" },
    numbers.map((number) => el("button", { type: "button", "data-robot": number, "aria-pressed": String(number === front), onclick: () => bring(number) }, chip(number), ` Robot ${number}`)),
  );
}

/**
 * Puts one of several robots in front: it is drawn last, and timeline and plots are about it.
 * @param {Player} player
 * @param {number} number
 */
function bringToFront({ drawn }, number) {
  const { run, others = [] } = drawn,
    next = others.find((one) => one.number === number);
  if (!run || !next) return;
  const rest = [{ run, number: drawn.number ?? 1 }, ...others.filter((one) => one !== next)];
  Object.assign(drawn, { ...next, others: rest.sort((a, b) => a.number - b.number) });
}

// As tall as the world needs at this width, but short enough to leave room for the controls in the
// window.
function fitStage(canvas, world) {
  const wanted = canvas.clientWidth * ((world.height + 0.5) / (world.width + 0.5));
  canvas.style.height = `${Math.round(Math.max(240, Math.min(wanted, innerHeight * 0.58)))}px`;
}

function viewButtons(player, parts) {
  parts.follow = player.drawn.run ? keyButton("Follow", "Follow the robot", "r", () => toggleFollow(player)) : null;
  return el(
    "div",
    { class: "view", role: "group", "aria-label": "View" },
    keyButton("−", "Zoom out", "-", () => player.zoom(1 / 1.4)),
    keyButton("+", "Zoom in", "+", () => player.zoom(1.4)),
    keyButton("Fit", "Fit the whole world", "0", () => player.fit()),
    player.drawn.run ? keyButton("Event", "Zoom to what happens", "z", () => player.event()) : null,
    parts.follow,
  );
}

/** @param {Player} player */
export function toggleFollow(player) {
  if (player.follow) player.fit();
  else player.robot();
}

function controls(player, parts) {
  parts.play = keyButton("", "Play", "Space", () => player.play(!player.playing), { class: "main", id: "play-pause" });
  parts.speed = choice(
    SPEEDS.map((speed) => [speed, `${speed}×`]),
    player.speed,
    (event) => {
      player.speed = Number(event.target.value);
    },
  );
  parts.readout = el("span", { class: "readout", id: "readout" });
  return el(
    "div",
    { class: "controls" },
    keyButton(icon("first"), "To the start", "Home", () => jumpTo(player, 0)),
    keyButton(icon("back"), "One step back", "←", () => stepBy(player, -1)),
    parts.play,
    keyButton(icon("on"), "One step forward", "→", () => stepBy(player, 1)),
    keyButton(icon("last"), "To the end", "End", () => jumpTo(player, player.last)),
    jumpButtons(player, parts),
    el("label", { class: "field" }, "Speed", parts.speed),
    parts.readout,
  );
}

function jumpButtons(player, parts) {
  const { run } = player.drawn,
    jumps = [...run.marks];
  if (run.loop) {
    parts.period = keyButton("One period", "One period, repeated", "l", () => playPeriod(player));
    jumps.push({
      step: run.loop[0] + run.loop[1],
      name: "End of period",
      text: "the entry state recurs",
    });
  }
  return [
    parts.period,
    jumps.map(({ step, name, text }) =>
      el(
        "button",
        { type: "button", title: `Step ${step}: ${text}`, onclick: () => jumpTo(player, step) },
        `${name} ${grouped(step)}`,
      ),
    ),
  ];
}

/**
 * @param {Player} player
 * @param {number} step
 */
export function jumpTo(player, step) {
  player.play(false);
  player.go(step);
}

/**
 * @param {Player} player
 * @param {number} steps
 */
export function stepBy(player, steps) {
  jumpTo(player, (steps > 0 ? Math.floor(player.step) : Math.ceil(player.step)) + steps);
}

/**
 * Goes to the next marked step, or from the last one to the first.
 * @param {Player} player
 */
export function nextMark(player) {
  const marks = player.drawn.run?.marks ?? [];
  const next = marks.find((mark) => mark.step > player.step) || marks[0];
  if (next) jumpTo(player, next.step);
}

/** @param {Player} player */
export function playPeriod(player) {
  const { run } = player.drawn;
  if (!run?.loop) return;
  player.period = !player.period;
  if (player.period) {
    player.step = run.loop[0];
    player.speed = usualSpeed(run.loop[1], run.dt);
    player.play(true);
  }
  player.update();
}

function layers(player, parts) {
  const { drawn } = player,
    has = {
      sensors: drawn.sensors,
      signal: drawn.sensors && drawn.sensors.signal,
      memory: hasMap(drawn.run),
      witness: openWorld(drawn.world).witness || drawn.world.cut,
      changes: drawn.world.events || drawn.world.open?.events,
    };
  const names = Object.keys(LAYERS).filter((name) => !(name in has) || has[name]);
  parts.layers = Object.fromEntries(
    names.map((name) => [
      name,
      el("input", { type: "checkbox", "aria-keyshortcuts": LAYERS[name][1], onchange: () => show(name) }),
    ]),
  );
  const show = (name) => {
    player.reveal(name, parts.layers[name].checked);
  };
  const words = (name) => (name === "witness" && drawn.world.cut ? "Cut" : LAYERS[name][0]);
  const boxes = names.map((name) =>
    el("label", { class: "check", title: `Key ${LAYERS[name][1]}` }, parts.layers[name], words(name)),
  );
  return el(
    "div",
    { class: "controls" },
    el("div", { class: "layers", role: "group", "aria-label": "Layers" }, boxes),
    viewButtons(player, parts),
    saveMenu(player),
  );
}

function thinNote(runs) {
  const [run] = runs.sort((a, b) => b.thinned - a.thinned);
  if (run.thinned === 1) return [];
  return [
    el(
      "p",
      { class: "quiet" },
      `This run is long (${grouped(run.steps)} steps). The page includes the important steps and at least one in ${run.thinned} of the others, with straight lines between them.`,
    ),
  ];
}

function showState(player, parts) {
  const { run } = player.drawn;
  if (!run) return;
  const step = Math.min(player.last, Math.floor(player.step + 1e-9));
  parts.timeline.draw(step, `step ${step} of ${player.last}${momentOf(run, step)}`);
  parts.plots.draw();
  parts.play.replaceChildren(icon(player.playing ? "pause" : "play"), player.playing ? "Pause" : "Play");
  parts.play.setAttribute("aria-label", player.playing ? "Pause" : "Play");
  parts.speed.value = player.speed;
  if (parts.period) parts.period.setAttribute("aria-pressed", String(player.period));
  if (parts.follow) parts.follow.setAttribute("aria-pressed", String(player.follow));
  for (const [name, box] of Object.entries(parts.layers)) box.checked = player.show[name];
  parts.readout.title = momentOf(run, step).slice(2);
  parts.readout.replaceChildren(
    "step ",
    el("b", {}, grouped(step)),
    ` of ${grouped(player.last)}, ${(step * run.dt).toFixed(3)} s${momentOf(run, step)}`,
  );
}

function momentOf(run, step) {
  const mark = run.marks.find((one) => one.step === step);
  if (mark) return `: ${mark.text}`;
  if (!run.loop || step < run.loop[0]) return "";
  // If other robots drive longer, a loop repeats many times.
  const into = (step - run.loop[0]) % run.loop[1];
  return into === 0 ? ": the entry state again" : `, ${into} into the period`;
}

/**
 * @param {HTMLElement} canvas
 * @param {{player: Player | null}} state
 */
export function dragToMove(canvas, state) {
  /** @type {[number, number] | null} */
  let last = null;
  canvas.addEventListener("pointerdown", (event) => {
    if (!state.player || !state.player.view) return;
    last = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!last || !state.player) return;
    state.player.move(event.clientX - last[0], event.clientY - last[1]);
    last = [event.clientX, event.clientY];
  });
  canvas.addEventListener("pointerup", () => {
    last = null;
  });
}
