// A world and a run at one time, drawn on a canvas, layer by layer.

import { bodyRadius, drawOther, drawRobot } from "#player/body.js";
import { drawCertificate } from "#player/certificate.js";
import { cellsAt, poseAt, stepWithin } from "#player/decode.js";
import { grouped, plural } from "#player/dom.js";
import { drawStart, drawTarget } from "#player/ends.js";
import { drawGround } from "#player/ground.js";
import { drawMemory } from "#player/memory.js";
import { drawNumbers } from "#player/numbers.js";
import { disc, penFor } from "#player/pen.js";
import { drawPierced } from "#player/pierced.js";
import { drawSenses } from "#player/senses.js";
import { drawTouched } from "#player/touched.js";
import { drawTrail } from "#player/trail.js";

/* What is drawn:
     world, run      as the page's data has them; run may be missing
     step            time, in steps
     show            { trail, witness, sensors, signal, touched, memory }: which of them
     sensors         the robot's, or null
     colour          of this robot, where there are several: the name of one in the palette
     number          of this robot, where there are several: it stands beside the robot
     others          the others: { run, colour, number }
     whole           the whole way is drawn as driven, as in small pictures */
export function drawScene(canvas, scene, view = null) {
  const { world, run } = scene;
  const pen = penFor(canvas, view, world);
  if (pen.width === 0) return;
  const ms = run ? scene.step * run.dt * 1000 : 0;
  const cells = cellsAt(world, ms);
  drawGround(pen, world, cells, scene);
  if (scene.show.witness) drawCertificate(pen, world, ms);
  drawTarget(pen, world);
  const pose = run && poseAt(run, stepWithin(run, scene.step));
  if (run && scene.show.sensors && scene.sensors) drawSenses(pen, scene, cells, pose);
  for (const other of scene.others || []) drawOther(pen, scene, other);
  if (run) disc(pen, pose.x, pose.y, bodyRadius(pen, world), pen.colours["robot-fill"]);
  if (run && scene.show.memory) drawMemory(pen, run, stepWithin(run, scene.step));
  if (run && scene.show.trail) drawTrail(pen, scene);
  if (run && scene.show.touched) drawTouched(pen, scene);
  drawStart(pen, world);
  if (!run) return;
  drawPierced(pen, scene);
  drawRobot(pen, world, pose, scene);
  drawNumbers(pen, scene);
}

// A small picture: the whole way at once, the robot where the run ends.
export function drawSmall(canvas, drawn) {
  const { world, run, sensors } = drawn;
  if (!world) return;
  const show = { trail: true, signal: true, touched: false, sensors: false, witness: false };
  drawScene(canvas, { world, run, sensors, show, whole: true, step: run ? run.steps : 0 });
}

export function pictureLabel(drawn) {
  const changes = drawn.events ? `, ${plural(drawn.events, "change")} of cells` : "";
  const run = drawn.run ? `, the robot's way of ${plural(drawn.run.steps, "step")}` : "";
  return `World of ${drawn.size} cells, ${grouped(drawn.solid)} solid${changes}${run}`;
}
