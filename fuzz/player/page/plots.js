// Plots of a run below its timeline; dragging over them moves through time.

import { openRun, rowAt } from "#player/decode.js";
import { el, ticks } from "#player/dom.js";
import { palette, robotColour } from "#player/picture/pen.js";
import { seriesOf } from "#player/series.js";
import { onWheel } from "#player/timeline.js";

const HIGH = 62; // pixels of one plot
const NAME = 16; // pixels of these for its name, above the curve
const AXIS = 16; // pixels of the axis of time, below all plots
const LEFT = 4; // pixels at both ends, so that the first and the last step can be hit
const LABEL = 70; // pixels that a label of the time takes
const TALL = 820; // height in pixels of a window that shows the plots by default

/**
 * Makes the plots of a player.
 * @param {Player} player
 * @param {Timeline} timeline - Its view is the plots' too
 * @param {(step: number) => void} jump
 * @returns {{element: HTMLElement, draw: () => void}}
 */
export function makePlots(player, { view, zoom }, jump) {
  const { run } = player.drawn;
  /** @type {number | null} */
  let pointed = null; // step under the pointer
  const canvas = el("canvas", { class: "plots", role: "img", "aria-label": "Speed, distance to the target and clearance over time" });
  const readout = el("p", { class: "quiet plot-values", id: "plot-values" });
  const draw = () => {
    if (!run || !element.open || canvas.clientWidth === 0) return;
    const curves = curvesOf(player);
    const step = pointed ?? player.step;
    drawPlots(canvas, player, run, curves, view, pointed);
    readout.replaceChildren(...valuesAt(curves, run, step, pointed !== null));
  };
  const stepAt = (event) => {
    const box = canvas.getBoundingClientRect();
    const share = (event.clientX - box.left - LEFT) / Math.max(1, box.width - 2 * LEFT);
    return view.from + Math.min(1, Math.max(0, share)) * (view.to - view.from);
  };
  const point = (step) => {
    pointed = step;
    draw();
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    jump(Math.round(stepAt(event)));
  });
  canvas.addEventListener("pointermove", (event) => {
    pointed = stepAt(event);
    if (event.buttons & 1) jump(Math.round(pointed));
    else draw();
  });
  canvas.addEventListener("pointerleave", () => point(null));
  onWheel(canvas, zoom, (share) => view.from + share * (view.to - view.from));
  const isOpen = typeof innerHeight === "number" && innerHeight >= TALL;
  const element = /** @type {HTMLDetailsElement} */ (
    el("details", { class: "plots-part", open: isOpen, ontoggle: draw }, el("summary", {}, "Plots: speed, distance, clearance"), canvas, readout)
  );
  canvas.style.height = `${3 * HIGH + AXIS}px`;
  new ResizeObserver(draw).observe(canvas);
  return { element, draw };
}

/**
 * Returns what is plotted of each robot, the one in front last, so that it is drawn on top.
 * @param {Player} player
 * @returns {Curves[]}
 */
function curvesOf({ drawn: { world, run, others, number } }) {
  const several = (others ?? []).length > 0;
  const own = run ? [{ run, number: number ?? 1, colour: several ? robotColour(number ?? 1) : "link", front: true }] : [];
  const rest = (others ?? []).map((other) => ({ ...other, colour: robotColour(other.number), front: false }));
  return [...rest, ...own].map((one) => ({ ...one, named: several, series: seriesOf(world, one.run, one.front ? world : world.others?.[one.number - 2] ?? world) }));
}

// Describes the values at a step of the run in front, of each robot at the same time.
function valuesAt(curves, run, step, isPointed) {
  const time = `${isPointed ? "pointer at" : "at"} ${(step * run.dt).toFixed(2)} s: `;
  const rows = [...curves].sort((a, b) => a.number - b.number).map(({ run: own, number, named, series }) => {
    const row = rowAt(own, Math.min((step * run.dt) / own.dt, own.steps));
    const words = series.map(({ name, unit, values, capped, most }) => `${name.toLowerCase()} ${capped && values[row] >= most - 1e-9 ? "at least " : ""}${(Math.round(values[row] * 100) / 100 + 0).toFixed(2)} ${unit}`);
    return el("span", {}, named ? el("b", {}, `robot ${number} `) : "", words.join(" · "));
  });
  return [el("span", {}, time), ...rows];
}

function drawPlots(canvas, player, run, curves, view, pointed) {
  const ratio = window.devicePixelRatio || 1,
    width = canvas.clientWidth,
    plots = curves[0].series.length,
    height = HIGH * plots;
  [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round((height + AXIS) * ratio)];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d")),
    colours = palette();
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.font = "11px system-ui, sans-serif";
  const across = (step) => LEFT + ((step - view.from) / (view.to - view.from)) * (width - 2 * LEFT);
  // From the lowest layer to the highest: the period, each plot with its axis and name, marks,
  // the current time.
  if (run.loop) {
    context.globalAlpha = 0.15;
    context.fillStyle = colours.loop;
    context.fillRect(across(run.loop[0]), 0, across(run.loop[0] + run.loop[1]) - across(run.loop[0]), height);
    context.globalAlpha = 1;
  }
  for (let k = 0; k < plots; k += 1) drawPlot(context, colours, curves, k, run, { view, across, top: k * HIGH, width });
  drawTimes(context, colours, run, { view, across, top: height, width });
  for (const { step, kind } of run.marks) rule(context, across(step), height, ["last", "stays"].includes(kind) ? colours.target : kind === "entry" ? colours.loop : colours.breach, [4, 3]);
  rule(context, across(player.step), height, colours.ink, []);
  if (pointed !== null) rule(context, across(pointed), height, colours.quiet, [2, 2]);
}

function drawPlot(context, colours, curves, k, run, frame) {
  const { top, width } = frame;
  const least = Math.min(...curves.map(({ series }) => series[k].least)),
    most = Math.max(...curves.map(({ series }) => series[k].most), least + 1e-9),
    { name, unit } = curves[0].series[k];
  const scale = (HIGH - NAME - 4) / (most - least);
  const down = (value) => top + HIGH - 3 - (value - least) * scale;
  // What is below 0 is inside a wall.
  if (least < 0) {
    context.globalAlpha = 0.12;
    context.fillStyle = colours.breach;
    context.fillRect(0, down(0), width, down(least) - down(0));
    context.globalAlpha = 1;
  }
  const values = [...(least < -(most - least) / 4 ? [least] : []), ...ticks(most, 2)];
  for (const value of values) level(context, down(value), width, colours.rule);
  context.lineJoin = "round";
  for (const { run: own, colour, front, series } of curves) {
    const pace = own.dt / run.dt; // steps of the run in front in one of this run's
    drawCurve(context, own, series[k].values, { ...frame, pace, down });
    context.strokeStyle = colours[colour];
    context.lineWidth = front ? 1.5 : 1;
    context.stroke();
  }
  // The words are above the curves.
  for (const value of values) write(context, colours, Number(value.toPrecision(3)).toString(), LEFT + 2, down(value) - 2);
  write(context, colours, `${name}, ${unit}`, LEFT + 34, top + 11, colours.ink);
}

// Traces a curve. Each column of pixels shows its least and greatest value, so that no peak is lost.
function drawCurve(context, run, values, { view, across, pace, down }) {
  const { at } = openRun(run);
  context.beginPath();
  const first = Math.max(0, rowAt(run, view.from / pace) - 1),
    last = Math.min(values.length - 1, rowAt(run, Math.min(run.steps, view.to / pace)) + 1);
  let column = NaN,
    least = 0,
    greatest = 0;
  for (let row = first; row <= last; row += 1) {
    const here = Math.round(across(at[row] * pace)),
      value = values[row];
    if (here === column) {
      least = Math.min(least, value);
      greatest = Math.max(greatest, value);
      if (row < last) continue;
    }
    if (Number.isFinite(column)) {
      context.lineTo(column, down(greatest));
      context.lineTo(column, down(least));
    }
    column = here;
    least = greatest = value;
  }
  if (Number.isFinite(column)) context.lineTo(column, down(greatest));
}

// Draws the axis of time below the plots.
function drawTimes(context, colours, run, { view, across, top, width }) {
  const [from, to] = [view.from * run.dt, view.to * run.dt];
  const every = ticks(to - from, Math.max(1, Math.floor(width / LABEL)))[1] ?? to - from;
  context.textAlign = "center";
  for (let k = Math.ceil(from / every - 1e-9); k * every <= to + 1e-9; k += 1) {
    const x = across((k * every) / run.dt);
    context.fillStyle = colours.rule;
    context.fillRect(x, top - 1, 1, 5);
    write(context, colours, `${Number((k * every).toPrecision(6))} s`, Math.min(width - 18, Math.max(14, x)), top + 14);
  }
  context.textAlign = "start";
}

// Writes text on a background of the page's colour, so that it can be read above curves.
function write(context, colours, words, x, y, colour = colours.quiet) {
  context.strokeStyle = colours.paper;
  context.lineWidth = 3;
  context.strokeText(words, x, y);
  context.fillStyle = colour;
  context.fillText(words, x, y);
}

function level(context, y, width, colour) {
  context.fillStyle = colour;
  context.fillRect(0, Math.round(y), width, 1);
}

function rule(context, x, height, colour, dash) {
  context.strokeStyle = colour;
  context.lineWidth = 1.5;
  context.setLineDash(dash);
  context.beginPath();
  context.moveTo(x, 0);
  context.lineTo(x, height);
  context.stroke();
  context.setLineDash([]);
}
