// The robots of a scene: of each its ends in the world, its run, where it is now, and its colours.

import { openRun, poseAt, rowAt, stepWithin } from "#player/decode.js";
import { MARKS } from "#player/picture/marks.js";
import { robotColour } from "#player/picture/pen.js";

/**
 * Returns start, target and body of each robot of a world, with its number if there are several.
 * @param {SceneWorld} world
 * @returns {SceneEnds[]}
 */
export function endsOf(world) {
  const { start, target, radius, footprint, aim, waypoints, others } = world;
  const first = { start, target, radius, footprint, aim, waypoints };
  if (!others?.length) return [{ ...first, number: null }];
  return [first, ...others].map((ends, k) => ({ ...ends, number: k + 1 }));
}

/**
 * Returns what is drawn of each run, those in front last.
 * @param {RunScene} scene
 * @returns {SceneRobot[]}
 */
export function drivenIn(scene) {
  const { world, run, step, number, others = [] } = scene;
  return [...others.map((other) => ({ ...other, isFront: false })), { run, number: number ?? null, isFront: true }].map((one) => {
    // The robots of one world have bodies of their own, several runs of one robot have its.
    const ends = (world.others?.length && one.number ? [world, ...world.others][one.number - 1] : null) ?? world;
    const now = (step * run.dt) / one.run.dt,
      open = openRun(one.run);
    const since = one.run.loop ? one.run.loop[0] : scene.whole ? staysFrom(one.run) : null,
      entry = since === null ? open.at.length : rowAt(one.run, since);
    return {
      ...one,
      open,
      entry,
      step: now,
      radius: ends.radius,
      footprint: ends.footprint,
      pose: poseAt(one.run, stepWithin(one.run, now)),
      until: scene.whole ? open.at.length : rowAt(one.run, Math.min(now, one.run.steps)) + 1,
      isDriving: !scene.whole && now <= one.run.steps,
    };
  });
}

/**
 * Returns from which step on a run without a proved period is drawn as staying where it is: its
 * second half, if that reaches nothing new; else null.
 * @param {DrawnRun} run
 * @returns {number | null}
 */
export function staysFrom(run) {
  const last = run.marks.find(({ kind }) => kind === "stays"),
    half = Math.floor(run.steps / 2);
  return !run.loop && last && last.step <= half ? half : null;
}

/**
 * Returns the colour of a mark of a robot: its own, if there are several.
 * @param {Pen} pen
 * @param {string} name
 * @param {number | null} number
 * @returns {string}
 */
export const colourOf = (pen, name, number) => pen.colours[number ? robotColour(number) : MARKS[name].colour];
