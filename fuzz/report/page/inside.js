// What runs inside a controller in Python where it fails, and what a robot does by what is around it.

import { el, grouped } from "#player/dom.js";

/**
 * @param {ReportInside | null} inside
 * @returns {HTMLElement | null}
 */
export function insidePart(inside) {
  if (!inside) return null;
  const row = ([number, times, text]) =>
    el(
      "tr",
      { class: times === 0 ? "unused" : times === null ? "" : "ran" },
      el("td", { class: "times" }, times === null ? "" : times ? `${grouped(times)}\u00a0×` : "never"),
      el("td", { class: "times" }, number ? String(number) : ""),
      el("td", {}, text),
    );
  return el(
    "div",
    { class: inside.state.length ? "inside" : "" },
    inside.state.length ? statePart(inside) : null,
    el(
      "div",
      { class: "part" },
      el("h3", {}, `Lines of ${inside.file}, and how often each runs in ${inside.part}`),
      el("div", { class: "scroll" }, el("table", { class: "code" }, el("tbody", {}, inside.lines.map(row)))),
      note("Never runs there", inside.unused),
      note("Reads there, of what it senses", inside.reads),
    ),
  );
}

function note(words, names) {
  return names.length ? el("p", { class: "quiet" }, `${words}: ${names.join(", ")}.`) : null;
}

function statePart({ part, state }) {
  const item = ([name, words]) => el("li", {}, el("b", {}, name), ` ${words}`);
  return el("div", { class: "part" }, el("h3", {}, `Its state and what it senses in ${part}`), el("ul", { class: "state" }, state.map(item)));
}

/**
 * @param {[string, number, string, string][]} reactions
 * @param {string} title
 * @returns {HTMLElement | null}
 */
export function reactionsPart(reactions, title = "What it does by what is around it, in the whole run (steps at nearly the same pose count once)") {
  if (!reactions.length) return null;
  const head = ["What is around it", "Steps", "Turns in a step", "Moves"];
  const row = ([situation, steps, turns, moves]) =>
    el("tr", {}, el("th", { scope: "row" }, situation), el("td", { class: "times" }, grouped(steps)), el("td", {}, turns), el("td", {}, moves));
  return el(
    "div",
    { class: "part" },
    el("h3", {}, title),
    el(
      "div",
      { class: "scroll" },
      el(
        "table",
        { class: "reactions" },
        el("thead", {}, el("tr", {}, head.map((words) => el("th", { scope: "col" }, words)))),
        el("tbody", {}, reactions.map(row)),
      ),
    ),
  );
}
