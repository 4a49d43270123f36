// The legend of a picture: its marks, each with a sample and the words of `marks.json`.

import { BURNING, FREE, SOLID, openRun, openWorld } from "#player/decode.js";
import { el } from "#player/dom.js";
import { drawHead } from "#player/picture/arrows.js";
import { drawBody, drawTargetMark, drawTick } from "#player/picture/ends.js";
import { LEGEND, MARKS } from "#player/picture/marks.js";
import { hasMap } from "#player/picture/memory.js";
import { drivenIn, staysFrom } from "#player/picture/scene_robots.js";
import { drawBarredArrow, shortfallOf } from "#player/picture/shortfall.js";
import { isOnSpot } from "#player/picture/trail.js";
import { circle, disc, fillMark, palette, robotColour, stroke, strokeMark } from "#player/picture/pen.js";

export const SAMPLE = { width: 26, height: 14 }; // pixels

// Marks that each of several robots has in its own colour.
const OWN = new Set(["start", "began", "target", "waypoint", "witness", "approach", "loop", "trail", "end"]);

// Marks that the legend of a small picture explains.
const ABOUT = new Set(["witness", "cut", "cut-poses", "loop", "trail", "stay", "spot", "blocked", "barred", "short", "touched", "pierced", "caught", "named", "closes", "opens", "burns"]);

/** @typedef {{name: string, words: string, number?: number}} LegendItem */

/**
 * Returns the marks of a picture, in the order of a legend; of several robots first their numbers.
 * @param {Pick<Drawn, "world" | "run"> & Partial<Drawn>} drawn
 * @param {boolean} [isStill] - Whether the picture is of a whole run
 * @returns {LegendItem[]}
 */
export function marksOf({ world, run, others, number, named, sensors }, isStill = false) {
  const { events } = openWorld(world),
    happens = new Set(events?.state ?? []);
  const all = run ? [{ run, number: number ?? null }, ...(others ?? [])] : [];
  const loops = all.some((one) => one.run.loop),
    stays = isStill && all.some((one) => staysFrom(one.run) !== null),
    one = isStill && run !== null && all.length === 1 ? drivenIn({ world, run, step: run.steps, number: null, others: [], show: {}, whole: true })[0] : null,
    near = one && shortfallOf(world, one),
    cells = all.flatMap((other) => other.run.marks.filter(({ cell }) => cell)),
    isSpot = one !== null && isOnSpot(one);
  /** @type {Record<string, boolean | undefined>} */
  const present = {
    start: !isStill || run === null,
    began: isStill && run !== null,
    target: true,
    waypoint: Boolean(world.waypoints?.length),
    signal: Boolean(sensors?.signal) && !world.others?.length,
    witness: Boolean(openWorld(world).witness),
    cut: Boolean(world.cut),
    "cut-poses": Boolean(world.cut_poses),
    approach: loops || stays,
    loop: loops && !isSpot,
    stay: stays && !isSpot,
    spot: isSpot,
    trail: !stays && all.some((one) => !one.run.loop),
    ahead: run !== null && !isStill,
    end: run !== null && isStill && !near,
    nearest: near !== null,
    barred: Boolean(near?.contact),
    short: near !== null && !near.contact,
    touched: all.some((one) => openRun(one.run).bump.some(Boolean)),
    pierced: cells.some(({ kind }) => kind !== "caught"),
    caught: cells.some(({ kind }) => kind === "caught"),
    blocked: all.some((one) => one.run.blocked_by?.length),
    remembered: hasMap(run),
    fire: happens.has(BURNING),
    burnt: happens.has(BURNING),
    burns: happens.has(BURNING),
    closes: happens.has(SOLID),
    opens: happens.has(FREE),
    named: Boolean(named?.length),
  };
  const robots = all.length > 1 ? all.map((one) => ({ name: "trail", words: `robot ${one.number}`, number: one.number ?? undefined })) : [];
  return [...robots.sort((a, b) => (a.number ?? 0) - (b.number ?? 0)), ...LEGEND.filter((name) => present[name]).map((name) => ({ name, words: MARKS[name].label ?? "", number: all.length > 1 && OWN.has(name) ? 0 : undefined }))];
}

/**
 * Makes the legend, which can be closed.
 * @param {Drawn} drawn
 * @returns {HTMLElement}
 */
export function legendOf(drawn) {
  // The player begins with a still picture of the whole run.
  const all = [...marksOf(drawn), ...marksOf(drawn, true)],
    robots = all.filter(({ name, number }, k) => name === "trail" && number && all.findIndex((one) => one.number === number) === k);
  const marks = LEGEND.flatMap((name) => all.find((one) => one.name === name && !one.number) ?? []);
  return el("details", { class: "legend-part", open: true }, el("summary", {}, "Legend"), listOf([...robots, ...marks]));
}

/**
 * Makes the legend of a small picture: what it is about, next to words that say the rest.
 * @param {Pick<DrawnFailure, "world" | "run" | "named">} drawn
 * @returns {HTMLElement}
 */
export const legendOfCells = ({ world, ...drawn }) => listOf(world ? marksOf({ ...drawn, world, sensors: null }, true).filter(({ name }) => ABOUT.has(name)) : []);

/**
 * Makes the legend of many small pictures: every mark that is in one of them.
 * @param {Pick<DrawnFailure, "world" | "run" | "others" | "number">[]} pictures
 * @returns {HTMLElement}
 */
export function legendOfMany(pictures) {
  const marks = new Map(pictures.flatMap(({ world, ...drawn }) => (world ? marksOf({ ...drawn, world, sensors: null }, true) : [])).map((item) => [item.name, { name: item.name, words: MARKS[item.name].label ?? "" }]));
  return el("details", { class: "legend-part" }, el("summary", {}, "What the marks mean"), listOf(LEGEND.flatMap((name) => marks.get(name) ?? []).filter(({ name }) => MARKS[name].on_cards && name !== "named")));
}

/** @param {LegendItem[]} items */
function listOf(items) {
  const list = el("ul", { class: "legend" }, items.map(({ name, words, number }) => el("li", {}, el("canvas", { "aria-hidden": "true", "data-mark": name, "data-number": number }), words)));
  drawSamples(list);
  return list;
}

/**
 * Draws the samples of legends, again if the theme has changed.
 * @param {ParentNode} place
 */
export function drawSamples(place) {
  const ratio = window.devicePixelRatio || 1,
    colours = palette();
  for (const canvas of place.querySelectorAll("canvas")) {
    const { mark, number } = canvas.dataset;
    if (!mark) continue;
    Object.assign(canvas, { width: SAMPLE.width * ratio, height: SAMPLE.height * ratio });
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    drawSample(context, colours, mark, 0, 0, number ? Number(number) : null);
  }
}

/**
 * Draws a mark's sample into a box of the usual size.
 * @param {CanvasRenderingContext2D} context
 * @param {Record<string, string>} colours
 * @param {string} name
 * @param {number} left - pixels
 * @param {number} top
 * @param {number | null} number - Of a robot; 0 for any of several
 */
export function drawSample(context, colours, name, left, top, number) {
  const { width, height } = SAMPLE,
    [x, y] = [left + width / 2, top + height / 2],
    mark = MARKS[name],
    colour = colours[number === null ? mark.colour : number > 0 ? robotColour(number) : "quiet"];
  const same = (/** @type {number} */ value) => value;
  /** @type {Pen} */
  const pen = { context, colours, width, height, scale: 1, unit: 1, px: same, py: same, snap: same };
  const across = (from = left + 1, to = left + width - 1) => {
    context.beginPath();
    context.moveTo(from, y);
    context.lineTo(to, y);
  };
  const square = (inset = 0) => {
    context.beginPath();
    context.rect(x - 8 + inset, top + 1 + inset, 16 - 2 * inset, height - 2 - 2 * inset);
  };
  context.save();
  context.lineCap = "round";
  context.lineJoin = "round";
  /** @type {Record<string, () => void>} */
  const own = {
    start: () => drawBody(pen, "start", { x, y, heading: 0 }, undefined, 6, colour),
    target: () => drawTargetMark(pen, x, y, 3, colour),
    waypoint() {
      circle(pen, x, y, 5.5);
      fillMark(pen, name, colour);
      stroke(pen, colour, 2);
      context.font = "700 8px system-ui, sans-serif";
      context.textAlign = "center";
      context.fillStyle = colour;
      context.fillText("1", x, y + 3);
    },
    end: () => drawBody(pen, "end", { x, y, heading: 0 }, undefined, 6, colour),
    began: () => disc(pen, x, y, 4.5, colour),
    nearest: () => drawBody(pen, name, { x, y, heading: 0 }, undefined, 6, colour),
    barred: () => drawBarredArrow({ ...pen, unit: 0.6 }, [left + 1, y], [left + width - 4, y], [0, 1]),
    short() {
      across();
      for (const at of [left + 1, left + width - 1]) {
        context.moveTo(at, y - 4);
        context.lineTo(at, y + 4);
      }
      strokeMark(pen, name);
    },
    touched() {
      square();
      context.fillStyle = colours.wall;
      context.fill();
      context.beginPath();
      context.moveTo(x - 7, top + 3);
      context.lineTo(x + 7, top + 3);
      strokeMark(pen, name);
    },
    breach: () => crossed(pen, x, y, 4),
    named() {
      context.beginPath();
      for (const [dx, dy] of [[0, -4.5], [4.5, 0], [0, 4.5], [-4.5, 0]]) context.lineTo(x + dx, y + dy);
      context.closePath();
      strokeMark(pen, name);
    },
    spot() {
      circle(pen, x, y, 5);
      fillMark(pen, name);
      stroke(pen, colour, 2.4);
      disc(pen, x, y, 1.8, colour);
    },
    blocked() {
      across(left + 1, left + width - 7);
      strokeMark(pen, name);
      drawHead(pen, left + width - 7, y, 0, mark.size, colour);
    },
  };
  if (own[name]) own[name]();
  else if (mark.fill && mark.size) hatched(pen, name, square, left, top);
  else if (mark.fill || !mark.width) {
    square();
    fillMark(pen, name);
    stroke(pen, colour, 1);
  } else {
    across();
    if (mark.fade.length > 0) {
      context.globalAlpha = mark.fade[mark.fade.length - 1];
      stroke(pen, colour, mark.width);
      context.globalAlpha = 1;
    } else strokeMark(pen, name, colour);
    if (name === "loop" || name === "stay" || (name === "trail" && !(number && number > 0))) drawHead(pen, x, y, 0, mark.size, colour);
  }
  if (["start", "end", "nearest"].includes(name)) drawTick(pen, { x, y, heading: 0 }, 6, colour);
  context.restore();
}

// Draws stripes in a square.
function hatched(pen, name, square, left, top) {
  const { context } = pen,
    { colour, width } = MARKS[name];
  square();
  fillMark(pen, name);
  context.save();
  context.clip();
  context.beginPath();
  for (let at = -SAMPLE.height; at < SAMPLE.width + SAMPLE.height; at += 5) {
    context.moveTo(left + at, top + SAMPLE.height);
    context.lineTo(left + at + SAMPLE.height, top);
  }
  stroke(pen, pen.colours[colour], width);
  context.restore();
  square();
  stroke(pen, pen.colours[colour], 1);
}

function crossed(pen, x, y, reach) {
  pen.context.beginPath();
  for (const slant of [1, -1]) {
    pen.context.moveTo(x - reach, y - slant * reach);
    pen.context.lineTo(x + reach, y + slant * reach);
  }
  strokeMark(pen, "breach");
}
