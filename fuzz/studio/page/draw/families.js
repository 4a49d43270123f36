// The families as small pictures of the worlds that they make.

import { el } from "#player/dom.js";
import { drawSmall } from "#player/picture/map.js";
import { Ended } from "#studio/shared/connection.js";
import { Refused } from "#studio/shared/refusals.js";

/**
 * Makes the pictures, which are requested when they first become visible.
 * @param {Studio} studio
 * @param {(name: string) => void} choose
 * @returns {{element: HTMLElement, offer: () => void, redraw: () => void, choose: (name: string) =>
 *   void}}
 */
export function makeFamilies(studio, choose) {
  const element = el("div", { class: "families", role: "group", "aria-label": "Families" });
  /**
   * @type {Map<string, {button: HTMLElement, canvas: HTMLCanvasElement, world: DrawnWorld | null}>}
   */
  const shown = new Map();
  let asked = false;
  const draw = () => {
    for (const { canvas, world } of shown.values()) if (world && canvas.clientWidth > 0) drawSmall(canvas, { world, run: null, sensors: null }, { scale: false, numbers: false, witness: false });
  };
  const ask = async () => {
    if (asked || element.clientWidth === 0) return;
    asked = true;
    for (const [name, one] of shown) {
      try {
        one.world = await studio.connection.ask("preview", { family: name });
      } catch (error) {
        if (!(error instanceof Refused || error instanceof Ended)) throw error;
      }
      draw();
    }
  };
  new ResizeObserver(() => (asked ? draw() : ask())).observe(element);
  return {
    element,
    offer: () => {
      for (const { name } of studio.offered?.families ?? []) {
        const canvas = el("canvas", { "aria-hidden": "true" });
        const button = el("button", { type: "button", class: "family", "aria-pressed": "false", onclick: () => choose(name) }, canvas, name);
        shown.set(name, { button, canvas, world: null });
      }
      element.replaceChildren(...[...shown.values()].map(({ button }) => button));
      ask();
    },
    redraw: draw,
    choose: (name) => {
      for (const [other, { button }] of shown) button.setAttribute("aria-pressed", String(other === name));
    },
  };
}
