// The collapsed part of the form that starts a campaign: options of `worldgen fuzz`, with the
// command's help texts.

import { choice, el } from "#player/dom.js";
import { labelled } from "#studio/shared/fields.js";

const SHRINK = { usual: "default", yes: "yes", no: "no" };

/**
 * Makes this part of the form; `robots` is its field for the number of robots, and `filled` returns its values.
 * @param {Offered} offered
 * @param {Limits} limits
 */
export function makeMore({ options }, limits) {
  const text = (name, placeholder) => el("input", { type: "text", name, autocomplete: "off", placeholder });
  const whole = (name, high) => el("input", { type: "number", name, min: 1, max: high, step: 1, placeholder: options[`--${name}`].default });
  const inputs = {
    robots: el("input", { type: "number", name: "robots", min: 1, max: limits.fleet, step: 1, placeholder: "1", title: options["--robots"].help }),
    time_step: el("input", { type: "number", name: "time-step", min: limits.time_steps[0], max: limits.time_steps[1], step: "any", placeholder: "default" }),
    examples: whole("examples", limits.examples),
    epoch: whole("epoch", limits.epoch),
    oracles: text("oracle", "turn detour=5"),
    vary: text("vary", "robot_speed=1,2 robot_radius=0.1,0.2"),
    baseline: text("baseline", "none"),
    shrink: choice(Object.entries(SHRINK), "usual", () => {}),
  };
  inputs.baseline.setAttribute("list", "campaign-folders");
  const list = el("datalist", { id: "campaign-folders" });
  const one = (name, option, words, more = {}) => labelled(words, inputs[name], { help: `${option}: ${options[option].help}`, ...more });
  const element = el(
    "details",
    { class: "more" },
    el("summary", {}, "More"),
    el("div", { class: "pair-fields" }, labelled("Time step", inputs.time_step, { unit: "s" }), labelled("Worlds per unit", inputs.examples)),
    one("oracles", "--oracle", "Oracles", { unit: "separated by spaces" }),
    one("vary", "--vary", "Vary", { unit: "separated by spaces" }),
    one("shrink", "--shrink", "Shrink"),
    one("epoch", "--epoch", "Epoch", { unit: "units" }),
    one("baseline", "--baseline", "Also known", { unit: "folders, separated by spaces" }),
    el("p", { class: "quiet small-print" }, "Only available at a terminal: --scheduler, and files for CI. Use Copy command and add them to the command."),
    list,
  );
  const entries = Object.entries(inputs);
  return {
    element,
    robots: labelled("Robots", inputs.robots),
    filled: () => filled(inputs),
    timeStep: (value) => (inputs.time_step.value = value ?? ""),
    offer: (folders) => list.replaceChildren(...folders.map((name) => el("option", { value: name }))),
    written: () => Object.fromEntries(entries.map(([name, { value }]) => [name, value])),
    write: (values) => entries.forEach(([name, input]) => Object.hasOwn(values, name) && (input.value = values[name])),
  };
}

// Returns the values for the protocol; null for defaults.
function filled(inputs) {
  const listed = ({ value }) => value.split(/\s+/).filter(Boolean);
  const given = ({ valueAsNumber: value }) => (Number.isFinite(value) ? value : null);
  const { shrink } = inputs;
  return {
    robots: given(inputs.robots),
    time_step: given(inputs.time_step),
    examples: given(inputs.examples),
    epoch: given(inputs.epoch),
    oracles: listed(inputs.oracles),
    vary: listed(inputs.vary),
    baseline: listed(inputs.baseline),
    shrink: shrink.value === "usual" ? null : shrink.value === "yes",
  };
}
