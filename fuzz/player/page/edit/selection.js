// Actions on the selected rectangle, or on the current stamp.

import { flipped, mirrored, patternIn, turned } from "#player/edit/shapes.js";

/** The actions on the selection; each is one step of the history. */
export const SELECTION = {
  copy: ["Copy", "Ctrl+C"],
  cut: ["Cut", "Ctrl+X"],
  paste: ["Paste", "Ctrl+V"],
  mirror: ["Mirror left and right", "x", "↔"],
  flip: ["Mirror up and down", "y", "↕"],
  turn: ["Turn left", ".", "↺"],
  fill: ["Fill", "Enter"],
  clear: ["Clear", "Delete"],
};

/**
 * Applies an action to the selection; with the stamp tool, turns and mirrors apply to the stamp.
 * @param {any} kit
 * @param {string} what
 * @param {boolean} stamping
 * @returns {boolean}
 */
export function withSelection(kit, what, stamping) {
  const { board, model } = kit,
    changes = { mirror: mirrored, flip: flipped, turn: turned };
  if (what === "paste") return kit.clipboard !== null;
  if (stamping && what in changes) {
    kit.turns.push(changes[what]);
    return true;
  }
  const box = board.selection;
  if (!box) return false;
  const pattern = patternIn(model.world, box);
  if (what === "copy" || what === "cut") kit.clipboard = pattern;
  if (what === "cut" || what === "clear") model.paint([box], 0);
  if (what === "fill") model.paint([box], 1);
  if (what in changes) {
    const made = changes[what](pattern);
    model.paint([box], 0);
    model.put(made, [box.x, box.y]);
    board.selection = { x: box.x, y: box.y, width: made.width, height: made.height };
  }
  if (what !== "copy") model.lift(what);
  kit.said(`${SELECTION[what][0]}: ${box.width} x ${box.height} cells`);
  board.draw();
  return true;
}
