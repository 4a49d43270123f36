// Finds a cut: a chain of cells that stops a disc from every pose of the target. worldgen/reach/still:
// cut.py, disc.py, target_poses.py.

import {
  add,
  ceil,
  div,
  even,
  exact,
  float,
  floor,
  fraction,
  isLess,
  lcm,
  mul,
  next,
  root,
  rootUp,
  square,
  sub,
} from "#player/live/exact.js";
import { HALF, UNIT, UNITS } from "#player/live/lattice.js";
import { isSame, linkLimit, refinement, targetOf } from "#player/live/query.js";
import { nearestCell } from "#player/live/walls.js";

/** @typedef {import("#player/live/exact.js").Fraction} Fraction */
/** @typedef {import("#player/live/core.js").Core} Core */
/** @typedef {import("#player/live/query.js").Query} Query */
/** @typedef {import("#player/live/walls.js").Point} Point */
/** @typedef {{ at: number, cells: number[] }} Chain its cells ix, iy in order, and where the core has them */

/** Lengths with more digits than C can multiply are rounded to this part of a cell. */
const GRAIN = fraction(1n, 1n << 30n);
/** C compares no finer parts of a lattice unit. */
const FINEST = 1n << 32n;
/** Binary digits of a root. */
const ROOT_BITS = 160n;
/** Doublings from a lattice unit to half a cell. */
const HALF_BITS = 9;
const LIMB_BITS = 32;
/** Poses that one search handles. */
const MOST_TARGETS = 6;
/** Work between two looks at whether a newer question has come. */
const PORTION = 1_000_000n;

/**
 * @param {LiveWorld} world
 * @param {CellPlace[]} cells
 * @param {Fraction | null} stoppedSq squared radius, cells, above which every disc is stopped
 * @param {string} reason
 * @returns {LiveProof}
 */
export function blocked(world, cells, stoppedSq, reason) {
  let clearance = next(world.radius, -1);
  if (stoppedSq) {
    const squared = mul(stoppedSq, square(exact(world.cell_size)));
    clearance = Math.min(clearance, squared.over ? rootUp(squared) : 0);
  }
  return { reachable: false, reason, witness: null, cut: { cells, clearance } };
}


/**
 * Returns the proof that no pose of the target can be reached, or a pose that can.
 * @param {Core} core
 * @param {LiveWorld} world
 * @param {Query} query
 * @param {() => Promise<void>} pause
 * @returns {Promise<{ proof: LiveProof } | { goal: Point }>} the proof may also be that none was found
 */
export async function cut(core, world, query, pause) {
  const { goal } = query;
  const centre = { x: query.x, y: query.y };
  if (goal) {
    const ring = await findChain(core, query, [goal], pause);
    if (!ring) return { goal };
    // Most rings surround the whole disc, and then its poses need not be examined one by one.
    if (isSame(goal, centre) && isBeyond(core, ring, query)) return { proof: ringed(core, world, query, ring) };
  }

  // Otherwise a few poses decide for all of them.
  const poses = decidingPoses(core, query);
  if (!poses) return query.isRounded ? undecided(TOO_LARGE) : cutWithFewerDigits(core, world, query, pause);
  try {
    if (!poses.count) {
      const { cell } = nearestCell(query, centre);
      return { proof: blocked(world, [cell], null, "no pose in the target's disc is clear") };
    }
    const parted = [poses.at(0)];
    while (parted.length <= MOST_TARGETS) {
      const ring = await findChain(core, query, parted, pause);
      if (!ring) break;
      const first = poses.firstUnparted(ring);
      if (first === poses.count) return { proof: ringed(core, world, query, ring) };
      const left = poses.at(first);
      if (!(await findChain(core, query, [left], pause))) return { goal: left };
      parted.push(left);
    }
    return parted.length === 1 ? { goal: parted[0] } : undecided(NO_RING);
  } finally {
    poses.free();
  }
}

const NO_RING = "every pose in the target's disc is walled off, but no single ring was found";
const TOO_LARGE = "the target's disc is too large to examine all of its poses; use a smaller one";
const TOO_FINE = "a passage is as wide as the disc, to a billionth of a cell; round the radius";

/**
 * @param {string} reason
 * @returns {{ proof: LiveProof }}
 */
const undecided = (reason) => ({ proof: { reachable: null, reason, witness: null, cut: null } });

/**
 * @param {Core} core
 * @param {LiveWorld} world
 * @param {Query} query
 * @param {Chain} ring
 */
function ringed(core, world, query, ring) {
  const count = ring.cells.length / 2;
  const isForAll = isBeyond(core, ring, query);
  const stopped = isForAll ? fraction(core.call("wg_chain_gap_sq", ring.at, BigInt(count)), 4) : null;
  const cells = Array.from({ length: count }, (_, k) => /** @type {CellPlace} */ (ring.cells.slice(2 * k, 2 * k + 2)));
  const words = `a ring of ${count} cells, with every gap too narrow to pass, separates start and target`;
  return blocked(world, cells, stopped, words);
}

/**
 * Does the work of `cut` by two questions whose lengths C can multiply.
 *
 * What a larger disc reaches in a smaller target, this disc reaches, too; and what stops a smaller
 * disc from every pose of a larger target stops it.
 * @param {Core} core
 * @param {LiveWorld} world
 * @param {Query} query
 * @param {() => Promise<void>} pause
 * @returns {ReturnType<typeof cut>}
 */
async function cutWithFewerDigits(core, world, query, pause) {
  const harder = rounded(query, 1n);
  if (harder && !isLess(nearestCell(query, query.start).squared, square(mul(harder.radius, UNITS)))) {
    const found = await cut(core, world, harder, pause);
    if ("goal" in found) return found;
  }
  const easier = rounded(query, -1n);
  if (!easier) return undecided(TOO_FINE);
  const found = await cut(core, world, easier, pause);
  if ("goal" in found) return undecided(TOO_FINE);
  return found.proof.reachable === false ? found : undecided(TOO_LARGE);
}

/**
 * Returns a harder question, or with -1 an easier one, with few digits; null if it has none.
 * @param {Query} query
 * @param {1n | -1n} sign
 * @returns {Query | null}
 */
function rounded(query, sign) {
  const grain = mul(UNITS, GRAIN);
  const signed = fraction(sign);
  // Rounding moves the centre by less than a grain.
  const reach = floor(mul(div(query.reach, grain), signed)) * sign - sign;
  if (reach < 0n) return null;
  return {
    ...query,
    isRounded: true,
    goal: null,
    x: mul(fraction(even(div(query.x, grain))), grain),
    y: mul(fraction(even(div(query.y, grain))), grain),
    reach: mul(fraction(reach), grain),
    radius: mul(fraction(ceil(mul(div(query.radius, GRAIN), signed)) * sign), GRAIN),
  };
}

/**
 * Returns a chain of cells that separates the start from other poses; null if there is none.
 * @param {Core} core
 * @param {Query} query
 * @param {Point[]} targets
 * @param {() => Promise<void>} pause
 * @returns {Promise<Chain | null>}
 */
async function findChain(core, query, targets, pause) {
  // Whole half cells, and the digits that are cut off.
  const values = [query.start, ...targets].flatMap(({ x, y }) => [x, y]);
  const isFine = values.some((value) => value.under > 1n);
  const finer = isFine ? refinement(query.radius) : 0;
  const bits = HALF_BITS + finer;
  const limbs = Math.ceil(bits / LIMB_BITS);
  /** @type {bigint[]} */
  const whole = [];
  /** @type {number[]} */
  const rest = [];
  for (const value of values) {
    const units = even(mul(value, fraction(1n << BigInt(finer))));
    whole.push(units >> BigInt(bits));
    const left = (units & ((1n << BigInt(bits)) - 1n)) << BigInt(limbs * LIMB_BITS - bits);
    for (let place = limbs - 1; place >= 0; place--) rest.push(Number((left >> BigInt(LIMB_BITS * place)) & 0xffffffffn));
  }
  const made = core.zeros(8);
  core.check(
    "wg_cut_search_new",
    ...[query.walls, linkLimit(query.radius), BigInt(targets.length), core.array(whole, "int64_t")],
    ...[BigInt(limbs), core.array(rest, "uint32_t"), made],
  );
  const [search] = core.view(made, 1, "uint32_t");
  const { WG_GOING, WG_FOUND } = core.constants;
  try {
    let progress = WG_GOING;
    while (progress === WG_GOING) {
      core.check("wg_cut_search_advance", search, PORTION, made + 4);
      progress = core.view(made + 4, 1, "int32_t")[0];
      await pause();
    }
    if (progress !== WG_FOUND) return null;
    const count = 2 * core.call("wg_cut_length", search);
    const at = core.zeros(8 * count);
    core.call("wg_cut_cells", search, at);
    return { at, cells: Array.from(core.view(at, count, "int64_t"), Number) };
  } finally {
    core.call("wg_cut_search_free", search);
  }
}

/**
 * Reports whether a chain winds around a pose an odd number of times, and is outside a radius.
 * @param {Core} core
 * @param {Chain} chain
 * @param {Point} pose
 * @param {Fraction} radius
 * @returns {{ winds: number, away: boolean }}
 */
function around(core, chain, pose, radius) {
  let scale = lcm(pose.x.under, pose.y.under);
  const finer = lcm(scale, radius.under);
  const fits = finer <= FINEST;
  if (fits) scale = finer;
  if (scale <= FINEST) {
    const [x, y] = [pose.x, pose.y].map((value) => value.over * (scale / value.under));
    const reach = fits ? radius.over * (scale / radius.under) : -1n;
    const rough = float(mul(radius, fraction(scale)));
    const found = core.zeros(16);
    const length = BigInt(chain.cells.length / 2);
    core.check("wg_chain_around", chain.at, length, BigInt(HALF) * scale, x, y, reach, rough, found, found + 8);
    const [winds, away] = core.view(found, 2, "int64_t");
    if (away >= 0n) return { winds: Number(winds), away: away === 1n };
  }
  // These numbers are too large for C.
  const lines = linesOf(chain.cells);
  return {
    winds: Number(lines.filter((line) => crosses(line, pose)).length % 2),
    away: lines.every((line) => isAway(line, pose, radius)),
  };
}

/**
 * Reports whether a chain separates the start from the whole target: its line avoids the disc.
 * @param {Core} core
 * @param {Chain} chain
 * @param {Query} query
 */
function isBeyond(core, chain, { start, x, y, reach }) {
  const { winds, away } = around(core, chain, { x, y }, reach);
  return away && winds !== around(core, chain, start, fraction(0)).winds;
}

/**
 * Returns a chain as a closed line: each cell's centre, two closest points, the next centre.
 * @param {number[]} cells
 */
function linesOf(cells) {
  /** @type {Point[]} */
  const corners = [];
  const count = cells.length / 2;
  const point = (/** @type {number} */ x, /** @type {number} */ y) => ({ x: fraction(x), y: fraction(y) });
  for (let k = 0; k < count; k++) {
    const [ax, ay] = [cells[2 * k], cells[2 * k + 1]];
    const other = 2 * ((k + 1) % count);
    const [bx, by] = [cells[other], cells[other + 1]];
    const [sx, sy] = [Math.sign(bx - ax), Math.sign(by - ay)];
    const [x, y] = [UNIT * ax + HALF, UNIT * ay + HALF];
    corners.push(point(x, y), point(x + HALF * sx, y + HALF * sy));
    corners.push(point(UNIT * bx + HALF - HALF * sx, UNIT * by + HALF - HALF * sy));
  }
  return corners.map((p, k) => ({ p, q: corners[(k + 1) % corners.length] }));
}

/**
 * @param {{ p: Point, q: Point }} line
 * @param {Point} at
 */
function crosses({ p, q }, at) {
  const isLeft = !isLess(at.x, p.x);
  if (isLeft === !isLess(at.x, q.x)) return false;
  const rise = add(mul(sub(p.y, at.y), sub(q.x, p.x)), mul(sub(q.y, p.y), sub(at.x, p.x)));
  return rise.over !== 0n && rise.over > 0n === isLess(p.x, q.x);
}

/**
 * @param {{ p: Point, q: Point }} line
 * @param {Point} at
 * @param {Fraction} radius
 */
function isAway({ p, q }, at, radius) {
  const [ex, ey] = [sub(q.x, p.x), sub(q.y, p.y)];
  const [ux, uy] = [sub(at.x, p.x), sub(at.y, p.y)];
  const along = add(mul(ex, ux), mul(ey, uy));
  const lengthSq = add(square(ex), square(ey));
  const limit = square(radius);
  if (along.over > 0n && isLess(along, lengthSq)) {
    return isLess(mul(limit, lengthSq), square(sub(mul(ex, uy), mul(ey, ux))));
  }
  const end = add(square(sub(at.x, q.x)), square(sub(at.y, q.y)));
  return isLess(limit, add(square(ux), square(uy))) && isLess(limit, end);
}

/**
 * Lists clear poses of the target that decide for all of it; null if they are too many, or lengths
 * have too many digits.
 * @param {Core} core
 * @param {Query} query
 */
function decidingPoses(core, query) {
  const made = core.zeros(8);
  const fields = Object.entries(targetOf(query)).map(([name, value]) => [name.slice("target.".length), value]);
  const target = core.make("WgTarget", Object.fromEntries(fields));
  const scale = core.whole(target, "WgTarget", "scale");
  if (!scale) return null;
  core.check("wg_poses_new", query.walls, target, made, made + 4);
  const [poses, listed] = core.view(made, 2, "uint32_t");
  if (listed !== core.constants.WG_LISTED) return null;
  return {
    count: core.call("wg_poses_count", poses),
    at: (/** @type {number} */ index) => poseOf(core, query, poses, index, scale),
    /** Returns the first one that a chain fails to separate from the start; their number for none. */
    firstUnparted(/** @type {Chain} */ { at, cells }) {
      const { winds } = around(core, { at, cells }, query.start, fraction(0));
      return core.call("wg_poses_next", poses, at, BigInt(cells.length / 2), BigInt(winds), 0n);
    },
    free: () => core.call("wg_poses_free", poses),
  };
}

/**
 * Returns a pose of the target, lattice units; the error of irrational coordinates is below 2^-140.
 * @param {Core} core
 * @param {Query} query
 * @param {number} poses
 * @param {number} index
 * @param {bigint} scale
 * @returns {Point}
 */
function poseOf(core, query, poses, index, scale) {
  const described = core.make("WgPoseOf");
  core.call("wg_poses_describe", poses, BigInt(index), described);
  const { kind, x, y, dx, dy, side } = core.all(described, "WgPoseOf");
  const { WG_PLAIN, WG_ON_RAY, WG_ON_ROW, WG_BETWEEN } = core.constants;
  const part = (/** @type {string} */ field) => fraction(core.whole(described, "WgPoseOf", field), scale);
  const { radius } = query;
  const zero = fraction(0);
  const [qx, qy, to] = [x, y, side].map((value) => fraction(value));

  // (ax + bx * root, ay + by * root), root being the square root of `under`.
  const pose = (
    /** @type {Fraction} */ ax,
    /** @type {Fraction} */ ay,
    /** @type {Fraction} */ bx,
    /** @type {Fraction} */ by,
    /** @type {Fraction} */ of,
  ) => {
    const found = fraction(root((of.over * of.under) << (2n * ROOT_BITS)), of.under << ROOT_BITS);
    return { x: mul(add(ax, mul(bx, found)), UNITS), y: mul(add(ay, mul(by, found)), UNITS) };
  };
  if (kind === WG_PLAIN) return pose(part("x"), part("y"), zero, zero, zero);
  if (kind === WG_ON_RAY) {
    const away = [sub(div(query.x, UNITS), qx), sub(div(query.y, UNITS), qy)];
    const awaySq = add(square(away[0]), square(away[1]));
    const share = div(radius, awaySq);
    return pose(qx, qy, mul(share, away[0]), mul(share, away[1]), awaySq);
  }
  if (kind === WG_BETWEEN) {
    const apart = fraction(BigInt(dx) * BigInt(dx) + BigInt(dy) * BigInt(dy));
    const of = sub(div(square(radius), apart), fraction(1, 4));
    const [mx, my] = [add(qx, fraction(dx, 2)), add(qy, fraction(dy, 2))];
    return pose(mx, my, fraction(-dy * side), fraction(dx * side), of);
  }
  const level = part("level");
  if (kind === WG_ON_ROW) return pose(qx, level, to, zero, sub(square(radius), square(sub(level, qy))));
  return pose(level, qy, zero, to, sub(square(radius), square(sub(level, qx))));
}
