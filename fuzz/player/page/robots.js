// Several robots in one world: which one is in front, the result of each,
// the instruments of the one in front.

import { behaviourAt, poseAt, rowAt, stepWithin } from "#player/decode.js";
import { breakable, el, grouped, shortName, verdictSign } from "#player/dom.js";
import { memoryFacts } from "#player/picture/memory.js";
import { robotColour } from "#player/picture/pen.js";

/**
 * Returns what the player draws with one robot in front of the others; colours follow the order of
 * the list.
 * @param {DrawnWorld} world
 * @param {Robot[]} robots
 * @param {number} number
 * @returns {Drawn}
 */
export function sceneOf(world, robots, number) {
  return { ...runsOf(world, robots, number), says: robots.map((one) => `${shortName(one.name)}: ${endingOf(one)}`) };
}

function runsOf(world, robots, number) {
  const front = robots[number];
  // In a world with several robots, each entry has all of them.
  if (front.others?.length)
    return { world, run: front.run, sensors: front.sensors, number: 1, others: front.others };
  const alone = robots.filter((one) => one.run).length === 1;
  return {
    world,
    run: front.run,
    sensors: front.sensors,
    number: alone ? null : number + 1,
    others: robots.flatMap(({ run }, k) => (run && k !== number ? [{ run, number: k + 1 }] : [])),
  };
}

/**
 * Describes how a robot's run ended, on one line.
 * @param {Robot} robot
 */
export const endingOf = (robot) => robot.error || [robot.verdict, robot.why].filter(Boolean).join(" ");

/**
 * Shows where the user's code failed: file, line, function and statement, innermost frame last.
 * @param {Frame[]} [frames]
 * @returns {HTMLElement | null}
 */
export function framesPart(frames = []) {
  if (frames.length === 0) return null;
  const place = ({ file, line, function: name }) => [el("b", {}, `${file}:${line}`), name ? ` in ${name}` : ""];
  const row = (frame) => el("span", { class: "frame" }, place(frame), frame.code ? el("code", {}, frame.code) : null);
  return el("span", { class: "frames" }, frames.map(row));
}

/**
 * Lists the robots with their results, and a note for each that did not arrive; a click puts one in
 * front.
 * @param {HTMLElement} list
 * @param {Robot[]} robots
 * @param {number} looked
 * @param {(number: number) => void} look
 * @param {string} [note]
 */
export function showRobots(list, robots, looked, look, note = "") {
  const row = (one, number) => {
    const chip = robots.length > 1 ? el("span", { class: `chip ${robotColour(number + 1)}` }, String(number + 1)) : null;
    if (one.error)
      return el("li", { class: "failed" }, el("span", { class: "who", title: one.name }, chip, " ", el("b", {}, breakable(shortName(one.name))), " ", el("span", { class: "bad" }, "did not run")), el("p", { class: "bad" }, one.error), framesPart(one.frames));
    const facts = [`${grouped(one.steps)} steps, `, el("span", { class: "time" }, `${one.time.toFixed(3)} s, `), `${one.path.toFixed(2)} m, ${one.collisions} collisions`];
    return el(
      "li",
      { "aria-current": number === looked ? "true" : null },
      el(
        "button",
        { type: "button", class: "result", "data-controller": one.name, onclick: () => look(number) },
        el("span", { class: "who", title: one.name }, chip, " ", el("b", {}, breakable(shortName(one.name))), " ", verdictSign(one.verdict), " ", el("span", {}, one.verdict), " ", el("code", { class: "digest", title: "Digest of every state of the run" }, one.digest)),
        el("span", { class: "quiet facts" }, facts),
        one.verdict === "reached" ? null : el("span", { class: "why" }, one.why),
        framesPart(one.frames),
        one.verdict === "reached" || !note ? null : el("span", { class: "note" }, note),
      ),
    );
  };
  list.replaceChildren(...robots.map(row));
}

const DEGREES = 180 / Math.PI;

/**
 * Shows the readings of the robot's instruments at this time.
 * @param {HTMLElement} line
 * @param {Player} player
 */
export function showInstruments(line, player) {
  const { run, world } = player.drawn;
  if (!run) return;
  const step = stepWithin(run, player.step),
    pose = poseAt(run, step),
    side = world.cell;
  const behaviour = behaviourAt(run, rowAt(run, step));
  const heading = (((pose.heading * DEGREES) % 360) + 360) % 360;
  const facts = [
    ["time", `${(player.step * run.dt).toFixed(3)} s`],
    ["x, y", `${(pose.x * side).toFixed(3)}, ${(pose.y * side).toFixed(3)} m`],
    ["heading", `${heading.toFixed(1)}°`],
    ["collision", pose.bump ? "yes" : "no"],
    ...(behaviour === null ? [] : [["behaviour", behaviour]]),
    ...memoryFacts(run, step),
  ];
  const shown = facts.map(([name, value]) => fact(name, value));
  if (run.loop) shown.push(fact("loop", loopWords(run.loop, step), "wide"));
  line.replaceChildren(...shown);
}

/**
 * @param {string} name
 * @param {string} value
 * @param {string | null} [kind]
 */
const fact = (name, value, kind = null) => el("span", { class: kind, title: `${name} ${value}` }, el("span", {}, `${name} `), el("b", {}, value));

const loopWords = ([entry, period], step) =>
  step < entry ? `begins at step ${grouped(entry)}` : `period ${grouped(period)}, step ${Math.floor(step - entry)} of it`;
