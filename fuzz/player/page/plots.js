// Plots of a run below its timeline; they can be zoomed, and dragging over them moves through time.

import { openRun, rowAt } from "#player/decode.js";
import { el, keyButton } from "#player/dom.js";
import { palette } from "#player/picture/pen.js";
import { seriesOf } from "#player/series.js";

const HIGH = 30; // pixels of one plot
const LEFT = 4; // pixels at both ends, so that the first and the last step can be hit
const NEAREST = 20; // minimum number of steps to show
const TALL = 820; // height in pixels of a window that shows the plots by default

/**
 * Makes the plots of a player.
 * @param {Player} player
 * @param {(step: number) => void} jump
 * @returns {{element: HTMLElement, draw: () => void, zoom: (factor: number) => void}}
 */
export function makePlots(player, jump) {
  const { run } = player.drawn;
  const view = { from: 0, to: Math.max(1, player.last) };
  const canvas = el("canvas", { class: "plots", role: "img", "aria-label": "Speed, distance to the target and clearance over time" });
  const readout = el("span", { class: "quiet", id: "plot-values" });
  const draw = () => {
    if (!run || !element.open || canvas.clientWidth === 0) return;
    follow(view, player);
    drawPlots(canvas, player, run, view);
    readout.textContent = valuesAt(player, run);
  };
  const zoom = (factor, at = player.step) => {
    zoomAt(view, player.last, factor, at);
    draw();
  };
  const whole = () => zoom(0);
  const buttons = el(
    "span",
    { class: "view", role: "group", "aria-label": "Plot zoom" },
    keyButton("−", "Show more of the run", "<", () => zoom(1 / 2)),
    keyButton("+", "Show less of the run", ">", () => zoom(2)),
    keyButton("Whole run", "Show the whole run", "|", whole),
  );
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
  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      zoom(event.deltaY < 0 ? 1.3 : 1 / 1.3, stepAt(event));
    },
    { passive: false },
  );
  const isOpen = typeof innerHeight === "number" && innerHeight >= TALL;
  const element = /** @type {HTMLDetailsElement} */ (
    el("details", { class: "plots-part", open: isOpen, ontoggle: draw }, el("summary", {}, "Plots: speed, distance, clearance"), canvas, el("div", { class: "line" }, readout, buttons))
  );
  new ResizeObserver(draw).observe(canvas);
  return { element, draw, zoom };
}

// Changes which steps are shown, with one of them in its place; a factor of 0 shows the whole run.
function zoomAt(view, last, factor, at) {
  const whole = Math.max(1, last);
  if (factor === 0) {
    Object.assign(view, { from: 0, to: whole });
    return;
  }
  const span = Math.min(whole, Math.max(Math.min(NEAREST, whole), (view.to - view.from) / factor));
  const share = (at - view.from) / (view.to - view.from);
  const from = Math.min(whole - span, Math.max(0, at - Math.min(1, Math.max(0, share)) * span));
  Object.assign(view, { from, to: from + span });
}

// Scrolls the plots to keep the current time in view.
function follow(view, { step, last }) {
  const span = view.to - view.from;
  if (step >= view.from && step <= view.to) return;
  const from = Math.min(Math.max(1, last) - span, Math.max(0, step - 0.1 * span));
  Object.assign(view, { from, to: from + span });
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
    scale = (HIGH - 8) / Math.max(most, 1e-9);
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
  context.lineWidth = 3;
  context.strokeStyle = colours.paper;
  context.strokeText(words, LEFT + 2, top + 11);
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
