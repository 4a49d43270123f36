// Arrows between robots that block each other forever: from each one to the robot
// that it drives into.

import { drawHead } from "#player/picture/arrows.js";
import { bodyRadius } from "#player/picture/body.js";
import { poseAt, stepWithin } from "#player/decode.js";

// radii to the right of the line between the centres, so that two robots that block each other have
// separate arrows
const ASIDE = 0.55;
const INSET = 0.3; // radii from the centres to the arrow's ends, at most a quarter of the distance

/**
 * Draws the arrows once the repeating part of the run has begun.
 * @param {Pen} pen
 * @param {RunScene} scene
 */
export function drawBlocked(pen, { world, run, step, number, others }) {
  const all = [{ run, number }, ...(others ?? [])].map((one) => ({
    number: one.number,
    radius: pen.scale * (one.number === 1 ? bodyRadius(pen, world) : (world.others?.[Number(one.number) - 2]?.radius ?? world.radius)),
    blockers: hasBegun(one.run, step * run.dt) ? (one.run.blocked_by ?? []) : [],
    pose: poseAt(one.run, stepWithin(one.run, (step * run.dt) / one.run.dt)),
  }));
  for (const { pose, radius, blockers } of all)
    for (const blocker of blockers) {
      const other = all.find((one) => one.number === blocker);
      if (other) drawArrow(pen, pose, other.pose, radius);
    }
}

/**
 * @param {DrawnRun} run
 * @param {number} time - s
 * @returns {boolean}
 */
function hasBegun(run, time) {
  return run.loop !== null && time >= run.loop[0] * run.dt;
}

/**
 * @param {Pen} pen
 * @param {Pose} from
 * @param {Pose} to
 * @param {number} radius - pixels
 */
function drawArrow(pen, from, to, radius) {
  const x = pen.px(from.x),
    y = pen.py(from.y);
  const angle = Math.atan2(pen.py(to.y) - y, pen.px(to.x) - x),
    length = Math.hypot(pen.py(to.y) - y, pen.px(to.x) - x),
    inset = Math.min(INSET * radius, length / 4);
  if (length === 0) return;
  const at = (/** @type {number} */ along) => [
    x + along * Math.cos(angle) - ASIDE * radius * Math.sin(angle),
    y + along * Math.sin(angle) + ASIDE * radius * Math.cos(angle),
  ];
  const [left, top] = at(inset);
  const [right, bottom] = at(length - inset);
  const { context, colours } = pen;
  for (const [colour, width] of [[colours.floor, 4], [colours.robot, 2]]) {
    context.beginPath();
    context.moveTo(left, top);
    context.lineTo(right, bottom);
    context.strokeStyle = String(colour);
    context.lineWidth = Number(width);
    context.stroke();
  }
  context.fillStyle = colours.robot;
  drawHead(pen, right, bottom, angle);
}
