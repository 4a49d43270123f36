// The legend of a player: the marks in its picture, described as in the static pictures.

import { BURNING, SOLID, openRun, openWorld } from "#player/decode.js";
import { el } from "#player/dom.js";
import { hasMap } from "#player/picture/memory.js";
import { robotColour } from "#player/picture/pen.js";

const NAMED = ["named", "cell named in the text"];
const TOUCHED = ["square touched", "wall touched"];

/**
 * Returns the marks that are drawn, as pairs of a class and a description.
 * @param {Drawn} drawn
 * @returns {[string, string][]}
 */
function marksOf({ world, run, others, number, named }) {
  const { events } = openWorld(world),
    happens = new Set(events?.state ?? []);
  const several = (others ?? []).length > 0;
  const all = [{ run, number: number ?? 1 }, ...(others ?? [])];
  const looping = all.find((one) => one.run?.loop);
  /** @type {(string[] | false)[]} */
  const marks = [
    ["start", "start; the tick is its heading"],
    ["target", "target"],
    several && ["chip-mark", "each robot has its number and colour"],
    !several && run !== null && run.loop !== null && ["way", "the path into the loop"],
    !several && run !== null && ["loop", run.loop ? "the period, repeated forever" : "the robot's path"],
    several && looping !== undefined && [`${robotColour(looping.number)} thick`, "its period, repeated forever"],
    several && all.some((one) => one.run?.blocked_by?.length) && ["blocked", "is blocked by"],
    run !== null && [ "ahead", "still to be driven"],
    run !== null && TOUCHED,
    run !== null && run.marks.some(({ cell }) => cell) && ["square pierced", "wall entered, or cell that did harm"],
    Boolean(named?.length) && NAMED,
    hasMap(run) && ["memory", "the robot's own map"],
    happens.has(BURNING) && ["square fire", "burning"],
    happens.has(BURNING) && ["square burnt", "burnt floor"],
    (happens.has(BURNING) || happens.has(SOLID)) && ["square burns", "changes later (c)"],
    world.cut ? ["cut", "the cut that separates start and target"] : openWorld(world).witness ? ["witness", "a path for this robot (w)"] : false,
  ];
  return /** @type {[string, string][]} */ (marks.filter(Boolean));
}

/**
 * Makes the legend, which can be closed.
 * @param {Drawn} drawn
 * @returns {HTMLElement}
 */
export function legendOf(drawn) {
  return el("details", { class: "legend-part", open: true }, el("summary", {}, "Legend"), listOf(marksOf(drawn)));
}

/**
 * Makes the legend of a small picture: the cells that its text is about.
 * @param {Pick<DrawnFailure, "run" | "named">} drawn
 * @returns {HTMLElement}
 */
export const legendOfCells = ({ run, named }) =>
  listOf([...(run && openRun(run).bump.some(Boolean) ? [TOUCHED] : []), ...(named?.length ? [NAMED] : [])]);

const listOf = (marks) => el("ul", { class: "legend" }, marks.map(([name, words]) => el("li", {}, el("i", { class: name }), words)));
