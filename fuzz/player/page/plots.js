// Plots of a run below its timeline; dragging over them moves through time.

import { openRun, rowAt } from "#player/decode.js";
import { el } from "#player/dom.js";
import { palette } from "#player/picture/pen.js";
import { seriesOf } from "#player/series.js";
import { onWheel } from "#player/timeline.js";

const HIGH = 37; // pixels of one plot
const NAME = 14; // pixels of these for its name, above the curve
const LEFT = 4; // pixels at both ends, so that the first and the last step can be hit
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
  const canvas = el("canvas", { class: "plots", role: "img", "aria-label": "Speed, distance to the target and clearance over time" });
  const readout = el("span", { class: "quiet", id: "plot-values" });
  const draw = () => {
    if (!run || !element.open || canvas.clientWidth === 0) return;
    drawPlots(canvas, player, run, view);
    readout.textContent = valuesAt(player, run);
  };
  const stepAt = (event) => {
    const box = canvas.getBoundingClientRect();
    const share = (event.clientX - box.left - LEFT) / Math.max(1, box.width - 2 * LEFT);
    return view.from + Math.min(1, Math.max(0, share)) * (view.to - view.from);
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    jump(Math.round(stepAt(event)));
  });
  canvas.addEventListener("pointermove", (event) => event.buttons & 1 && jump(Math.round(stepAt(event))));
  onWheel(canvas, zoom, (share) => view.from + share * (view.to - view.from));
  const isOpen = typeof innerHeight === "number" && innerHeight >= TALL;
  const element = /** @type {HTMLDetailsElement} */ (
    el("details", { class: "plots-part", open: isOpen, ontoggle: draw }, el("summary", {}, "Plots: speed, distance, clearance"), canvas, readout)
  );
  new ResizeObserver(draw).observe(canvas);
  return { element, draw };
}

function valuesAt(player, run) {
  const row = rowAt(run, Math.min(player.step, run.steps));
  return seriesOf(player.drawn.world, run)
    .map(({ name, unit, values, capped, most }) => `${name.toLowerCase()} ${capped && values[row] >= most - 1e-9 ? "at least " : ""}${values[row].toFixed(2)} ${unit}`)
    .join(" · ");
}

function drawPlots(canvas, player, run, view) {
  const series = seriesOf(player.drawn.world, run),
    ratio = window.devicePixelRatio || 1,
    width = canvas.clientWidth,
    height = HIGH * series.length;
  canvas.style.height = `${height}px`;
  [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d")),
    colours = palette();
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  const across = (step) => LEFT + ((step - view.from) / (view.to - view.from)) * (width - 2 * LEFT);
  // From the lowest layer to the highest: the period, each plot with its name, marks,
  // the current time.
  if (run.loop) {
    context.globalAlpha = 0.15;
    context.fillStyle = colours.loop;
    context.fillRect(across(run.loop[0]), 0, across(run.loop[0] + run.loop[1]) - across(run.loop[0]), height);
    context.globalAlpha = 1;
  }
  series.forEach((one, k) => drawPlot(context, colours, one, run, { view, across, top: k * HIGH, width }));
  for (const { step, kind } of run.marks) rule(context, across(step), height, kind === "last" ? colours.target : kind === "entry" ? colours.loop : colours.breach, [4, 3]);
  rule(context, across(player.step), height, colours.ink, []);
}

function drawPlot(context, colours, { name, unit, values, most }, run, { view, across, top, width }) {
  const { at } = openRun(run);
  const low = top + HIGH - 3,
    scale = (HIGH - NAME - 4) / Math.max(most, 1e-9);
  context.strokeStyle = colours.rule;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(0, top + HIGH - 0.5);
  context.lineTo(width, top + HIGH - 0.5);
  context.stroke();
  context.strokeStyle = colours.link;
  context.lineWidth = 1.25;
  context.beginPath();
  // Each column of pixels shows its least and greatest value, so that no peak is lost.
  const first = Math.max(0, rowAt(run, view.from) - 1),
    last = Math.min(values.length - 1, rowAt(run, view.to) + 1);
  let column = NaN,
    least = 0,
    greatest = 0;
  for (let row = first; row <= last; row += 1) {
    const here = Math.round(across(at[row])),
      value = Math.max(0, values[row]);
    if (here === column) {
      least = Math.min(least, value);
      greatest = Math.max(greatest, value);
      if (row < last) continue;
    }
    if (Number.isFinite(column)) {
      context.lineTo(column, low - greatest * scale);
      context.lineTo(column, low - least * scale);
    }
    column = here;
    least = greatest = value;
  }
  if (Number.isFinite(column)) context.lineTo(column, low - greatest * scale);
  context.stroke();
  const words = `${name}, up to ${most.toFixed(2)} ${unit}`;
  context.font = "11px system-ui, sans-serif";
  context.fillStyle = colours.quiet;
  context.fillText(words, LEFT + 2, top + 11);
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
