// Robots' numbers, next to them and along their paths, for people who cannot tell the colours
// apart.

import { openRun } from "#player/decode.js";
import { MARKS } from "#player/picture/marks.js";
import { robotColour } from "#player/picture/pen.js";
import { endsOf } from "#player/picture/scene_robots.js";

// cells before the first number on a path; the next is twice as far along, and so on
const FIRST = 6;
const INSIDE = 9; // units: radius of a disc with room for its number
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
 * Draws the numbers of several robots: at their targets, where they are, and along their paths.
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {SceneRobot[]} robots
 * @param {boolean} hasTrails
 */
export function drawNumbers(pen, world, robots, hasTrails) {
  const { unit } = pen,
    size = MARKS.number.size * unit;
  for (const { target: [x, y, radius], start, number } of endsOf(world)) {
    if (!number) continue;
    const away = radius + (9 * unit) / pen.scale;
    drawNumber(pen, number, pen.px(x + away), pen.py(y + away) + 0.36 * size);
    // Without a run it is at its start.
    if (robots.length === 0) drawNumber(pen, number, pen.px(start[0]), pen.py(start[1]) + 0.36 * size);
  }
  const places = [];
  for (const { number, pose, radius } of robots) {
    if (!number) continue;
    // In the middle of a disc that has room, else next to it.
    const aside = radius * pen.scale,
      isInside = aside >= INSIDE * unit,
      x = pen.px(pose.x) + (isInside ? 0 : aside + 7 * unit),
      y = pen.py(pose.y) + 0.36 * size - (isInside ? 0 : aside + 6 * unit);
    places.push([x, y - 5]);
    drawNumber(pen, number, x, y);
  }
  if (!hasTrails) return;
  for (const one of robots) if (one.number) drawAlong(pen, one, places);
}

// Draws numbers along the path driven so far, except where another number would be too close.
function drawAlong(pen, one, places) {
  const { x, y } = openRun(one.run),
    here = one.until - 1;
  for (const row of numberedRows(one.run, one.number)) {
    if (row > here) break;
    const place = [pen.px(x[row]), pen.py(y[row])];
    if (places.some(([left, top]) => Math.hypot(left - place[0], top - place[1]) < APART)) continue;
    places.push(place);
    drawNumber(pen, one.number, place[0], place[1] + 5);
  }
}

/**
 * Draws a number around a place in pixels; a robot's in its colour.
 * @param {Pen} pen
 * @param {number} number
 * @param {number} across
 * @param {number} down
 * @param {string} [colour]
 */
export function drawNumber(pen, number, across, down, colour = pen.colours[robotColour(number)]) {
  const { context, colours, unit } = pen,
    { size, casing } = MARKS.number;
  context.save();
  context.textAlign = "center";
  context.font = `700 ${size * unit}px system-ui, sans-serif`;
  context.lineWidth = casing * unit;
  context.strokeStyle = colours.floor;
  context.fillStyle = colour;
  context.strokeText(String(number), across, down);
  context.fillText(String(number), across, down);
  context.restore();
}
