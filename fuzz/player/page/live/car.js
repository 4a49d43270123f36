// Searches for a path of a car in a static world: worldgen/reach/car/search.py. The paths of the body
// alone, which a car that may reverse could follow, are left to worldgen.

import { float, fraction, isLess, mul, next, square } from "#player/live/exact.js";
import { TURN, UNIT, UNITS, headingFromLattice, headingToLattice, inCells, inUnits, toLattice, toMetres } from "#player/live/lattice.js";
import { bodyIn } from "#player/live/body.js";
import { undecided } from "#player/live/prove.js";
import { discFields, queryOf } from "#player/live/query.js";
import { clearanceSq } from "#player/live/walls.js";
import { proofOfPath, short, timesOf, witnessOf } from "#player/live/witness.js";

/** @typedef {import("#player/live/core.js").Core} Core */
/** @typedef {import("#player/live/body.js").Pose} Pose */
/** @typedef {NonNullable<LiveProof["witness"]>} Witness */
/** @typedef {LiveWorld & {car: LiveCar, headings: [number, number]}} CarWorld */

/** How finely to search: bins of a place and of a heading, and the limit on the poses. */
const EFFORTS = [
  { bins: 1, headings: 48, most: 2_000 },
  { bins: 2, headings: 72, most: 10_000 },
];

/**
 * @param {Core} core the prover
 * @param {LiveWorld & {car: LiveCar}} world
 * @param {() => Promise<void>} pause throws if a newer question has come
 * @returns {Promise<LiveProof>}
 */
export async function proveCar(core, world, pause) {
  const { headings, waypoints } = world;
  if (waypoints) return undecided("a car's path to several goals is searched by worldgen verify");
  if (!headings) return undecided("no heading of 1/65536 turn is within the tolerance of the target's");
  let searched = 0;
  for (const effort of EFFORTS) {
    const { poses, expanded } = search(core, { ...world, headings }, effort);
    searched += expanded;
    const witness = poses.length > 0 ? witnessOfCar(core, world, poses) : null;
    if (witness) {
      const room = (/** @type {number} */ clearance) =>
        world.body ? `leaves the footprint ${short(clearance)} m to spare` : `is clear for discs of up to ${short(clearance)} m`;
      return proofOfPath(witness, (length, clearance) => `a car's path of ${short(length)} m ${room(clearance)}`);
    }
    await pause();
  }
  return undecided(`no path of the car was found among ${searched} poses; worldgen verify searches longer`);
}

/**
 * @param {Core} core
 * @param {CarWorld} world
 * @param {{bins: number, headings: number, most: number}} effort
 * @returns {{poses: Pose[], expanded: number}}
 */
function search(core, world, effort) {
  const { cell_size: side, start, target, car, body } = world;
  const query = queryOf(core, world);
  const inner = body ? inCells(body.inside, side) : query.radius,
    units = (/** @type {number} */ value) => (body ? Number(toLattice(value, side)) : float(inUnits(value, side)));
  const asked = core.make("WgCarQuery", {
    ...(body ? { body: bodyIn(core, { ...world, body }).at, ...around(body) } : discFields("around", query.radius)),
    ...discFields("disc", inner),
    turning_radius: float(inUnits(car.turning_radius, side)),
    reverse: Number(car.reverse),
    start_x: units(start[0]),
    start_y: units(start[1]),
    start_heading: headingToLattice(start[2]),
    target_x: float(inUnits(target[0], side)),
    target_y: float(inUnits(target[1], side)),
    target_radius: float(inUnits(target[2], side)),
    from_heading: world.headings[0],
    headings: world.headings[1],
    clear_from: clearFrom(inner),
    bin: Math.max(2, Math.max(UNIT, float(mul(inner, UNITS))) / effort.bins),
    heading_bins: effort.headings,
    most: effort.most,
  });
  core.check("wg_car_search", query.walls, asked);
  const { count, expanded, poses } = core.all(asked, "WgCarQuery");
  const numbers = Array.from(count ? core.view(poses, 3 * count, "int64_t") : [], Number);
  core.call("wg_car_free", asked);
  return { poses: Array.from({ length: count }, (_, k) => /** @type {Pose} */ (numbers.slice(3 * k, 3 * k + 3))), expanded };
}

/** The smallest squared distance, in quarters of a cell, at which a disc of some cells is clear. */
function clearFrom(/** @type {import("#player/live/exact.js").Fraction} */ radius) {
  const { over, under } = square(mul(fraction(4), radius));
  const most = (over + under - 1n) / under;
  return most > 1n ? most : 1n;
}

/**
 * Returns the disc about the axle that holds a body.
 * @param {LiveBody} body
 */
function around({ corners }) {
  const squared = Math.max(...corners.map(([x, y]) => x * x + y * y));
  return { "around.reach": Math.ceil(Math.sqrt(squared)), "around.limit": squared, "around.radius_sq": squared };
}

/**
 * Returns the turn and the gear of the drive between two poses.
 * @param {Pose} p
 * @param {Pose} q
 */
function legOf(p, q) {
  const turn = modulo(q[2] - p[2] + TURN / 2) - TURN / 2,
    along = ((p[2] + turn / 2) * 2 * Math.PI) / TURN;
  return { turn, gear: (q[0] - p[0]) * Math.cos(along) + (q[1] - p[1]) * Math.sin(along) >= 0 ? 1 : -1 };
}

/** @param {number} heading */
const modulo = (heading) => ((heading % TURN) + TURN) % TURN;

/**
 * Returns the witness of a path; null if rounding its ends to the lattice made it none.
 * @param {Core} core
 * @param {LiveWorld & {car: LiveCar}} world
 * @param {Pose[]} poses
 * @returns {Witness | null}
 */
function witnessOfCar(core, world, poses) {
  const { cell_size: side, target, body, car } = world;
  const points = poses.map(([x, y]) => ({ x: fraction(x), y: fraction(y) }));
  const last = poses[poses.length - 1];
  const [dx, dy] = [0, 1].map((axis) => float(inUnits(target[axis], side)) - last[axis]);
  if (dx * dx + dy * dy > float(square(inUnits(target[2], side)))) return null;
  const heading = poses.map((pose) => headingFromLattice(pose[2]));
  if (!body) {
    const query = queryOf(core, world);
    points[0] = query.exactStart;
    if (isLess(clearanceSq(query, points), square(mul(query.radius, UNITS)))) return null;
    return steered({ ...witnessOf(world, query, points), heading }, poses, car.steering_rate);
  }
  const every = poses.flatMap((q, k) => {
    if (k === 0) return [q];
    const p = poses[k - 1],
      along = modulo(p[2] + Math.trunc(legOf(p, q).turn / 2));
    return /** @type {Pose[]} */ ([[p[0], p[1], along], [q[0], q[1], along], q]);
  });
  const distinct = every.filter((pose, k) => k === 0 || pose.some((value, axis) => value !== every[k - 1][axis]));
  const room = ((bodyIn(core, { ...world, body }).clearance(distinct) * side) / UNIT) * (1 - 1e-12);
  const path = {
    t: timesOf(world, points),
    x: poses.map(([x]) => toMetres(x, side)),
    y: poses.map(([, y]) => toMetres(y, side)),
    heading,
    clearance: room > 0 ? next(room, -1) : 0,
  };
  return steered(path, poses, car.steering_rate);
}

/**
 * Returns a path that waits wherever the steering changes, if that takes time.
 * @param {Witness} path
 * @param {Pose[]} poses
 * @param {number} rate
 * @returns {Witness}
 */
function steered(path, poses, rate) {
  if (!rate) return path;
  const ticks = 1e6;
  let late = 0,
    before = 0;
  /** @type {[number, number][]} */
  const rows = [[0, 0]];
  for (let k = 1; k < poses.length; k++) {
    const { turn, gear } = legOf(poses[k - 1], poses[k]),
      steer = gear * Math.sign(turn);
    if (steer !== before) {
      late += Math.ceil((Math.abs(steer - before) / rate) * ticks) / ticks;
      rows.push([path.t[k - 1] + late, k - 1]);
    }
    rows.push([path.t[k] + late, k]);
    before = steer;
  }
  const kept = (/** @type {number[]} */ column) => rows.map(([, k]) => column[k]);
  return { ...path, t: rows.map(([time]) => time), x: kept(path.x), y: kept(path.y), heading: path.heading && kept(path.heading) };
}
