// Unpacks numbers and bits written by fuzz/player/streams.py,
// and prepares worlds and runs for drawing, once each.

/**
 * @param {string} text
 * @returns {Uint8Array<ArrayBuffer>}
 */
export function bytesOf(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

/**
 * @param {Packed} text
 * @returns {Float64Array}
 */
export function numbersOf(text) {
  // Undo the seven-bit groups, then the zigzag encoding, then the second differences.
  const values = [];
  let value = 0,
    rate = 0,
    zigzag = 0,
    scale = 1;
  for (const byte of bytesOf(text)) {
    zigzag += (byte & 127) * scale;
    scale *= 128;
    if (byte > 127) continue;
    rate += zigzag % 2 ? -(zigzag + 1) / 2 : zigzag / 2;
    value += rate;
    values.push(value);
    zigzag = 0;
    scale = 1;
  }
  return Float64Array.from(values);
}

/**
 * @param {Bits} text
 * @param {number} count
 * @returns {Uint8Array}
 */
function bitsOf(text, count) {
  const bytes = bytesOf(text);
  return Uint8Array.from({ length: count }, (_, k) => (bytes[k >> 3] >> (k & 7)) & 1);
}

/** States of a cell, as in worldgen/timeline.py. */
export const FREE = 0,
  SOLID = 1,
  BURNING = 2;

/**
 * Returns a witness with its times in ms and its places in cells.
 * @param {PackedWitness | null | undefined} witness
 * @returns {OpenWorld["witness"]}
 */
export function openWitness(witness) {
  if (!witness) return null;
  const { per_cell: perCell } = witness;
  return {
    ms: numbersOf(witness.ms),
    x: numbersOf(witness.x).map((value) => value / perCell),
    y: numbersOf(witness.y).map((value) => value / perCell),
  };
}

export function opened(thing, open) {
  if (!thing.open) Object.defineProperty(thing, "open", { value: open(thing) });
  return thing.open;
}

/**
 * @param {SceneWorld} world
 * @returns {OpenWorld}
 */
export function openWorld(world) {
  return opened(world, () => {
    return {
      cells: bitsOf(world.cells ?? "", world.width * world.height),
      events: world.events && {
        ms: numbersOf(world.events.ms),
        ix: numbersOf(world.events.ix),
        iy: numbersOf(world.events.iy),
        state: numbersOf(world.events.state),
      },
      witness: openWitness(world.witness),
      // witnesses of the other robots
      others: (world.others ?? []).map((other) => openWitness(other.witness)),
      now: null, // cells at some time, and the number of events applied to them
      done: 0,
    };
  });
}

/**
 * @param {DrawnRun} run
 * @returns {OpenRun}
 */
export function openRun(run) {
  return opened(run, () => {
    const { step, cell, turn } = run.per;
    const at = numbersOf(run.at).map((value) => value / step);
    return {
      at, // time of each row, in steps
      x: numbersOf(run.x).map((value) => value / cell),
      y: numbersOf(run.y).map((value) => value / cell),
      heading: numbersOf(run.heading).map((value) => (value / turn) * 2 * Math.PI),
      bump: bitsOf(run.bump, at.length),
      active: run.active && numbersOf(run.active),
    };
  });
}

/**
 * Returns the cells at a time: free, solid or burning. Every call returns the same array.
 * @param {SceneWorld} world
 * @param {number} ms
 * @returns {Uint8Array}
 */
export function cellsAt(world, ms) {
  const open = openWorld(world);
  if (!open.events) return open.cells;
  const { ms: times, ix, iy, state } = open.events;
  // Events are applied in order; going back in time means starting over.
  if (!open.now || (open.done > 0 && times[open.done - 1] > ms)) {
    open.now = open.cells.slice();
    open.done = 0;
  }
  while (open.done < times.length && times[open.done] <= ms + 1e-6) {
    open.now[iy[open.done] * world.width + ix[open.done]] = state[open.done];
    open.done += 1;
  }
  return open.now;
}

/**
 * @param {Uint8Array} cells
 * @param {SceneWorld} world
 * @param {number} ix
 * @param {number} iy
 * @returns {number}
 */
export function stateAt(cells, world, ix, iy) {
  return ix < 0 || iy < 0 || ix >= world.width || iy >= world.height ? SOLID : cells[iy * world.width + ix];
}

/**
 * Returns the last row that is not later than a step, by bisection.
 * @param {DrawnRun} run
 * @param {number} step
 * @returns {number}
 */
export function rowAt(run, step) {
  const at = openRun(run).at;
  let low = 0,
    high = at.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (at[middle] <= step) low = middle;
    else high = middle - 1;
  }
  return low;
}

/**
 * Returns the behaviour that acted at a row; null for a robot without behaviours.
 * @param {DrawnRun} run
 * @param {number} row
 * @returns {string | null}
 */
export function behaviourAt(run, row) {
  const { active } = openRun(run);
  return active ? run.behaviours?.[active[row]] || "none" : null;
}

/**
 * Maps a step beyond a run's end to one within it: a loop repeats forever, another run stays where
 * it ended.
 * @param {DrawnRun} run
 * @param {number} step
 * @returns {number}
 */
export function stepWithin(run, step) {
  if (step <= run.steps || !run.loop) return Math.min(step, run.steps);
  const [entry, period] = run.loop;
  return entry + ((step - entry) % period);
}

/**
 * @param {DrawnRun} run
 * @param {number} step
 * @returns {Pose}
 */
export function poseAt(run, step) {
  const open = openRun(run);
  const row = rowAt(run, step),
    next = Math.min(row + 1, open.at.length - 1);
  const gap = open.at[next] - open.at[row];
  const share = gap > 0 ? Math.min(1, Math.max(0, (step - open.at[row]) / gap)) : 0;
  const between = (column) => column[row] + (column[next] - column[row]) * share;
  return { x: between(open.x), y: between(open.y), heading: between(open.heading), bump: open.bump[row] === 1, row };
}
