// Arrows between robots that block each other forever: from each one to the robot
// that it drives into.

import { drawHead } from "#player/picture/arrows.js";
import { shownRadius } from "#player/picture/ends.js";
import { MARKS } from "#player/picture/marks.js";
import { strokeMark } from "#player/picture/pen.js";

// radii to the right of the line between the centres, so that two robots that block each other have
// separate arrows
const ASIDE = 0.55;
const INSET = 0.3; // radii from the centres to the arrow's ends, at most a quarter of the distance

/**
 * Draws the arrows once the repeating part of the run has begun.
 * @param {Pen} pen
 * @param {SceneRobot[]} robots
 */
export function drawBlocked(pen, robots) {
  for (const { run, step, pose, radius } of robots) {
    const hasBegun = run.loop !== null && step >= run.loop[0];
    for (const blocker of hasBegun ? (run.blocked_by ?? []) : []) {
      const other = robots.find((one) => one.number === blocker);
      if (other) drawArrow(pen, pose, other.pose, shownRadius(pen, "end", radius) * pen.scale);
    }
  }
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
  pen.context.beginPath();
  pen.context.moveTo(left, top);
  pen.context.lineTo(right, bottom);
  strokeMark(pen, "blocked");
  drawHead(pen, right, bottom, angle, MARKS.blocked.size * pen.unit, pen.colours[MARKS.blocked.colour]);
}
