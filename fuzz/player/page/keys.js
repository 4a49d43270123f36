// Keyboard shortcuts of a player, and the dialog that lists them.

import { LAYERS, jumpTo, nextMark, playPeriod, stepBy, toggleFollow } from "#player/controls.js";
import { byId, el } from "#player/dom.js";

/**
 * Opens the page's dialog of shortcuts, <dialog id="keys" aria-labelledby="keys-title">.
 * @param {...Node} tables
 */
export function openKeys(...tables) {
  const dialog = byId("keys");
  dialog.replaceChildren(
    el(
      "div",
      { class: "line" },
      el("h2", { id: "keys-title" }, "Keys"),
      el("button", { type: "button", onclick: () => dialog.close() }, "Close"),
    ),
    ...tables,
  );
  dialog.showModal();
}

/**
 * Makes a table of rows [one key or several, what they do].
 * @param {KeyRow[]} rows
 * @returns {HTMLElement}
 */
export function keyTable(rows) {
  const row = ([keys, words]) => {
    const marks = [keys].flat().map((key) => [el("kbd", {}, key), " "]);
    return el("tr", {}, el("th", { scope: "row" }, marks), el("td", {}, words));
  };
  return el("table", {}, el("tbody", {}, rows.map(row)));
}

// whether the user last moved the focus by Tab, not by pointer;
// :focus-visible cannot tell, because any key makes it true
let tabbed = false;
addEventListener("keydown", ({ key }) => (tabbed ||= key === "Tab"), { capture: true });
addEventListener("pointerdown", () => (tabbed = false), { capture: true });

/**
 * Returns true if the focused element needs a key itself, such as a text field, a slider or a
 * button.
 * @param {HTMLElement} target
 * @param {string} key
 * @returns {boolean}
 */
export function keepsKey(target, key) {
  const isPressed = target.matches("button, a, summary, select, input[type=checkbox], input[type=radio]");
  // After a click, Space is free for the clock; after Tab and in a dialog, which moves the focus
  // itself, it presses what has the focus. A number has no spaces.
  if (key === " " && (isPressed || target.matches("input[type=range], input[type=number]")))
    return isPressed && (tabbed || target.closest("dialog") !== null);
  if (target.matches("input:not([type=range], [type=checkbox], [type=radio]), select, textarea")) return true;
  if (target.matches("input[type=range]")) return /^(Arrow|Home|End|Page)/.test(key);
  if (target.matches("input[type=radio]")) return /^(Enter|Arrow)/.test(key);
  return key === "Enter" && target.matches("button, a, summary, input");
}

/**
 * @param {Player} player
 * @returns {Keys}
 */
export function cameraKeys(player) {
  const nearer = () => player.zoom(1.4);
  return { "+": nearer, "=": nearer, "-": () => player.zoom(1 / 1.4), 0: () => player.fit() };
}

/**
 * @param {Player} player
 * @returns {Keys}
 */
export function layerKeys(player) {
  const toggle = (name) => () => player.reveal(name, !player.show[name]);
  return Object.fromEntries(Object.entries(LAYERS).map(([name, [, key]]) => [key, toggle(name)]));
}

/**
 * @param {Player} player
 * @param {number} steps
 * @returns {Keys}
 */
export function clockKeys(player, steps) {
  if (!player.drawn.run) return {};
  return {
    " ": () => player.play(!player.playing),
    ArrowLeft: () => stepBy(player, -steps),
    ArrowRight: () => stepBy(player, steps),
    Home: () => jumpTo(player, 0),
    End: () => jumpTo(player, player.last),
    r: () => toggleFollow(player),
    z: () => player.event(),
    e: () => nextMark(player),
    l: () => playPeriod(player),
    ">": () => player.zoomTime?.(2),
    "<": () => player.zoomTime?.(1 / 2),
    "|": () => player.zoomTime?.(0),
  };
}
