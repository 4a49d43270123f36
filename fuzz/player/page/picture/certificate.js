// The certificate of a world: its witness, or the cut that separates the target from the start.

import { openWorld } from "#player/decode.js";
import { disc, line, robotColour, stroke } from "#player/picture/pen.js";

// pixels: makes the path and the cut stand out from anything below them, even to people who see few
// colours
const CASING = 5;

/**
 * Draws a timed path, and a dot at its place at the given time.
 * @param {Pen} pen
 * @param {{ms: Float64Array, x: Float64Array, y: Float64Array}} witness
 * @param {number} ms
 * @param {string} colour
 */
function drawWitness(pen, witness, ms, colour) {
  const strong = pen.colours[colour];
  line(pen, witness.x, witness.y, 0, witness.x.length);
  stroke(pen, pen.colours.floor, CASING);
  stroke(pen, strong, 2, [6, 4]);
  const next = witness.ms.findIndex((time) => time > ms),
    last = witness.ms.length - 1;
  const k = next < 0 ? last : Math.max(0, next - 1),
    gap = witness.ms[Math.min(k + 1, last)] - witness.ms[k];
  const share = gap > 0 ? Math.min(1, (ms - witness.ms[k]) / gap) : 0;
  const along = (column) => column[k] + (column[Math.min(k + 1, last)] - column[k]) * share;
  disc(pen, along(witness.x), along(witness.y), Math.max(3.5 / pen.scale, 0.08), strong);
}

/**
 * @param {Pen} pen
 * @param {SceneWorld} world
 * @param {number} ms
 */
export function drawCertificate(pen, world, ms) {
  const { context, px, py, colours } = pen;
  const { witness, others = [] } = openWorld(world);
  context.save();
  if (witness) drawWitness(pen, witness, ms, others.length ? robotColour(1) : "start");
  others.forEach((path, k) => path && drawWitness(pen, path, ms, robotColour(k + 2)));
  if (world.cut) {
    context.beginPath();
    for (const [ix, iy] of [...world.cut, world.cut[0]]) context.lineTo(px(ix + 0.5), py(iy + 0.5));
    stroke(pen, colours.floor, CASING); // the cut runs over walls
    stroke(pen, colours.breach, 2.5, [6, 5]);
  }
  context.restore();
}
