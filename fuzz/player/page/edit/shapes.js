// The geometry of cells: lines, rectangles, floods, and patterns that can be turned and mirrored.
// A pattern has width, height and cells, row by row from the lowest: 1 solid, 0 free,
// KEEP for no change.

export const KEEP = 2;

/**
 * Returns the cells of a straight line, including both ends.
 * Source: Jack E. Bresenham, "Algorithm for computer control of a digital plotter", IBM Systems
 * Journal 4 (1965).
 * @param {CellPlace} from
 * @param {CellPlace} to
 * @returns {CellPlace[]}
 */
export function lineCells([x0, y0], [x1, y1]) {
  const dx = Math.abs(x1 - x0),
    dy = -Math.abs(y1 - y0);
  const stepX = x0 < x1 ? 1 : -1,
    stepY = y0 < y1 ? 1 : -1;
  const cells = [];
  let x = x0,
    y = y0,
    error = dx + dy;
  for (;;) {
    cells.push([x, y]);
    if (x === x1 && y === y1) return cells;
    const twice = 2 * error;
    if (twice >= dy) {
      error += dy;
      x += stepX;
    }
    if (twice <= dx) {
      error += dx;
      y += stepY;
    }
  }
}

/**
 * Returns the rectangle that has these opposite corners.
 * @param {CellPlace} from
 * @param {CellPlace} to
 * @returns {Box}
 */
export function rectangleOf([x0, y0], [x1, y1]) {
  const x = Math.min(x0, x1),
    y = Math.min(y0, y1);
  return { x, y, width: Math.abs(x1 - x0) + 1, height: Math.abs(y1 - y0) + 1 };
}

/**
 * Returns the rectangle as boxes: itself, or its four sides.
 * @param {Box} rectangle
 * @param {boolean} [hollow]
 * @returns {Box[]}
 */
export function rectangleBoxes({ x, y, width, height }, hollow = false) {
  if (!hollow || width < 3 || height < 3) return [{ x, y, width, height }];
  return [
    { x, y, width, height: 1 },
    { x, y: y + height - 1, width, height: 1 },
    { x, y: y + 1, width: 1, height: height - 2 },
    { x: x + width - 1, y: y + 1, width: 1, height: height - 2 },
  ];
}

/**
 * Returns a square brush with sides of `size` cells around a cell.
 * @param {CellPlace} cell
 * @param {number} size
 * @returns {Box}
 */
export function brushBox([x, y], size) {
  const low = Math.floor((size - 1) / 2);
  return { x: x - low, y: y - low, width: size, height: size };
}

/**
 * Returns the numbers of all cells that are connected by sides to the one at (x, y) and equal to
 * it.
 * @param {{cells: Uint8Array, width: number, height: number}} map
 * @param {CellPlace} cell
 * @returns {Int32Array}
 */
export function floodCells({ cells, width, height }, [x, y]) {
  const wanted = cells[y * width + x],
    seen = new Uint8Array(width * height),
    // the neighbours of those before `done` have been visited
    found = new Int32Array(width * height);
  let count = 0;
  const meet = (to) => {
    if (seen[to] || cells[to] !== wanted) return;
    seen[to] = 1;
    found[count] = to;
    count += 1;
  };
  meet(y * width + x);
  for (let done = 0; done < count; done += 1) {
    const at = found[done],
      ix = at % width;
    if (ix > 0) meet(at - 1);
    if (ix < width - 1) meet(at + 1);
    if (at >= width) meet(at - width);
    if (at < width * (height - 1)) meet(at + width);
  }
  return found.subarray(0, count);
}

/**
 * Returns the contents of a rectangle of a map; cells outside the map become KEEP.
 * @param {{cells: Uint8Array, width: number, height: number}} map
 * @param {Box} box
 * @returns {Pattern}
 */
export function patternIn(map, { x, y, width, height }) {
  return patternOf(width, height, (ix, iy) => {
    const column = x + ix,
      row = y + iy;
    const inside = column >= 0 && row >= 0 && column < map.width && row < map.height;
    return inside ? map.cells[row * map.width + column] : KEEP;
  });
}

/**
 * @param {number} width
 * @param {number} height
 * @param {(ix: number, iy: number) => number} cell
 * @returns {Pattern}
 */
export function patternOf(width, height, cell) {
  const cells = new Uint8Array(width * height);
  for (let iy = 0; iy < height; iy += 1) for (let ix = 0; ix < width; ix += 1) cells[iy * width + ix] = cell(ix, iy);
  return { width, height, cells };
}

const at = (pattern, ix, iy) => pattern.cells[iy * pattern.width + ix];

/**
 * Turns a pattern by a quarter turn to the left.
 * @param {Pattern} pattern
 * @returns {Pattern}
 */
export function turned(pattern) {
  return patternOf(pattern.height, pattern.width, (ix, iy) => at(pattern, iy, pattern.height - 1 - ix));
}

/**
 * @param {Pattern} pattern
 * @returns {Pattern}
 */
export function mirrored(pattern) {
  return patternOf(pattern.width, pattern.height, (ix, iy) => at(pattern, pattern.width - 1 - ix, iy));
}

/**
 * @param {Pattern} pattern
 * @returns {Pattern}
 */
export function flipped(pattern) {
  return patternOf(pattern.width, pattern.height, (ix, iy) => at(pattern, ix, pattern.height - 1 - iy));
}

const walls = (size, solid) => patternOf(size, size, (ix, iy) => (solid(ix, iy, size - 1) ? 1 : KEEP));

/** Stamps by name; each makes a pattern with sides of about `size` cells. */
export const STAMPS = {
  "U trap": (size) => walls(size, (ix, iy, last) => ix === last || iy === 0 || iy === last),
  "L trap": (size) => walls(size, (ix, iy, last) => ix === last || iy === 0),
  "V trap": (size) =>
    walls(size, (ix, iy, last) => Math.abs(2 * iy - last) <= 2 * (last - ix) + 1 && vEdge(ix, iy, last)),
  Spiral: (size) => spiral(size),
  Comb: (size) => walls(size, (ix, iy, last) => ix === last || iy % 4 === 0 || (iy === last && last % 4 === 0)),
  Corridor: (size) =>
    patternOf(size, Math.max(4, Math.round(size / 3)), (ix, iy) => {
      const high = Math.max(4, Math.round(size / 3));
      return iy === 0 || iy === high - 1 ? 1 : 0;
    }),
  Room: (size) =>
    patternOf(size, size, (ix, iy) => {
      const last = size - 1,
        door = ix === 0 && Math.abs(2 * iy - last) <= 3;
      return (ix === 0 || iy === 0 || ix === last || iy === last) && !door ? 1 : 0;
    }),
};

// Makes two slanted walls that meet at the right. They are two cells thick,
// so that no disc slips through at corners.
function vEdge(ix, iy, last) {
  const across = Math.abs(2 * iy - last) / 2;
  return Math.abs(across - (last - ix) / 2) < 0.9;
}

// Makes a wall that winds inwards, with three free cells between its turns, open at the lower left.
function spiral(size) {
  const made = { width: size, height: size, cells: new Uint8Array(size * size).fill(KEEP) };
  const directions = [
    [1, 0],
    [0, 1],
    [-1, 0],
    [0, -1],
  ];
  let x = 0,
    y = 0;
  for (let turn = 0; ; turn += 1) {
    const length = size - 1 - (turn > 2 ? 4 * Math.ceil((turn - 2) / 2) : 0);
    if (length < 1) return made;
    const [dx, dy] = directions[turn % 4];
    for (let step = 0; step <= length; step += 1) made.cells[(y + dy * step) * size + x + dx * step] = 1;
    x += dx * length;
    y += dy * length;
  }
}
