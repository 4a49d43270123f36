// The wall cells that the robot touches, and the step of the first touch.

import { SOLID, cellsAt, openRun, stateAt } from "#player/decode.js";
import { rimOf } from "#player/picture/pen.js";

// Returns the wall cells that the robot touches: those nearest to its disc at a bump,
// each with the first such step.
function touchedCells(world, run) {
  const open = openRun(run);
  if (open.touched) return open.touched;
  open.touched = new Map();
  for (let row = 0; row < open.at.length; row += 1) {
    if (!open.bump[row]) continue;
    const cells = cellsAt(world, open.at[row] * run.dt * 1000);
    for (const [ix, iy] of nearestWalls(cells, world, open.x[row], open.y[row])) {
      const key = `${ix},${iy}`;
      if (!open.touched.has(key)) open.touched.set(key, { ix, iy, step: open.at[row] });
    }
  }
  return open.touched;
}

function nearestWalls(cells, world, x, y) {
  const reach = Math.min(40, Math.ceil(world.radius) + 1),
    found = [];
  let least = world.radius + 0.5;
  for (let iy = Math.floor(y) - reach; iy <= Math.floor(y) + reach; iy += 1) {
    for (let ix = Math.floor(x) - reach; ix <= Math.floor(x) + reach; ix += 1) {
      if (stateAt(cells, world, ix, iy) !== SOLID) continue;
      const dx = Math.max(ix - x, 0, x - ix - 1),
        dy = Math.max(iy - y, 0, y - iy - 1);
      const gap = Math.sqrt(dx * dx + dy * dy);
      found.push([ix, iy, gap]);
      least = Math.min(least, gap);
    }
  }
  return found.filter(([, , gap]) => gap <= least + 0.03 && gap <= world.radius + 0.5);
}

/**
 * @param {Pen} pen
 * @param {RunScene} scene
 */
export function drawTouched(pen, scene) {
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
