// The robot at a time, and the other robots next to it.

import { poseAt, rowAt, stepWithin } from "#player/decode.js";
import { bodyPath, frontOf, robotColour, stroke } from "#player/picture/pen.js";
import { drawOtherTrail } from "#player/picture/trail.js";

/**
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @returns {number}
 */
export function bodyRadius(pen, world) {
  return Math.max(world.radius, 3 / pen.scale);
}

/**
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {Pose} pose
 * @param {RunScene} scene
 */
export function drawRobot(pen, world, pose, scene) {
  const { context, px, py, colours } = pen;
  const radius = bodyRadius(pen, world);
  // One of several in the world has the colour of its start, its target and its path.
  const own = world.others?.length ? colours[robotColour(1)] : colours.robot;
  bodyPath(pen, world.footprint, pose, radius);
  stroke(pen, pose.bump && !scene.whole ? colours.touched : own, pose.bump ? 2.5 : 1.75);
  const front = frontOf(world.footprint, radius);
  context.beginPath();
  context.moveTo(px(pose.x), py(pose.y));
  context.lineTo(px(pose.x + Math.cos(pose.heading) * front), py(pose.y + Math.sin(pose.heading) * front));
  stroke(pen, own, 2);
}

/**
 * Draws another robot at the same time: its path so far, and its disc.
 * @param {Pen} pen
 * @param {RunScene} scene
 * @param {OtherRobot} other
 */
export function drawOther(pen, scene, { run, number }) {
  const step = (scene.step * scene.run.dt) / run.dt;
  const pose = poseAt(run, stepWithin(run, step)),
    strong = pen.colours[robotColour(number)],
    body = scene.world.others?.[number - 2] ?? scene.world,
    radius = Math.max(body.radius, 3 / pen.scale),
    front = frontOf(body.footprint, radius);
  if (scene.show.trail) {
    drawOtherTrail(pen, run, strong, rowAt(run, Math.min(step, run.steps)) + 1, step <= run.steps ? pose : null);
  }
  bodyPath(pen, body.footprint, pose, radius);
  stroke(pen, strong, 2);
  pen.context.beginPath();
  pen.context.moveTo(pen.px(pose.x), pen.py(pose.y));
  const { x, y, heading } = pose;
  pen.context.lineTo(pen.px(x + Math.cos(heading) * front), pen.py(y + Math.sin(heading) * front));
  stroke(pen, strong, 2);
}
