// Draws a world and a run at one time on a canvas, layer by layer.

import { bodyRadius, drawOther, drawRobot } from "#player/picture/body.js";
import { drawBlocked } from "#player/picture/blocked.js";
import { drawCertificate } from "#player/picture/certificate.js";
import { drawComing, drawOpenings } from "#player/picture/changes.js";
import { cellsAt, poseAt, stepWithin } from "#player/decode.js";
import { grouped, plural } from "#player/dom.js";
import { drawStart, drawTarget } from "#player/picture/ends.js";
import { drawGround } from "#player/picture/ground.js";
import { drawMemory } from "#player/picture/memory.js";
import { drawAxisNumbers, drawNamed } from "#player/picture/named.js";
import { drawNumbers } from "#player/picture/numbers.js";
import { bodyPath, penFor } from "#player/picture/pen.js";
import { drawPierced } from "#player/picture/pierced.js";
import { drawScaleBar } from "#player/picture/scale_bar.js";
import { drawSenses } from "#player/picture/senses.js";
import { drawTouched } from "#player/picture/touched.js";
import { drawTrail } from "#player/picture/trail.js";

/**
 * Draws a scene.
 * @param {HTMLCanvasElement} canvas
 * @param {Scene} scene
 * @param {View | null} [view]
 */
export function drawScene(canvas, scene, view = null) {
  const { world, run } = scene;
  // In a world of several robots, the first is in front.
  const number = scene.number ?? (scene.others?.length ? 1 : null);
  const pen = penFor(canvas, view, world);
  if (pen.width === 0) return;
  const step = scene.step ?? 0;
  const ms = run ? step * run.dt * 1000 : (scene.ms ?? 0);
  const cells = cellsAt(world, ms);
  drawGround(pen, world, cells, scene);
  if (scene.show.changes) drawComing(pen, world, cells);
  if (scene.show.witness) {
    drawCertificate(pen, world, ms);
    drawOpenings(pen, world, cells);
  }
  drawTarget(pen, world);
  if (run) drawRun(pen, { ...scene, run, step, number }, cells);
  else drawStart(pen, world, true);
  if (scene.show.cells) drawCellsOf(pen, scene);
  if (scene.show.scale !== false) drawScaleBar(pen, world);
}

/**
 * Marks the cells that the text next to a scene names. The cell in which the run broke a rule has
 * its own mark.
 * @param {Pen} pen
 * @param {Scene} scene
 */
function drawCellsOf(pen, { world, run, named = [] }) {
  drawNamed(pen, named);
  if (named.length > 0 || run?.marks.some(({ cell }) => cell)) drawAxisNumbers(pen, world);
}

/**
 * Draws the robots of a scene and everything that belongs to them, from the lowest layer to the
 * highest.
 * @param {Pen} pen
 * @param {RunScene} scene
 * @param {Uint8Array} cells
 */
function drawRun(pen, scene, cells) {
  const { world, run, show, sensors } = scene;
  const within = stepWithin(run, scene.step);
  const pose = poseAt(run, within);
  if (show.sensors && sensors) drawSenses(pen, { ...scene, sensors }, cells, pose);
  for (const other of scene.others || []) drawOther(pen, scene, other);
  bodyPath(pen, world.footprint, pose, bodyRadius(pen, world));
  pen.context.fillStyle = pen.colours["robot-fill"];
  pen.context.fill();
  if (show.memory) drawMemory(pen, run, within);
  if (show.trail) drawTrail(pen, scene);
  if (show.touched) drawTouched(pen, scene);
  drawStart(pen, world);
  drawPierced(pen, scene);
  drawRobot(pen, world, pose, scene);
  drawBlocked(pen, scene);
  drawNumbers(pen, scene);
}

/**
 * Draws a small picture: the whole path, and the robot where the run ends.
 * @param {HTMLCanvasElement} canvas
 * @param {Pick<DrawnFailure, "world" | "run" | "sensors" | "number" | "others" | "named">} drawn
 * @param {Partial<Shown>} [more] - Further layers
 */
export function drawSmall(canvas, drawn, more = {}) {
  const { world } = drawn;
  if (!world) return;
  const show = { trail: true, signal: true, touched: false, sensors: false, witness: false, ...more };
  const { run, sensors, number, others, named } = drawn;
  const last = Math.max(...[run, ...(others ?? []).map((other) => other.run)].map((one) => one?.steps ?? 0));
  drawScene(canvas, { world, run, sensors, number, others, named, show, whole: true, step: last });
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
