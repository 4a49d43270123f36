// Decides a static world for a footprint: worldgen/reach/body/prove.py.

import { add, float, fraction, isLess, next, square, sub } from "#player/live/exact.js";
import { TURN, UNIT, headingFromLattice, headingToLattice, inUnits, solidOf, toLattice, toMetres } from "#player/live/lattice.js";
import { prove, undecided } from "#player/live/prove.js";
import { proofOfPath, short, timesOf } from "#player/live/witness.js";

/** @typedef {import("#player/live/core.js").Core} Core */
/** @typedef {[number, number, number]} Pose x and y, lattice units; heading, 1/65536 turn */

/** Limit on the boxes of poses of one search. */
const MOST_BOXES = 200_000;
/** Lattice units by which a measured clearance may be below the real one. */
const SLACK = 0.5;
const NO_HEADING = "no heading of 1/65536 turn is within the tolerance of the target's; use a larger tolerance";

/**
 * @param {Core} core the prover
 * @param {LiveWorld & {body: LiveBody}} world
 * @param {() => Promise<void>} pause throws if a newer question has come
 * @returns {Promise<LiveProof>}
 */
export async function proveBody(core, world, pause) {
  const { body: given, cell_size: side } = world;
  if (!world.headings) return undecided(NO_HEADING);
  const body = bodyIn(core, world);
  /** @type {Pose} */
  const start = [Number(toLattice(world.start[0], side)), Number(toLattice(world.start[1], side)), headingToLattice(world.start[2])];
  if (!body.isClear(start)) {
    return cutOf([[start[2], 0, 0, start[1], start[0], start[0]]], "the body overlaps a wall at the start");
  }

  // What stops the disc that the body holds stops the body; where the disc around it gets, it gets.
  if (given.inside > 0) {
    const held = await prove(core, { ...world, radius: given.inside }, pause);
    if (held.reachable === false) return held;
  }
  const around = await prove(core, { ...world, radius: given.around }, pause, { wantsCut: false });
  const alongDisc = around.witness ? alongPath(body, world, start, around.witness) : null;
  if (alongDisc) return reachedBy(world, alongDisc, body.clearance(alongDisc));
  await pause();

  // Between them, boxes of poses are searched.
  const { outcome, rows, clearance, boxes, finest } = body.search(start, world);
  const { WG_BODY_REACHED, WG_BODY_STOPPED } = core.constants;
  if (outcome === WG_BODY_REACHED) return reachedBy(world, /** @type {Pose[]} */ (rows), clearance);
  if (outcome === WG_BODY_STOPPED) {
    return cutOf(rows, `${rows.length} runs of poses in which the body overlaps a wall separate the start from the target`);
  }
  return undecided(
    `${boxes} boxes of poses, down to ${finest[0]}/1024 of a cell and ${finest[1]}/65536 of a turn, neither connect the ` +
      "start with the target nor separate them; the body fits too closely",
  );
}

/**
 * @param {number[][]} boxes
 * @param {string} reason
 * @returns {LiveProof}
 */
const cutOf = (boxes, reason) => ({ reachable: false, reason, witness: null, cut: { cells: [], clearance: 0, boxes } });

/**
 * Returns the body among the walls of a world, for exact questions.
 * @param {Core} core
 * @param {LiveWorld & {body: LiveBody}} world
 */
export function bodyIn(core, world) {
  const { solid, width, height } = solidOf(world);
  const { corners } = world.body;
  const walls = core.make("WgWalls", { solid: core.array(solid, "uint8_t"), width, height });
  const cosines = core.table("cosines", 8 * TURN, (at) => core.call("wg_body_cosines", at));
  const places = core.array(corners.flat().map(BigInt), "int64_t");
  const body = core.make("WgBody", { corners: places, count: corners.length, cosines });
  const found = core.zeros(8);
  const ask = (/** @type {string} */ name, /** @type {Pose} */ [x, y, heading], /** @type {number[]} */ ...more) => {
    const pose = core.make("WgBodyPose", { x, y, heading });
    core.check(name, walls, body, pose, ...more.map(BigInt), found);
    return core.view(found, 1, "int64_t")[0] === 1n;
  };
  return {
    /** A WgBody. */
    at: body,
    isClear: (/** @type {Pose} */ pose) => ask("wg_body_is_clear", pose),
    mayMove: (/** @type {Pose} */ pose, /** @type {number} */ x, /** @type {number} */ y) => ask("wg_body_may_move", pose, x, y),
    mayTurn: (/** @type {Pose} */ pose, /** @type {number} */ turn) => ask("wg_body_may_turn", pose, turn),
    /** Returns a lower bound of a path's clearance, lattice units. */
    clearance(/** @type {Pose[]} */ poses) {
      const rows = core.array(poses.flat().map(BigInt), "int64_t");
      core.check("wg_body_clearance", walls, body, rows, BigInt(poses.length), SLACK, found);
      return core.view(found, 1, "double")[0];
    },
    /** Decides whether it gets from a pose to the target. */
    search(/** @type {Pose} */ [x, y, heading], /** @type {LiveWorld} */ { target, headings, cell_size: side }) {
      const [from, following] = /** @type {[number, number]} */ (headings);
      const query = core.make("WgBodyQuery", {
        "start.x": x,
        "start.y": y,
        "start.heading": heading,
        target_x: float(inUnits(target[0], side)),
        target_y: float(inUnits(target[1], side)),
        target_radius: float(inUnits(target[2], side)),
        from_heading: from,
        headings: following,
        most_boxes: MOST_BOXES,
        wants_proof: 1,
      });
      core.check("wg_body_decide", walls, body, query);
      const answer = core.all(query, "WgBodyQuery");
      const columns = answer.outcome === core.constants.WG_BODY_REACHED ? 3 : 6;
      const numbers = Array.from(answer.count ? core.view(answer.rows, columns * answer.count, "int64_t") : [], Number);
      core.call("wg_body_free", query);
      const rows = Array.from({ length: answer.count }, (_, k) => numbers.slice(columns * k, columns * (k + 1)));
      const { outcome, clearance, boxes, finest_side, finest_turn } = answer;
      return { outcome, rows, clearance, boxes, finest: [finest_side, finest_turn] };
    },
  };
}

/**
 * Returns the poses of a body that follows a disc's path with its heading kept and turns at the end;
 * null if rounding the path to the lattice closed it.
 * @param {ReturnType<typeof bodyIn>} body
 * @param {LiveWorld} world
 * @param {Pose} start
 * @param {NonNullable<LiveProof["witness"]>} path
 */
function alongPath(body, world, start, path) {
  const { cell_size: side, target } = world;
  const places = path.x.map((x, k) => /** @type {Pose} */ ([Number(toLattice(x, side)), Number(toLattice(path.y[k], side)), start[2]]));
  const poses = places.filter((pose, k) => k === 0 || pose.some((value, axis) => value !== places[k - 1][axis]));
  for (const end of turnsTo(start[2], nearestOf(start[2], /** @type {[number, number]} */ (world.headings)))) {
    const [x, y] = poses[poses.length - 1];
    poses.push([x, y, end]);
  }
  const [x, y] = poses[poses.length - 1].map((value) => fraction(value));
  const away = add(square(sub(x, inUnits(target[0], side))), square(sub(y, inUnits(target[1], side))));
  if (isLess(square(inUnits(target[2], side)), away)) return null;
  const isClear = poses.slice(1).every((q, k) => {
    const p = poses[k];
    return p[2] === q[2] ? body.mayMove(p, q[0], q[1]) : body.mayTurn(p, modulo(q[2] - p[2] + TURN / 2) - TURN / 2);
  });
  return isClear ? poses : null;
}

/** @param {number} heading */
const modulo = (heading) => ((heading % TURN) + TURN) % TURN;

/**
 * Returns the nearest of some headings.
 * @param {number} heading
 * @param {[number, number]} headings the first, and how many follow
 */
function nearestOf(heading, [first, following]) {
  const ahead = modulo(heading - first);
  if (ahead <= following) return heading;
  const last = modulo(first + following);
  return modulo(heading - last) <= TURN - ahead ? last : first;
}

/**
 * Returns the headings at which the turns from one heading to another end; half a turn has two.
 * @param {number} start
 * @param {number} end
 */
function turnsTo(start, end) {
  if (start === end) return [];
  return modulo(end - start) === TURN / 2 ? [modulo(start + TURN / 4), end] : [end];
}

/**
 * @param {LiveWorld} world
 * @param {Pose[]} poses
 * @param {number} units clearance
 * @returns {LiveProof}
 */
function reachedBy(world, poses, units) {
  const { cell_size: side } = world;
  const room = ((units * side) / UNIT) * (1 - 1e-12);
  const points = poses.map(([x, y]) => ({ x: fraction(x), y: fraction(y) }));
  return proofOfPath(
    {
      t: timesOf(world, points),
      x: poses.map(([x]) => toMetres(x, side)),
      y: poses.map(([, y]) => toMetres(y, side)),
      heading: poses.map(([, , heading]) => headingFromLattice(heading)),
      clearance: room > 0 ? next(room, -1) : 0,
    },
    (length, clearance) => `a path of ${short(length)} m leaves the footprint ${short(clearance)} m to spare`,
  );
}
