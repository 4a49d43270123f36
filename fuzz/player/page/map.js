// Draws a world and a run on a canvas. Lengths are in cells; y grows upwards.

import { BURNING, SOLID, cellsAt, openRun, openWorld, poseAt, rowAt, stepWithin, touchedCells } from "./decode.js";
import { grouped, plural } from "./dom.js";
import { drawManyCells } from "./many_cells.js";
import { beamHeadings, castBeam } from "./rays.js";

const RIM = 0.4; // cells of the solid outside that are drawn around a world, if that is not too wide

export function palette() {
  const style = getComputedStyle(document.documentElement);
  return new Proxy({}, { get: (_, name) => style.getPropertyValue(`--${name}`).trim() });
}

export function fitView(world, width, height) {
  const edge = 2 * edgeOf(width);
  return {
    x: world.width / 2,
    y: world.height / 2,
    scale: Math.min((width - edge) / world.width, (height - edge) / world.height),
  };
}

// Pixels around a world that is shown whole.
export function edgeOf(width) {
  return width < 400 ? 9 : 16;
}

export function rimOf(pen) {
  return Math.min(edgeOf(pen.width) - 3, Math.max(2, Math.round(RIM * pen.scale)));
}

// Sets the canvas to its place on the page and returns a pen that speaks in cells.
export function penFor(canvas, view, world) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth,
    height = canvas.clientHeight;
  const wide = Math.round(width * ratio),
    high = Math.round(height * ratio);
  if (canvas.width !== wide || canvas.height !== high) {
    canvas.width = wide;
    canvas.height = high;
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.lineJoin = "round";
  context.lineCap = "round";
  const { x, y, scale } = view || fitView(world, width, height);
  return {
    context,
    width,
    height,
    scale,
    px: (value) => width / 2 + (value - x) * scale,
    py: (value) => height / 2 - (value - y) * scale,
    colours: palette(),
  };
}

/* What is drawn:
     world, run      as the page's data has them; run may be missing
     step            time, in steps
     show            { trail, witness, sensors, signal, touched }: which of them
     sensors         the robot's, or null
     colour          of this robot, where there are several: the name of one in the palette
     others          the others: { run, colour }
     whole           the whole way is drawn as driven, as in small pictures */
export function drawScene(canvas, scene, view = null) {
  const { world, run } = scene;
  const pen = penFor(canvas, view, world);
  if (pen.width === 0) return;
  const ms = run ? scene.step * run.dt * 1000 : 0;
  const cells = cellsAt(world, ms);
  drawGround(pen, world, cells, scene);
  if (scene.show.witness) drawProof(pen, world, ms);
  drawTarget(pen, world);
  const pose = run && poseAt(run, stepWithin(run, scene.step));
  if (run && scene.show.sensors && scene.sensors) drawSenses(pen, scene, cells, pose);
  for (const other of scene.others || []) drawOther(pen, scene, other);
  if (run) disc(pen, pose.x, pose.y, bodyRadius(pen, world), pen.colours["robot-fill"]);
  if (run && scene.show.trail) drawTrail(pen, scene);
  if (run && scene.show.touched) drawTouched(pen, scene);
  drawStart(pen, world);
  if (!run) return;
  drawBreaches(pen, scene);
  drawRobot(pen, world, pose, scene);
}

export function drawGround(pen, world, cells, scene) {
  const { context, px, py, colours } = pen;
  context.fillStyle = colours.panel;
  context.fillRect(0, 0, pen.width, pen.height);
  const rim = rimOf(pen);
  const left = Math.round(px(0)),
    right = Math.round(px(world.width));
  const top = Math.round(py(world.height)),
    bottom = Math.round(py(0));
  context.fillStyle = colours.wall;
  context.fillRect(left - rim, top - rim, right - left + 2 * rim, bottom - top + 2 * rim);
  context.fillStyle = colours.floor;
  context.fillRect(left, top, right - left, bottom - top);
  if (scene.show.signal && scene.sensors && scene.sensors.signal) drawSignal(pen, world, [left, top, right, bottom]);
  if (pen.scale > 9 && scene.show.grid !== false) drawGrid(pen, world);
  if (drawManyCells(pen, world, cells)) return;
  drawCells(pen, world, cells, SOLID, colours.wall);
  context.globalAlpha = 0.6; // so that ways stand out from flames
  drawCells(pen, world, cells, BURNING, colours.fire);
  context.globalAlpha = 1;
}

// Strength 1 / (1 + squared distance), which the robot senses.
function drawSignal(pen, world, [left, top, right, bottom]) {
  const { context, px, py, colours } = pen;
  const [x, y] = world.target;
  const reach = 6 * pen.scale;
  const glow = context.createRadialGradient(px(x), py(y), 0, px(x), py(y), reach);
  for (let k = 0; k <= 6; k += 1) {
    const strength = 1 / (1 + k * k) - 1 / 37; // nothing at the edge
    glow.addColorStop(k / 6, `rgb(${colours.signal} / ${(0.4 * strength).toFixed(3)})`);
  }
  context.save();
  context.beginPath();
  context.rect(left, top, right - left, bottom - top);
  context.clip();
  context.fillStyle = glow;
  context.fillRect(px(x) - reach, py(y) - reach, 2 * reach, 2 * reach);
  context.restore();
}

export function drawGrid(pen, world) {
  const { context, px, py, colours } = pen;
  context.save();
  context.lineCap = "butt";
  context.beginPath();
  const [left, right] = [0, world.width].map((x) => Math.round(px(x)));
  const [bottom, top] = [0, world.height].map((y) => Math.round(py(y)));
  for (let ix = 1; ix < world.width; ix += 1) {
    context.moveTo(Math.round(px(ix)) + 0.5, bottom);
    context.lineTo(Math.round(px(ix)) + 0.5, top);
  }
  for (let iy = 1; iy < world.height; iy += 1) {
    context.moveTo(left, Math.round(py(iy)) + 0.5);
    context.lineTo(right, Math.round(py(iy)) + 0.5);
  }
  context.strokeStyle = colours.grid;
  context.lineWidth = 1;
  context.stroke();
  context.restore();
}

// Row by row, neighbours in one rectangle; only what lies in the window.
export function drawCells(pen, world, cells, state, colour) {
  const { context, px, py } = pen;
  const first = Math.max(0, Math.floor((0 - px(0)) / pen.scale)),
    beyond = Math.min(world.width, Math.ceil((pen.width - px(0)) / pen.scale));
  const low = Math.max(0, Math.floor((py(0) - pen.height) / pen.scale)),
    high = Math.min(world.height, Math.ceil(py(0) / pen.scale));
  context.fillStyle = colour;
  for (let iy = low; iy < high; iy += 1) {
    const top = Math.round(py(iy + 1)),
      deep = Math.round(py(iy)) - top;
    for (let ix = first; ix < beyond; ix += 1) {
      if (cells[iy * world.width + ix] !== state) continue;
      const from = ix;
      while (ix + 1 < beyond && cells[iy * world.width + ix + 1] === state) ix += 1;
      const left = Math.round(px(from));
      context.fillRect(left, top, Math.max(1, Math.round(px(ix + 1)) - left), Math.max(1, deep));
    }
  }
}

export function drawProof(pen, world, ms) {
  const { context, px, py, colours } = pen;
  const witness = openWorld(world).witness;
  context.save();
  if (witness) {
    line(pen, witness.x, witness.y, 0, witness.x.length);
    stroke(pen, colours.start, 2, [6, 4]);
    const next = witness.ms.findIndex((time) => time > ms),
      last = witness.ms.length - 1;
    const k = next < 0 ? last : Math.max(0, next - 1),
      gap = witness.ms[Math.min(k + 1, last)] - witness.ms[k];
    const share = gap > 0 ? Math.min(1, (ms - witness.ms[k]) / gap) : 0;
    const along = (column) => column[k] + (column[Math.min(k + 1, last)] - column[k]) * share;
    disc(pen, along(witness.x), along(witness.y), Math.max(3.5 / pen.scale, 0.08), colours.start);
  }
  if (world.cut) {
    context.beginPath();
    for (const [ix, iy] of [...world.cut, world.cut[0]]) context.lineTo(px(ix + 0.5), py(iy + 0.5));
    stroke(pen, colours.breach, 2, [6, 4]);
  }
  context.restore();
}

export function drawTarget(pen, world) {
  const [x, y, radius] = world.target;
  const shown = Math.max(radius, 4 / pen.scale);
  disc(pen, x, y, shown, pen.colours.target);
  ring(pen, x, y, shown + 2.5 / pen.scale, pen.colours.target, 1.5);
}

export function drawStart(pen, world) {
  const { context, px, py, colours } = pen;
  const [x, y, heading] = world.start;
  const shown = Math.max(world.radius * 0.35, 4 / pen.scale);
  ring(pen, x, y, shown, colours.start, 2);
  context.beginPath();
  context.moveTo(px(x), py(y));
  context.lineTo(px(x + Math.cos(heading) * shown * 1.8), py(y + Math.sin(heading) * shown * 1.8));
  stroke(pen, colours.start, 2);
}

// Another robot at the same time: its way so far, and its disc.
function drawOther(pen, scene, { run, colour }) {
  const open = openRun(run),
    step = (scene.step * scene.run.dt) / run.dt;
  const pose = poseAt(run, stepWithin(run, step)),
    strong = pen.colours[colour],
    radius = bodyRadius(pen, scene.world);
  if (scene.show.trail) {
    line(pen, open.x, open.y, 0, rowAt(run, Math.min(step, run.steps)) + 1, step <= run.steps ? pose : null);
    stroke(pen, strong, 2);
  }
  ring(pen, pose.x, pose.y, radius, strong, 2);
  pen.context.beginPath();
  pen.context.moveTo(pen.px(pose.x), pen.py(pose.y));
  const { x, y, heading } = pose;
  pen.context.lineTo(pen.px(x + Math.cos(heading) * radius), pen.py(y + Math.sin(heading) * radius));
  stroke(pen, strong, 2);
}

const RECENT = 300; // rows of a long way that are drawn strongest

// Ahead faint, driven strong; the period of a loop in its own colour, or stronger in the robot's.
function drawTrail(pen, scene) {
  const { run } = scene,
    open = openRun(run),
    { colours, context } = pen;
  const here = rowAt(run, scene.step),
    rows = open.at.length;
  const entry = run.loop ? rowAt(run, run.loop[0]) : rows;
  if (!scene.whole) {
    line(pen, open.x, open.y, 0, rows);
    stroke(pen, colours.ahead, 1.25);
  }
  const end = scene.whole ? rows : here + 1,
    pose = scene.whole || scene.step > run.steps ? null : poseAt(run, scene.step);
  const own = scene.colour ? colours[scene.colour] : colours.loop;
  const before = run.loop && !scene.colour ? colours.way : own,
    last = Math.min(end, entry + 1);
  const recent = Math.max(0, last - RECENT);
  context.globalAlpha = 0.4;
  line(pen, open.x, open.y, 0, recent + 1);
  stroke(pen, before, 1.75);
  context.globalAlpha = run.loop && scene.colour ? 0.5 : 1;
  line(pen, open.x, open.y, recent, last, end <= entry ? pose : null);
  stroke(pen, before, 2.25);
  context.globalAlpha = 1;
  if (end > entry) {
    line(pen, open.x, open.y, entry, end, pose);
    stroke(pen, own, scene.colour ? 3.5 : 2.75);
  }
  drawBreachPath(pen, run, scene);
}

// The way of the step that breaks the world's rules.
function drawBreachPath(pen, run, scene) {
  const open = openRun(run);
  for (const mark of run.marks) {
    if (!mark.cell || (!scene.whole && scene.step < mark.step)) continue;
    line(pen, open.x, open.y, Math.max(0, rowAt(run, mark.step - 1)), rowAt(run, mark.step) + 1);
    stroke(pen, pen.colours.breach, 4);
  }
}

function drawBreaches(pen, scene) {
  const { context, px, py, colours } = pen;
  for (const mark of scene.run.marks) {
    if (!mark.cell) continue;
    const [ix, iy] = mark.cell,
      over = scene.whole || scene.step >= mark.step;
    context.save();
    context.strokeStyle = colours.breach;
    context.lineWidth = over ? 3 : 1.5;
    context.setLineDash(over ? [] : [4, 3]);
    context.strokeRect(px(ix), py(iy + 1), pen.scale, pen.scale);
    context.restore();
  }
}

function drawTouched(pen, scene) {
  const { context, px, py, colours } = pen,
    { world } = scene;
  const rim = rimOf(pen),
    inset = Math.min(2, pen.scale / 4);
  context.save();
  context.beginPath();
  context.rect(
    px(0) - rim,
    py(world.height) - rim,
    world.width * pen.scale + 2 * rim,
    world.height * pen.scale + 2 * rim,
  );
  context.clip();
  context.strokeStyle = colours.touched;
  context.lineWidth = 2;
  for (const { ix, iy, step } of touchedCells(world, scene.run).values()) {
    if (!scene.whole && step > scene.step) continue;
    context.strokeRect(px(ix) + inset, py(iy + 1) + inset, pen.scale - 2 * inset, pen.scale - 2 * inset);
  }
  context.restore();
}

function drawSenses(pen, scene, cells, pose) {
  const { context, px, py, colours } = pen,
    { world, sensors } = scene;
  if (sensors.beams > 0) {
    context.beginPath();
    for (const heading of beamHeadings(pose.heading, sensors)) {
      const [x, y] = castBeam(cells, world, pose.x, pose.y, heading, sensors.range);
      context.moveTo(px(pose.x), py(pose.y));
      context.lineTo(px(x), py(y));
    }
    stroke(pen, colours.beam, 1);
  }
  const bearing = Math.atan2(world.target[1] - pose.y, world.target[0] - pose.x);
  const from = Math.max(world.radius, 5 / pen.scale) + 3 / pen.scale,
    to = from + 9 / pen.scale;
  context.beginPath();
  context.moveTo(px(pose.x + Math.cos(bearing) * from), py(pose.y + Math.sin(bearing) * from));
  context.lineTo(px(pose.x + Math.cos(bearing) * to), py(pose.y + Math.sin(bearing) * to));
  stroke(pen, colours.target, 3);
}

function bodyRadius(pen, world) {
  return Math.max(world.radius, 3 / pen.scale);
}

function drawRobot(pen, world, pose, scene) {
  const { context, px, py, colours } = pen;
  const radius = bodyRadius(pen, world);
  ring(
    pen,
    pose.x,
    pose.y,
    radius,
    pose.bump && !scene.whole ? colours.touched : colours.robot,
    pose.bump ? 2.5 : 1.75,
  );
  context.beginPath();
  context.moveTo(px(pose.x), py(pose.y));
  context.lineTo(px(pose.x + Math.cos(pose.heading) * radius), py(pose.y + Math.sin(pose.heading) * radius));
  stroke(pen, colours.robot, 2);
}

const LEAST = 0.75; // pixels: corners that are nearer to the one before are left out

export function line(pen, x, y, from, to, last = null) {
  const { context, px, py } = pen;
  let left = NaN,
    top = NaN;
  context.beginPath();
  for (let row = from; row < to; row += 1) {
    const across = px(x[row]),
      down = py(y[row]);
    if (Math.abs(across - left) < LEAST && Math.abs(down - top) < LEAST && row < to - 1) continue;
    context.lineTo(across, down);
    left = across;
    top = down;
  }
  if (last) context.lineTo(px(last.x), py(last.y));
}

export function stroke(pen, colour, width, dash = []) {
  const { context } = pen;
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.setLineDash(dash);
  context.stroke();
  context.setLineDash([]);
}

export function disc(pen, x, y, radius, colour) {
  pen.context.beginPath();
  pen.context.arc(pen.px(x), pen.py(y), radius * pen.scale, 0, 2 * Math.PI);
  pen.context.fillStyle = colour;
  pen.context.fill();
}

export function ring(pen, x, y, radius, colour, width) {
  pen.context.beginPath();
  pen.context.arc(pen.px(x), pen.py(y), radius * pen.scale, 0, 2 * Math.PI);
  stroke(pen, colour, width);
}

// A small picture: the whole way at once, the robot where the run ends.
export function drawSmall(canvas, drawn) {
  const { world, run, sensors } = drawn;
  if (!world) return;
  const show = { trail: true, signal: true, touched: false, sensors: false, witness: false };
  drawScene(canvas, { world, run, sensors, show, whole: true, step: run ? run.steps : 0 });
}

export function pictureLabel(drawn) {
  const changes = drawn.events ? `, ${plural(drawn.events, "change")} of cells` : "";
  const run = drawn.run ? `, the robot's way of ${plural(drawn.run.steps, "step")}` : "";
  return `World of ${drawn.size} cells, ${grouped(drawn.solid)} solid${changes}${run}`;
}
