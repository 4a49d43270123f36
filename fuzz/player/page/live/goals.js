// Decides a static world for all goals of its robot: worldgen/reach/deciding.py.

import { proveCar } from "#player/live/car.js";
import { proveBody } from "#player/live/body.js";
import { prove, undecided } from "#player/live/prove.js";
import { proofOfPath, short } from "#player/live/witness.js";

/** @typedef {import("#player/live/core.js").Core} Core */
/** @typedef {NonNullable<LiveProof["witness"]>} Witness */

/**
 * Decides a world for its robot; a car is only stopped by what stops its body.
 * @param {Core} core the prover
 * @param {LiveWorld} world
 * @param {() => Promise<void>} pause throws if a newer question has come
 * @returns {Promise<LiveProof>}
 */
export async function proveGoals(core, world, pause) {
  const legs = legsOf(core, world, pause);
  if (!world.car) return world.waypoints ? legs.decide() : legs.from(0, null);
  return (await legs.firstBlocked(0)) ?? proveCar(core, { ...world, car: world.car }, pause);
}

/**
 * The legs of a robot: from its start to its first goal, and so on.
 * @param {Core} core
 * @param {LiveWorld} world
 * @param {() => Promise<void>} pause
 */
function legsOf(core, world, pause) {
  const goals = [...(world.waypoints ?? []), { target: world.target, headings: world.headings }];
  const own = goals.length - 1;
  const words = (/** @type {number} */ number) => {
    const [x, y] = goals[number].target;
    const what = number < own ? `waypoint ${number + 1} of ${own}` : "the target";
    return `${what}, at (${short(x, 6)}, ${short(y, 6)})`;
  };

  /**
   * Decides a leg, which begins where a path ends.
   * @param {number} number
   * @param {Witness | null} path
   */
  function from(number, path) {
    const end = path ? path.t.length - 1 : 0;
    /** @type {Triple} */
    const start = path ? [path.x[end], path.y[end], path.heading?.[end] ?? world.start[2]] : world.start;
    const leg = { ...world, ...goals[number], start, waypoints: undefined };
    return leg.body ? proveBody(core, { ...leg, body: leg.body }, pause) : prove(core, leg, pause);
  }

  /**
   * Returns a proof about a goal; if the goal cannot be reached, the proof names it.
   * @param {number} number
   * @param {LiveProof} found
   * @returns {LiveProof}
   */
  function named(number, found) {
    if (found.reachable || own === 0) return found;
    const cut = found.cut && number < own ? { ...found.cut, waypoint: number + 1 } : found.cut;
    return { ...found, cut, reason: `${words(number)}: ${found.reason}` };
  }

  const fromStart = async (/** @type {number} */ number) => named(number, await from(number, null));

  /**
   * Returns the proof about the first goal, from one on, that is cut off from the start.
   * @param {number} first
   */
  async function firstBlocked(first) {
    for (let number = first; number <= own; number++) {
      const found = await fromStart(number);
      if (found.reachable === false) return found;
    }
    return null;
  }

  /**
   * Decides a leg again that has no path from where the one before ends: another path returns to
   * the start first, which any path of a static world allows.
   * @param {number} number
   * @param {Witness | null} path
   * @param {LiveProof} leg
   */
  async function again(number, path, leg) {
    let found = named(number, leg);
    if (path) {
      found = await fromStart(number);
      if (found.witness) return { ...found, witness: joined(reversed(path), found.witness) };
    }
    if (found.reachable === false) return found;
    const later = await firstBlocked(number + 1);
    if (later || found.reachable === null) return later ?? found;
    return undecided(`${words(number)}, from where the path before it ends: ${leg.reason}`);
  }

  async function decide() {
    /** @type {Witness | null} */
    let path = null;
    for (let number = 0; number <= own; number++) {
      let leg = await from(number, path);
      if (!leg.witness) leg = await again(number, path, leg);
      if (!leg.witness) return leg;
      path = joined(path, leg.witness);
    }
    const whole = /** @type {Witness} */ (path);
    return proofOfPath(whole, (length, room) => `a path of ${short(length)} m leads to all goals in order, with a clearance of ${short(room)} m`);
  }

  return { decide, from, firstBlocked };
}

/**
 * Returns a path with a leg behind it, which begins where the path ends.
 * @param {Witness | null} path
 * @param {Witness} leg
 * @returns {Witness}
 */
function joined(path, leg) {
  if (!path) return leg;
  const last = path.t[path.t.length - 1];
  return {
    t: [...path.t, ...leg.t.slice(1).map((time) => last + time)],
    x: [...path.x, ...leg.x.slice(1)],
    y: [...path.y, ...leg.y.slice(1)],
    ...(path.heading && leg.heading ? { heading: [...path.heading, ...leg.heading.slice(1)] } : {}),
    clearance: Math.min(path.clearance, leg.clearance),
  };
}

/**
 * @param {Witness} path
 * @returns {Witness}
 */
function reversed(path) {
  const last = path.t[path.t.length - 1];
  const back = (/** @type {number[]} */ column) => column.slice().reverse();
  return {
    t: back(path.t).map((time) => last - time),
    x: back(path.x),
    y: back(path.y),
    ...(path.heading ? { heading: back(path.heading) } : {}),
    clearance: path.clearance,
  };
}
