// The path of a robot: it fades in up to the period, which is a closed line on the floor it covers.

import { openRun, rowAt } from "#player/decode.js";
import { drawHeads } from "#player/picture/arrows.js";
import { shownRadius } from "#player/picture/ends.js";
import { drawLine } from "#player/picture/long_line.js";
import { MARKS } from "#player/picture/marks.js";
import { circle, fillMark, innerRadius, line, stroke, strokeMark } from "#player/picture/pen.js";
import { colourOf } from "#player/picture/scene_robots.js";

const RECENT = 300; // rows of a long path, while it plays, that fade
const MOST_BAND = 3_000; // rows of a period, while it plays, of which the band is still drawn
const TANGLE = 4; // half outlines of its box that a period is longer than before it counts as tangled
const FULL = 0.5; // share of its box that a period may fill before it is drawn thinner
const THINNEST = 0.4; // share of its width
const SPOT = 3; // units: a smaller period is drawn as a spot

/**
 * Draws the path that is still to be driven.
 * @param {Pen} pen
 * @param {SceneRobot} one
 */
export function drawAhead(pen, { open, number }) {
  const { width, opacity } = MARKS.ahead;
  if (!number) drawLine(pen, open, "ahead", { from: 0, to: open.at.length, colour: pen.colours.ahead, width: width * pen.unit, alpha: opacity, once: false });
}

/**
 * Draws the path up to the period, or all of it: it fades in.
 * @param {Pen} pen
 * @param {SceneRobot} one
 * @param {boolean} isWhole - Whether this is a still picture of a whole run
 */
export function drawApproach(pen, one, isWhole) {
  const { open, entry, until, pose, number } = one,
    name = entry < open.at.length ? "approach" : "trail",
    { width, casing, fade } = MARKS[name],
    colour = colourOf(pen, name, number),
    last = Math.min(until, entry + 1),
    first = isWhole ? 0 : Math.max(0, last - RECENT),
    { context, unit } = pen;
  const part = (layer, colour, wide, alpha) => drawLine(pen, open, layer, { from: 0, to: last, colour, width: wide * unit, alpha, once: isWhole });
  if (casing) part("casing", pen.colours.floor, casing, 0.8);
  if (first > 0) drawLine(pen, open, "before", { from: 0, to: first + 1, colour, width: width * unit, alpha: fade[0], once: false });
  const bounds = isWhole ? evenly(open, last, fade.length) : fade.map((_, k) => first + Math.round(((last - first) * k) / fade.length));
  fade.forEach((share, k) => {
    const to = k + 1 < fade.length ? bounds[k + 1] + 1 : last;
    line(pen, open.x, open.y, Math.max(0, bounds[k]), Math.min(last, to), one.isDriving && k === fade.length - 1 && until <= entry ? pose : null);
    context.globalAlpha = share;
    stroke(pen, colour, width * unit);
    context.globalAlpha = 1;
  });
  if (name === "trail") drawHeads(pen, open, 0, last, name, colour);
}

// Returns the rows at which pieces of about equal length begin.
function evenly({ x, y }, to, count) {
  const lengths = [0];
  for (let row = 1; row < to; row += 1) lengths.push(lengths[row - 1] + Math.hypot(x[row] - x[row - 1], y[row] - y[row - 1]));
  const total = lengths[lengths.length - 1];
  return Array.from({ length: count }, (_, k) => Math.max(0, lengths.findIndex((length) => length >= (total * k) / count)));
}

/**
 * Draws the light band below what the robot repeats, which sets it off from the path into it.
 * @param {Pen} pen
 * @param {SceneRobot} one
 * @param {boolean} isWhole
 */
export function drawBand(pen, one, isWhole) {
  const { open, entry, until, number } = one;
  if (entry >= until - 1 || isSpot(pen, one) || (!isWhole && until - entry > MOST_BAND)) return;
  pen.context.globalAlpha = MARKS.band.fill;
  line(pen, open.x, open.y, entry, until);
  stroke(pen, colourOf(pen, "band", number), MARKS.band.width * pen.unit * shareOfWidth(pen, one));
  pen.context.globalAlpha = 1;
}

/**
 * Draws the period as a closed line with one arrow, or the path that reaches nothing new.
 * @param {Pen} pen
 * @param {SceneRobot} one
 * @param {boolean} isWhole
 */
export function drawLoop(pen, one, isWhole) {
  const { open, entry, until, pose, number } = one,
    name = one.run.loop ? "loop" : "stay",
    { width, casing } = MARKS[name],
    colour = colourOf(pen, name, number),
    unit = pen.unit * shareOfWidth(pen, one);
  if (entry >= until) return;
  if (isWhole && isSpot(pen, one)) {
    drawSpot(pen, open.x[entry], open.y[entry], innerRadius(one), colour);
    return;
  }
  for (const [layer, hue, wide, alpha] of [["loop-casing", pen.colours.floor, casing, 0.8], ["loop", colour, width, 1]])
    drawLine(pen, open, String(layer), { from: entry, to: until, colour: String(hue), width: Number(wide) * unit, alpha: Number(alpha), once: isWhole });
  if (one.isDriving) {
    line(pen, open.x, open.y, until - 1, until, pose);
    stroke(pen, colour, width * unit);
  }
  drawHeads(pen, open, entry, until, name, colour);
}

/**
 * Returns the share of its width with which a period is drawn that would fill its own box.
 * @param {Pen} pen
 * @param {SceneRobot} one
 * @returns {number}
 */
function shareOfWidth({ scale, unit }, { open, entry, run }) {
  if (!run.loop) return 1;
  const beyond = Math.min(open.at.length, rowAt(run, run.loop[0] + run.loop[1]) + 1),
    width = MARKS.loop.width * unit;
  let length = 0;
  for (let row = entry + 1; row < beyond; row += 1) length += Math.hypot(open.x[row] - open.x[row - 1], open.y[row] - open.y[row - 1]);
  const [wide, high] = [extent(open.x, entry, beyond), extent(open.y, entry, beyond)];
  if (length <= TANGLE * (wide + high)) return 1;
  const box = (wide * scale + width) * (high * scale + width);
  return Math.min(1, Math.max(THINNEST, (FULL * box) / (length * scale * width)));
}

/**
 * Returns whether a period is too small to see as a line.
 * @param {Pen} pen
 * @param {Pick<SceneRobot, "open" | "entry" | "run" | "radius" | "footprint">} one
 * @returns {boolean}
 */
function isSpot(pen, one) {
  return spreadOf(one) < Math.max((SPOT * pen.unit) / pen.scale, 0.1 * innerRadius(one));
}

/**
 * Returns whether a robot repeats itself on one spot, at any scale.
 * @param {SceneRobot} one
 * @returns {boolean}
 */
export const isOnSpot = (one) => one.entry < one.open.at.length && spreadOf(one) < 0.1 * innerRadius(one);

// Returns the longer side of the box around what a robot repeats, cells.
function spreadOf({ open, entry, run }) {
  const beyond = run.loop ? Math.min(open.at.length, rowAt(run, run.loop[0] + run.loop[1]) + 1) : open.at.length;
  return Math.max(extent(open.x, entry, beyond), extent(open.y, entry, beyond));
}

function extent(values, from, to) {
  let low = Infinity,
    high = -Infinity;
  for (let row = from; row < to; row += 1) {
    low = Math.min(low, values[row]);
    high = Math.max(high, values[row]);
  }
  return high - low;
}

// Draws a period on one spot as the robot's disc, without an arrow: it may be turning.
function drawSpot(pen, x, y, radius, colour) {
  const { context, px, py, unit } = pen;
  circle(pen, x, y, shownRadius(pen, "spot", radius));
  fillMark(pen, "spot", colour);
  strokeMark(pen, "spot", colour);
  context.beginPath();
  context.arc(px(x), py(y), 3 * unit, 0, 2 * Math.PI);
  context.fillStyle = colour;
  context.fill();
}

/**
 * Draws the path of the step that breaks the world's rules.
 * @param {Pen} pen
 * @param {RunScene} scene
 */
export function drawBreachPath(pen, { run, whole, step }) {
  const open = openRun(run);
  for (const mark of run.marks) {
    if (!mark.cell || (!whole && step < mark.step)) continue;
    line(pen, open.x, open.y, Math.max(0, rowAt(run, mark.step - 1)), rowAt(run, mark.step) + 1);
    stroke(pen, pen.colours[MARKS.breach.colour], MARKS.breach.width * pen.unit);
  }
}
