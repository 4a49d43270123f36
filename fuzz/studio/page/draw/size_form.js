// The size of the world: make a new one, resize this one, or remove its walls.

import { el, grouped, plural } from "#player/dom.js";
import { labelled, number } from "#studio/shared/fields.js";
import { bordered, emptyWorld, resized } from "#player/edit/model.js";

/** @type {[string, number][]} */
const ACROSS = [
  ["left", 0],
  ["middle", 0.5],
  ["right", 1],
];
/** @type {[string, number][]} */
const UP = [
  ["Upper", 1],
  ["Middle", 0.5],
  ["Lower", 0],
];

/**
 * Makes the form; its fields become parts.width and parts.height.
 * @param {Studio} studio
 * @param {any} draw
 * @param {Record<string, any>} parts
 * @returns {HTMLElement}
 */
export function sizePart(studio, draw, parts) {
  const { model } = studio;
  const whole = () => number(40, () => {}, { low: 1, step: 1 });
  const said = el("p", { role: "status", class: "quiet", id: "size-said" }),
    anchor = { kept: [0, 0] };
  parts.width = whole();
  parts.height = whole();
  const say = (words, kind = "quiet") => {
    said.className = kind;
    said.textContent = words;
  };
  const sized = (act) => () => {
    const [width, height] = [parts.width, parts.height].map((input) => input.valueAsNumber);
    const fault = sizeFault(width, height, studio.limits);
    say(fault, fault ? "bad" : "quiet");
    if (fault) return;
    draw.board.view = draw.board.selection = null;
    act(width, height);
  };
  const button = (words, help, act) => el("button", { type: "button", title: help, onclick: act }, words);
  return el(
    "div",
    {},
    el(
      "div",
      { class: "pair-fields" },
      labelled("Columns", parts.width, { unit: "cells" }),
      labelled("Rows", parts.height, { unit: "cells" }),
    ),
    anchorPart(anchor),
    el(
      "div",
      { class: "actions" },
      button("New", "An empty world of this size", sized((width, height) => newWorld(model, width, height, say))),
      button("Resize", "Keep the drawing; cut off or add cells outside the part that stays in place", sized((width, height) =>
        resize(model, width, height, anchor.kept, say),
      )),
      button("Clear", "Remove all walls except the border, and all changes", () => clear(model, say)),
    ),
    said,
  );
}

/**
 * Return what is wrong with a size; empty if nothing is.
 * @param {number} width
 * @param {number} height
 * @param {Limits | null} limits
 * @returns {string}
 */
function sizeFault(width, height, limits) {
  if (!limits) return "The studio does not answer yet; try again in a moment.";
  const { side: longest, cells } = limits;
  const is = (side) => Number.isInteger(side) && side >= 1 && side <= longest;
  if (is(width) && is(height) && width * height <= cells) return "";
  return `Columns and rows must be 1 to ${grouped(longest)} each, with at most ${grouped(cells)} cells in total.`;
}

// Makes the field that chooses which part of the drawing stays in place when the size changes.
function anchorPart(anchor) {
  const radio = ([row, up], [column, across]) =>
    el("input", {
      type: "radio",
      name: "anchor",
      value: `${across} ${up}`,
      "aria-label": `${row} ${column}`.replace("Middle middle", "Middle"),
      title: `${row} ${column}`.replace("Middle middle", "Middle"),
      checked: across === 0 && up === 0,
      onchange: () => {
        anchor.kept = [across, up];
      },
    });
  return el(
    "fieldset",
    { class: "anchor" },
    el("legend", {}, "When resizing, keep this part in place"),
    el("div", { class: "nine" }, UP.map((row) => ACROSS.map((column) => radio(row, column)))),
  );
}

function newWorld(model, width, height, say) {
  const changes = changesOf(model);
  model.change("new world", emptyWorld(width, height, model.world));
  say(lost(changes, 0));
}

function resize(model, width, height, kept, say) {
  const changes = changesOf(model);
  model.change("resize", resized(model.world, width, height, kept));
  say(lost(changes, changesOf(model)));
}

function clear(model, say) {
  const changes = changesOf(model),
    { width, height } = model.world;
  model.change("clear", { cells: bordered(width, height), events: null });
  say(lost(changes, 0));
}

const changesOf = ({ world }) => (world.events ? world.events.times.length : 0);

// Reports lost events, because nothing else on the page does.
function lost(before, after) {
  if (before === after) return "";
  const words = after === 0 ? "The world no longer changes" : `${plural(before - after, "change")} ${before - after === 1 ? "was" : "were"} outside`;
  return `${words}: undo restores its ${before} changes.`;
}
