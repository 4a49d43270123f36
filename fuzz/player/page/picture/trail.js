// The path of the robot: faint ahead, strong where it has driven.

import { drawHeads } from "#player/picture/arrows.js";
import { openRun, poseAt, rowAt } from "#player/decode.js";
import { drawLine } from "#player/picture/long_line.js";
import { line, robotColour, stroke } from "#player/picture/pen.js";

const RECENT = 300; // rows of a long path that are drawn strongest
const FADES = 5; // steps over which the recent path fades

/**
 * Draws the path; the period of a loop has its own colour, or a stronger line in the robot's
 * colour.
 * @param {Pen} pen
 * @param {RunScene} scene
 */
export function drawTrail(pen, scene) {
  const { run } = scene,
    open = openRun(run),
    { colours, context } = pen;
  const here = rowAt(run, scene.step),
    rows = open.at.length;
  const entry = run.loop ? rowAt(run, run.loop[0]) : rows;
  const end = scene.whole ? rows : here + 1,
    pose = scene.whole || scene.step > run.steps ? null : poseAt(run, scene.step);
  const own = scene.number ? colours[robotColour(scene.number)] : colours.loop;
  const before = run.loop && !scene.number ? colours.way : own,
    last = Math.min(end, entry + 1);
  const recent = Math.max(0, last - RECENT),
    part = (name, look) => drawLine(pen, open, name, { alpha: 1, once: scene.whole, ...look });
  // From the lowest layer to the highest: ahead, driven long ago, driven recently, the loop.
  if (!scene.whole) part("ahead", { from: 0, to: rows, colour: colours.ahead, width: 1.25, alpha: 0.45 });
  part("before", { from: 0, to: recent + 1, colour: before, width: 1.75, alpha: 0.4 });
  const strong = run.loop && scene.number ? 0.5 : 1;
  for (let part = 0; part < FADES; part += 1) {
    const [from, to] = [part, part + 1].map((k) => recent + Math.round(((last - recent) * k) / FADES));
    context.globalAlpha = scene.whole ? strong : strong * (0.4 + (0.6 * (part + 1)) / FADES);
    line(pen, open.x, open.y, Math.max(0, from - 1), to, part === FADES - 1 && end <= entry ? pose : null);
    stroke(pen, before, 2.25);
  }
  context.globalAlpha = 1;
  if (end > entry) {
    const width = scene.number ? 3.5 : 2.75;
    part("loop", { from: entry, to: end, colour: own, width });
    line(pen, open.x, open.y, end - 1, end, pose);
    stroke(pen, own, width);
  }
  drawHeads(pen, open, 0, Math.min(end, entry + 1), before);
  if (end > entry) drawHeads(pen, open, entry, end, own);
  drawBreachPath(pen, run, scene);
}

/**
 * Draws another robot's path up to a row, and from there to its current place; faint up to a loop, and the loop stronger.
 * @param {Pen} pen
 * @param {DrawnRun} run
 * @param {string} colour
 * @param {number} until
 * @param {Pose | null} pose
 */
export function drawOtherTrail(pen, run, colour, until, pose) {
  const open = openRun(run),
    entry = run.loop ? rowAt(run, run.loop[0]) : until,
    loops = until > entry + 1;
  drawLine(pen, open, "other", { from: 0, to: loops ? entry + 1 : until, colour, width: loops ? 1.25 : 2, alpha: loops ? 0.4 : 1 });
  if (loops) drawLine(pen, open, "other-loop", { from: entry, to: until, colour, width: 3, alpha: 1 });
  line(pen, open.x, open.y, until - 1, until, pose);
  stroke(pen, colour, loops ? 3 : 2);
  drawHeads(pen, open, loops ? entry : 0, until, colour);
}

// Draws the path of the step that breaks the world's rules.
function drawBreachPath(pen, run, scene) {
  const open = openRun(run);
  for (const mark of run.marks) {
    if (!mark.cell || (!scene.whole && scene.step < mark.step)) continue;
    line(pen, open.x, open.y, Math.max(0, rowAt(run, mark.step - 1)), rowAt(run, mark.step) + 1);
    stroke(pen, pen.colours.breach, 4);
  }
}
