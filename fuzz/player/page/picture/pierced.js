// Walls that a robot enters: which cells, when, and where. They are red, striped and crossed out,
// so that colour is not the only sign. A cell that catches the robot has no stripes.

import { SOLID, cellsAt, openRun, poseAt, stateAt } from "#player/decode.js";
import { MARKS } from "#player/picture/marks.js";
import { innerRadius, stroke, strokeMark } from "#player/picture/pen.js";

const FURTHEST = 6; // cells: for a larger robot, only the cells that its centre enters are found
const LIGHTER = 0.6; // share of the floor's colour in a wall that the robot entered, below the stripes
const FINENESS = 0.125; // cells between two places of a path that are examined

/* Returns the wall cells that the robot cuts into, each with the first step in which it does. The
   cell that the verdict names is always among them. */
function piercedCells(world, run) {
  const open = openRun(run);
  if (open.pierced) return open.pierced;
  /** @type {NonNullable<OpenRun["pierced"]>} */
  const pierced = new Map();
  open.pierced = pierced;
  const note = (ix, iy, step, named = false, isEntered = true) => {
    const key = `${ix},${iy}`,
      known = pierced.get(key);
    if (!known) pierced.set(key, { ix, iy, step, named, isEntered });
    else if (named) Object.assign(known, { named, step });
  };
  if (run.tolerance !== null) {
    for (let row = 0; row < open.at.length; row += 1) {
      const cells = cellsAt(world, open.at[row] * run.dt * 1000);
      for (const [ix, iy] of cutAt(cells, world, run.tolerance, open.x[row], open.y[row])) note(ix, iy, open.at[row]);
      if (row > 0 && open.at[row] - open.at[row - 1] <= 1)
        for (const [ix, iy] of crossed(cells, world, open, row)) note(ix, iy, open.at[row]);
    }
  }
  for (const mark of run.marks) if (mark.cell) note(...mark.cell, mark.step, true, mark.kind !== "caught");
  return pierced;
}

// Returns the walls that the disc cuts into by more than the tolerance, in cells.
function cutAt(cells, world, tolerance, x, y) {
  const radius = innerRadius(world),
    reach = radius > FURTHEST ? 0 : Math.ceil(radius),
    most = Math.max(0, radius - tolerance),
    found = [];
  for (let iy = Math.floor(y) - reach; iy <= Math.floor(y) + reach; iy += 1) {
    for (let ix = Math.floor(x) - reach; ix <= Math.floor(x) + reach; ix += 1) {
      if (stateAt(cells, world, ix, iy) !== SOLID) continue;
      const dx = Math.max(ix - x, 0, x - ix - 1),
        dy = Math.max(iy - y, 0, y - iy - 1);
      if (dx * dx + dy * dy < most * most) found.push([ix, iy]);
    }
  }
  return found;
}

// Returns the walls that the centre passes between a row and the previous one.
function crossed(cells, world, open, row) {
  const dx = open.x[row] - open.x[row - 1],
    dy = open.y[row] - open.y[row - 1];
  const places = Math.ceil(Math.hypot(dx, dy) / FINENESS),
    found = [];
  for (let k = 1; k < places; k += 1) {
    const ix = Math.floor(open.x[row - 1] + (dx * k) / places),
      iy = Math.floor(open.y[row - 1] + (dy * k) / places);
    if (stateAt(cells, world, ix, iy) === SOLID) found.push([ix, iy]);
  }
  return found;
}

// Returns where the robot breaks into the cell that the verdict names: the first place of its
// centre in the cell, or the nearest to it.
function breachPoint(run, mark) {
  const [ix, iy] = mark.cell,
    before = poseAt(run, Math.max(0, mark.step - 1)),
    after = poseAt(run, mark.step);
  const within = (value, low) => Math.min(low + 1, Math.max(low, value));
  let least = Infinity,
    point = [ix, iy];
  for (let k = 0; k <= 64; k += 1) {
    const x = before.x + ((after.x - before.x) * k) / 64,
      y = before.y + ((after.y - before.y) * k) / 64;
    const near = [within(x, ix), within(y, iy)],
      gap = Math.hypot(near[0] - x, near[1] - y);
    if (gap < least - 1e-9) [least, point] = [gap, near];
  }
  return point;
}

/**
 * @param {Pen} pen
 * @param {RunScene} scene
 */
export function drawPierced(pen, scene) {
  const { context } = pen,
    { world, run } = scene;
  context.save();
  for (const cell of piercedCells(world, run).values()) {
    const over = scene.whole || scene.step >= cell.step;
    if (over || cell.named) drawCell(pen, cell, over);
  }
  for (const mark of run.marks) {
    if (!mark.cell || !(scene.whole || scene.step >= mark.step)) continue;
    const [x, y] = breachPoint(run, mark);
    crossAt(pen, x, y);
  }
  context.restore();
}

// Draws one cell with a frame, a wall that the robot entered with stripes; a later one gets a dashed frame.
function drawCell(pen, { ix, iy, named, isEntered }, over) {
  const { context, px, py, scale, colours } = pen,
    left = px(ix),
    top = py(iy + 1);
  if (over) {
    context.save();
    context.beginPath();
    context.rect(left, top, scale, scale);
    context.clip();
    // a light ground gives the stripes contrast
    for (const [colour, alpha] of [[colours.floor, LIGHTER], [colours[MARKS.pierced.colour], MARKS.pierced.fill]]) {
      context.globalAlpha = alpha;
      context.fillStyle = colour;
      context.fillRect(left, top, scale, scale);
    }
    context.globalAlpha = 1;
    context.beginPath();
    const apart = Math.max(MARKS.pierced.size * pen.unit, scale / 5);
    for (let k = -scale; isEntered && k < scale; k += apart) {
      context.moveTo(left + k, top + scale);
      context.lineTo(left + k + scale, top);
    }
    stroke(pen, colours[MARKS.pierced.colour], MARKS.pierced.width * pen.unit);
    context.restore();
  }
  context.beginPath();
  context.rect(left, top, scale, scale);
  stroke(pen, colours[MARKS.pierced.colour], MARKS.pierced.width * pen.unit * (over ? (named ? 1.5 : 1) : 0.75), over ? [] : [4, 3]);
}

function crossAt(pen, x, y) {
  const { context, px, py } = pen,
    reach = MARKS.breach.size * pen.unit;
  context.beginPath();
  for (const slant of [1, -1]) {
    context.moveTo(px(x) - reach, py(y) - slant * reach);
    context.lineTo(px(x) + reach, py(y) + slant * reach);
  }
  strokeMark(pen, "breach");
}
