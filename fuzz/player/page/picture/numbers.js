// Robots' numbers, next to them and along their paths, for people who cannot tell the colours
// apart.

import { bodyRadius } from "#player/picture/body.js";
import { openRun, poseAt, rowAt, stepWithin } from "#player/decode.js";
import { robotColour } from "#player/picture/pen.js";

// cells before the first number on a path; the next is twice as far along, and so on
const FIRST = 6;
const INSIDE = 9; // pixels: radius of a disc with room for its number
const APART = 18; // minimum distance in pixels between two numbers, or a number and a robot

/**
 * Returns the rows of a path that carry the robot's number, each twice as far along as the one
 * before. The first distance differs between robots, because their paths may coincide.
 * @param {DrawnRun} run
 * @param {number} number
 * @returns {number[]}
 */
function numberedRows(run, number) {
  const open = openRun(run);
  if (open.numbered) return open.numbered;
  open.numbered = [];
  let driven = 0,
    next = FIRST * (1 + (number % 6) / 6);
  for (let row = 1; row < open.x.length; row += 1) {
    driven += Math.hypot(open.x[row] - open.x[row - 1], open.y[row] - open.y[row - 1]);
    if (driven < next) continue;
    open.numbered.push(row);
    while (next <= driven) next *= 2;
  }
  return open.numbered;
}

/**
 * Draws the numbers of all robots, if there are several.
 * @param {Pen} pen
 * @param {RunScene} scene - As for drawScene; without a number there is only one robot
 */
export function drawNumbers(pen, { run, step, world, show, number, others }) {
  if (!number) return;
  const all = [...(others || []), { run, number }].map((one) => ({ ...one, step: (step * run.dt) / one.run.dt }));
  const places = [];
  for (const one of all) {
    const pose = poseAt(one.run, stepWithin(one.run, one.step)),
      aside = bodyRadius(pen, world) * pen.scale;
    // In the middle of a disc that has room, as in the static pictures; else next to it.
    const isInside = aside >= INSIDE,
      x = pen.px(pose.x) + (isInside ? -4 : aside + 3),
      y = pen.py(pose.y) + (isInside ? 5 : -aside - 1);
    places.push([x + 4, y - 5]);
    drawNumber(pen, one.number, x, y);
  }
  if (!show.trail) return;
  for (const one of all) drawAlong(pen, one, places);
}

// Draws numbers along the path driven so far, except where another number would be too close.
function drawAlong(pen, one, places) {
  const { x, y } = openRun(one.run),
    here = rowAt(one.run, Math.min(one.step, one.run.steps));
  pen.context.save();
  pen.context.textAlign = "center";
  for (const row of numberedRows(one.run, one.number)) {
    if (row > here) break;
    const place = [pen.px(x[row]), pen.py(y[row])];
    if (places.some(([left, top]) => Math.hypot(left - place[0], top - place[1]) < APART)) continue;
    places.push(place);
    drawNumber(pen, one.number, place[0], place[1] + 5);
  }
  pen.context.restore();
}

/**
 * Draws a robot's number at a place in pixels, in its colour or in another one.
 * @param {Pen} pen
 * @param {number} number
 * @param {number} across
 * @param {number} down
 * @param {string} [colour]
 */
export function drawNumber(pen, number, across, down, colour = pen.colours[robotColour(number)]) {
  const { context, colours } = pen;
  context.font = "700 13px system-ui, sans-serif";
  context.lineWidth = 4;
  context.strokeStyle = colours.floor;
  context.fillStyle = colour;
  context.strokeText(String(number), across, down);
  context.fillText(String(number), across, down);
}
