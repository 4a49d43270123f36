// Range beams for the picture: straight lines from the robot's centre to the first wall, without a sensor's noise.
// Source: John Amanatides and Andrew Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics 1987.

import { SOLID, stateAt } from "./decode.js";

export function beamHeadings(heading, sensors) {
  const { beams, field } = sensors;
  const turn = 2 * Math.PI;
  return Array.from({ length: beams }, (_, k) => {
    if (field === 0 || field >= turn) return heading + (k * turn) / beams;
    return beams === 1 ? heading : heading + (k / (beams - 1) - 0.5) * field;
  });
}

export function castBeam(cells, world, x, y, heading, longest) {
  const dx = Math.cos(heading),
    dy = Math.sin(heading);
  const stepX = dx > 0 ? 1 : -1,
    stepY = dy > 0 ? 1 : -1;
  const perX = dx === 0 ? Infinity : Math.abs(1 / dx),
    perY = dy === 0 ? Infinity : Math.abs(1 / dy);
  let ix = Math.floor(x),
    iy = Math.floor(y);
  let toX = dx === 0 ? Infinity : (dx > 0 ? ix + 1 - x : x - ix) * perX;
  let toY = dy === 0 ? Infinity : (dy > 0 ? iy + 1 - y : y - iy) * perY;
  let way = 0;
  while (way < longest) {
    if (toX < toY) {
      way = toX;
      ix += stepX;
      toX += perX;
    } else {
      way = toY;
      iy += stepY;
      toY += perY;
    }
    if (stateAt(cells, world, ix, iy) === SOLID) break;
  }
  way = Math.min(way, longest);
  return [x + dx * way, y + dy * way];
}
