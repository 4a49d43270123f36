// Several robots in one world: which is in front, what became of each, what the instruments of that one say.

import { behaviourAt, poseAt, rowAt, stepWithin } from "./decode.js";
import { el, grouped, verdictDot } from "./dom.js";

// What the player draws with one robot in front of the others; each has its colour by its place in the list.
export function sceneOf(world, robots, number) {
  const front = robots[number];
  const alone = robots.filter((one) => one.run).length === 1;
  const colour = (k) => `robot-${k % 6}`;
  return {
    world,
    run: front.run,
    sensors: front.sensors,
    colour: alone ? null : colour(number),
    others: robots.map((one, k) => ({ run: one.run, colour: colour(k) })).filter((one, k) => k !== number && one.run),
  };
}

// The list of robots with their results; a click puts one in front.
export function showRobots(list, robots, looked, look) {
  const row = (one, number) => {
    const chip = robots.length > 1 ? el("i", { class: `chip robot-${number % 6}` }) : null;
    if (one.error) return el("li", {}, chip, el("b", {}, one.name), el("p", { class: "bad" }, one.error));
    const facts = `${grouped(one.steps)} steps, ${one.time.toFixed(3)} s, ${one.path.toFixed(2)} m, ${one.collisions} collisions`;
    return el(
      "li",
      { "aria-current": number === looked ? "true" : null },
      el(
        "button",
        { type: "button", class: "result", "data-controller": one.name, onclick: () => look(number) },
        el("span", { class: "who" }, chip, el("b", {}, one.name), verdictDot(one.verdict), el("span", {}, one.verdict)),
        el("span", { class: "quiet" }, facts),
        one.verdict === "reached" ? null : el("span", {}, one.words.replace(/^\w+\s*/, "")),
        el("code", { class: "digest", title: "Digest of every state of the run" }, one.digest),
      ),
    );
  };
  list.replaceChildren(...robots.map(row));
}

const DEGREES = 180 / Math.PI;

// What the robot's own instruments would say at this time.
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
    ...(run.loop && step >= run.loop[0]
      ? [["loop", `period ${grouped(run.loop[1])}, step ${Math.floor(step - run.loop[0])} of it`]]
      : []),
  ];
  line.replaceChildren(...facts.map(([name, value]) => el("span", {}, `${name} `, el("b", {}, value))));
}
