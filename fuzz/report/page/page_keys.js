// The keyboard shortcuts.

import { byId } from "#player/dom.js";
import { cameraKeys, clockKeys, keepsKey, keyTable, layerKeys, openKeys } from "#player/keys.js";

/** @type {KeyRow[]} */
const KEYS = [
  [["?"], "Show these keys"],
  [["/"], "Find"],
  [["d"], "Dark or light"],
  [["←", "→", "↑", "↓", "Enter"], "Choose a failure; open it"],
  [["Esc"], "Back to all failures"],
  [["n", "p"], "Next, previous failure"],
  [["Space"], "Play, pause"],
  [["←", "→"], "One step; with Shift ten"],
  [["Home", "End"], "Go to the start, to the end"],
  [["l"], "Play one period of a loop repeatedly"],
  [["e"], "Go to the next marked step: entry, breach, last new cell"],
  [["b"], "Before or after shrinking"],
  [["+", "−", "0"], "Zoom; show the whole world"],
  [["r", "z"], "Follow the robot; zoom to what happens"],
  [["t", "u", "s", "i", "m", "w"], "Trail, touched walls, sensors, signal, the robot's memory, witness"],
];

export function showKeys() {
  openKeys(keyTable(KEYS));
}

/**
 * Returns the keyboard listener of a page; `neighboursOf` returns the failures before and after
 * one.
 * @param {{id: string, detail: Detail | null}} page
 * @param {(id: string) => Neighbours} neighboursOf
 * @returns {(event: KeyboardEvent) => void}
 */
export function keyListener(page, neighboursOf) {
  return (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || byId("keys").open) return;
    const { key } = event;
    const target = /** @type {HTMLElement} */ (event.target);
    if (key === "Escape" && target.matches("input[type=search], select")) target.blur();
    if (keepsKey(target, key)) return;
    const act = pageKeys()[key] || (page.detail && detailKeys(event, page.detail, neighboursOf(page.id))[key]);
    if (!act) return;
    event.preventDefault();
    act();
  };
}

function pageKeys() {
  return {
    "?": showKeys,
    d: () => byId("theme").click(),
    "/": () => {
      location.hash = "";
      setTimeout(() => byId("find")?.focus());
    },
  };
}

/**
 * @param {KeyboardEvent} event
 * @param {Detail} detail
 * @param {Neighbours} neighbours
 * @returns {Keys}
 */
function detailKeys(event, detail, [before, after]) {
  const player = detail.player();
  const keys = {
    Escape: () => openAddress(""),
    n: () => openAddress(after),
    p: () => openAddress(before),
    b: () => detail.swap(),
  };
  if (player) Object.assign(keys, cameraKeys(player));
  if (player && player.drawn.run) Object.assign(keys, layerKeys(player), clockKeys(player, event.shiftKey ? 10 : 1));
  return keys;
}

function openAddress(id) {
  if (id !== undefined) location.hash = id;
}
