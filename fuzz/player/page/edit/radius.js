// The robot's radius: a slider in hundredths of a cell, and a number.

import { el } from "#player/dom.js";
import { round } from "#player/edit/model.js";

/**
 * Makes a slider for the robot's radius.
 * @param {() => import("#player/edit/model.js").Model | undefined} model
 * @param {Record<string, any>} [more] - Attributes
 * @returns {{input: HTMLInputElement, refresh: () => void}}
 */
export function radiusSlider(model, more = {}) {
  const input = el("input", {
    type: "range",
    step: "any",
    min: 0,
    "aria-label": "Robot radius",
    ...more,
    oninput: () => {
      const cell = model()?.world.cell_size ?? 1;
      setRadius(model(), Math.max(cell / 100, Math.round((input.valueAsNumber / cell) * 100) * (cell / 100)));
    },
  });
  return {
    input,
    refresh: () => {
      const world = model()?.world;
      if (!world) return;
      input.max = String(Math.max(2.5 * world.cell_size, 1.2 * world.robot_radius));
      input.value = String(world.robot_radius);
      input.setAttribute("aria-valuetext", `${world.robot_radius} m`);
    },
  };
}

function setRadius(model, value) {
  if (model && value > 0 && value !== model.world.robot_radius) model.change("radius", { robot_radius: round(value) }, true);
}

/**
 * Makes a labelled slider and a number for the robot's radius.
 * @param {() => import("#player/edit/model.js").Model | undefined} model
 * @returns {{element: HTMLElement, refresh: () => void}}
 */
export function radiusField(model) {
  const slider = radiusSlider(model);
  const number = el("input", { type: "number", min: 0, step: "any", "aria-label": "Robot radius, m", onchange: () => setRadius(model(), number.valueAsNumber) });
  return {
    element: el("div", { class: "radius-field" }, el("span", { class: "quiet" }, "Radius"), slider.input, number, el("span", { class: "quiet" }, "m")),
    refresh: () => {
      slider.refresh();
      if (document.activeElement !== number) number.value = String(model()?.world.robot_radius ?? "");
    },
  };
}
