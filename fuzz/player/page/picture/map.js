// Draws a world and a run at one time on a canvas, layer by layer.

import { cellsAt, stepWithin } from "#player/decode.js";
import { grouped, plural } from "#player/dom.js";
import { drawBlocked } from "#player/picture/blocked.js";
import { drawEnd, drawNearest, drawOutlines, drawRobot } from "#player/picture/body.js";
import { drawCut, drawCutPoses, drawWitness } from "#player/picture/certificate.js";
import { drawBurnt, drawChangeLabels, drawComing, drawOpenings } from "#player/picture/changes.js";
import { drawBegan, drawHeadings, drawStart, drawTarget, drawWaypoints } from "#player/picture/ends.js";
import { drawFloor, drawGrid, drawSignal, drawWalls } from "#player/picture/ground.js";
import { MARKS } from "#player/picture/marks.js";
import { drawMemory, drawRemembered } from "#player/picture/memory.js";
import { drawAxisNumbers, drawNamed } from "#player/picture/named.js";
import { drawNumbers } from "#player/picture/numbers.js";
import { penFor } from "#player/picture/pen.js";
import { drawPierced } from "#player/picture/pierced.js";
import { drawScaleBar } from "#player/picture/scale_bar.js";
import { drivenIn } from "#player/picture/scene_robots.js";
import { drawBarred, drawDistance } from "#player/picture/shortfall.js";
import { drawBearing, drawBeams } from "#player/picture/senses.js";
import { drawTouched } from "#player/picture/touched.js";
import { drawAhead, drawApproach, drawBand, drawBreachPath, drawLoop } from "#player/picture/trail.js";
import { drawOff, eventView } from "#player/picture/view.js";

/**
 * What is on by default: the path that exists as much as the one that is driven.
 * @type {Record<Layer | "cells", boolean>}
 */
export const SHOWN = { trail: true, witness: true, touched: true, sensors: true, signal: true, changes: true, cells: true, memory: true };

const GRID = 9; // pixels per cell above which the cells' borders are drawn

/**
 * Draws a mark, by its name in `marks.json`, which has their order.
 * @type {Record<string, (stage: Stage) => void>}
 */
const DRAWN = {
  floor: ({ pen, world }) => drawFloor(pen, world),
  // The floor cannot show the signals of several targets.
  signal: ({ pen, world, show, sensors }) => show.signal && sensors?.signal && !world.others?.length && drawSignal(pen, world),
  grid: ({ pen, world, show }) => pen.scale > GRID && show.grid !== false && drawGrid(pen, world),
  remembered: ({ pen, front, show }) => front && show.memory && drawRemembered(pen, front.run, front.within),
  burnt: ({ pen, world, cells }) => drawBurnt(pen, world, cells),
  wall: ({ pen, world, cells }) => drawWalls(pen, world, cells),
  burns: ({ pen, world, cells, show }) => show.changes && drawComing(pen, world, cells),
  touched: ({ pen, world, robots, show, whole }) => show.touched && drawTouched(pen, world, robots, whole),
  cut: ({ pen, world, show }) => show.witness && drawCut(pen, world),
  "cut-poses": ({ pen, world, show }) => show.witness && drawCutPoses(pen, world),
  band: ({ pen, robots, show, whole }) => show.trail && robots.forEach((one) => drawBand(pen, one, whole)),
  start: ({ pen, world, robots, whole }) => (whole && robots.length > 0) || drawStart(pen, world),
  began: ({ pen, world, robots, whole }) => whole && robots.length > 0 && drawBegan(pen, world),
  end: ({ pen, world, robots, whole }) => whole && robots.forEach((one) => drawEnd(pen, world, one)),
  nearest: ({ pen, world, robots, whole }) => whole && robots.length === 1 && drawNearest(pen, world, robots[0]),
  witness: ({ pen, world, show, whole, ms, cells }) => {
    if (!show.witness) return;
    drawWitness(pen, world, whole ? null : ms);
    if (!whole) drawOpenings(pen, world, cells);
  },
  ahead: ({ pen, robots, show, whole }) => show.trail && !whole && robots.forEach((one) => drawAhead(pen, one)),
  approach: ({ pen, robots, show, whole }) => show.trail && robots.forEach((one) => drawApproach(pen, one, whole)),
  body: ({ pen, robots, show, whole }) => show.trail && whole && robots.forEach((one) => drawOutlines(pen, one)),
  loop: ({ pen, robots, show, whole, scene }) => {
    if (!show.trail) return;
    robots.forEach((one) => drawLoop(pen, one, whole));
    if (scene) drawBreachPath(pen, scene);
  },
  heading: ({ pen, world, robots, whole }) => (whole && robots.length > 0) || drawHeadings(pen, world),
  memory: ({ pen, front, show }) => front && show.memory && drawMemory(pen, front.run, front.within),
  pierced: ({ pen, scene }) => scene && drawPierced(pen, scene),
  barred: ({ pen, world, robots, show, whole }) => show.trail && whole && robots.length === 1 && drawBarred(pen, world, robots[0]),
  short: ({ pen, world, robots, show, whole }) => show.trail && whole && robots.length === 1 && drawDistance(pen, world, robots[0]),
  since: ({ pen, world, robots, show, whole }) => show.changes && whole && drawChangeLabels(pen, world, robots),
  target: ({ pen, world }) => drawTarget(pen, world),
  waypoint: ({ pen, world }) => drawWaypoints(pen, world),
  beam: ({ pen, scene, cells, front, show, sensors, whole }) => !whole && scene && front && show.sensors && sensors && drawBeams(pen, { ...scene, sensors }, cells, front.pose),
  bearing: ({ pen, scene, front, show, sensors, whole }) => !whole && scene && front && show.sensors && sensors && drawBearing(pen, scene, front.pose),
  driving: ({ pen, robots, whole }) => !whole && robots.forEach((one) => drawRobot(pen, one)),
  blocked: ({ pen, robots }) => drawBlocked(pen, robots),
  number: ({ pen, world, robots, show }) => show.numbers !== false && drawNumbers(pen, world, robots, Boolean(show.trail)),
  named: ({ pen, world, show, named, run }) => {
    if (!show.cells) return;
    drawNamed(pen, named);
    if (named.length > 0 || run?.marks.some(({ cell }) => cell)) drawAxisNumbers(pen, world);
  },
  off: ({ pen, world, isCard }) => isCard && drawOff(pen, world),
  scale: ({ pen, world, show }) => show.scale !== false && drawScaleBar(pen, world),
};

/**
 * Draws a scene, the lowest mark first.
 * @param {HTMLCanvasElement} canvas
 * @param {Scene} scene
 * @param {View | null} [view]
 */
export function drawScene(canvas, scene, view = null) {
  const { world, run, show, sensors, named = [], whole = false, isCard = false } = scene;
  const pen = penFor(canvas, view, world, scene.on);
  if (pen.width === 0) return;
  const step = scene.step ?? 0;
  // A still picture shows the cells as they are at first, and what they become.
  const ms = run && whole ? 0 : run ? step * run.dt * 1000 : (scene.ms ?? 0);
  const driven = run ? runScene(scene, run) : null,
    robots = driven ? drivenIn(driven) : [],
    last = robots[robots.length - 1];
  const stage = {
    pen, world, run, show, sensors, named, whole, isCard, ms, robots,
    scene: driven,
    cells: cellsAt(world, ms),
    front: last ? { ...last, within: stepWithin(last.run, step) } : null,
  };
  for (const [name, { on_cards }] of Object.entries(MARKS)) if (!isCard || on_cards) DRAWN[name]?.(stage);
}

/**
 * @param {Scene} scene
 * @param {DrawnRun} run
 * @returns {RunScene}
 */
export function runScene(scene, run) {
  // In a world of several robots, the first is in front.
  return { ...scene, run, step: scene.step ?? 0, number: scene.number ?? (scene.others?.length ? 1 : null) };
}

/**
 * Draws a small picture: the whole run, cropped to what happens in it.
 * @param {HTMLCanvasElement} canvas
 * @param {Pick<DrawnFailure, "world" | "run" | "sensors" | "number" | "others" | "named">} drawn
 * @param {Partial<Shown>} [more] - Further layers
 */
export function drawSmall(canvas, drawn, more = {}) {
  const { world } = drawn;
  if (!world) return;
  const scene = stillOf({ ...drawn, world }, { ...SHOWN, cells: false, ...more });
  const driven = scene.run ? runScene(scene, scene.run) : null;
  // A picture next to a text that names cells by their numbers shows all of them.
  const view = driven && !scene.show.cells ? eventView(driven, canvas.clientWidth, canvas.clientHeight) : null;
  drawScene(canvas, { ...scene, isCard: true }, view);
}

/**
 * Returns the scene of a whole run, as a still picture shows it.
 * @param {Pick<DrawnFailure, "run" | "sensors" | "number" | "others" | "named"> & {world: SceneWorld}} drawn
 * @param {Shown} show
 * @returns {Scene}
 */
function stillOf({ world, run, sensors, number, others, named }, show) {
  const last = Math.max(...[run, ...(others ?? []).map((other) => other.run)].map((one) => one?.steps ?? 0));
  return { world, run, sensors, number, others, named, show, whole: true, step: last };
}

/**
 * @param {DrawnFailure} drawn
 * @returns {string}
 */
export function pictureLabel(drawn) {
  const changes = drawn.events ? `, ${plural(drawn.events, "change")} of cells` : "";
  const run = drawn.run ? `, the robot's path of ${plural(drawn.run.steps, "step")}` : "";
  return `World of ${drawn.size} cells, ${grouped(drawn.solid)} solid${changes}${run}`;
}
