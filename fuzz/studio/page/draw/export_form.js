// Exports the drawing: format, options, and destination of the file.

import { bytesOf } from "#player/decode.js";
import { choice, el } from "#player/dom.js";
import { keep } from "#player/saving.js";
import { checkOptions, labelled, optionFields } from "#studio/shared/fields.js";
import { messageOf } from "#studio/shared/world_message.js";
import { Refused } from "#studio/shared/refusals.js";

/**
 * Makes the form.
 * @param {Studio} studio
 * @param {(act: () => Promise<string | void>) => Promise<void>} trying - Runs an action that the
 *   server may refuse, and shows the result
 * @param {() => void} wrote - Called after files have been written to the folder
 * @returns {{element: HTMLElement, refresh: () => void}}
 */
export function makeExport(studio, trying, wrote) {
  const form = { studio, format: null, given: {} };
  const parts = { formats: el("div"), options: el("div") };
  const run = (inFolder) => trying(() => exportAs(form, parts, inFolder, wrote));
  const element = el(
    "div",
    {},
    parts.formats,
    morePart(parts),
    el(
      "div",
      { class: "actions" },
      el("button", { type: "button", onclick: () => run(false) }, "Download"),
      el("button", { type: "button", onclick: () => run(true) }, "Save to the folder"),
    ),
  );
  return { element, refresh: () => refresh(form, parts) };
}

function morePart(parts) {
  const number = (id, low) => el("input", { type: "number", step: "any", min: low, id, placeholder: "as imported" });
  parts.at = number("export-at", 0);
  parts.x = number("export-x", null);
  parts.y = number("export-y", null);
  parts.sidecar = el("input", { type: "checkbox", id: "export-sidecar", checked: true });
  parts.time = labelled("At the time", parts.at, { unit: "s", help: "Export the cells at this time only." });
  return el(
    "details",
    { id: "export-more" },
    el("summary", {}, "Format options"),
    parts.options,
    parts.time,
    el(
      "fieldset",
      { class: "triple two" },
      el("legend", {}, "Origin in the file"),
      labelled("x", parts.x, { unit: "m" }),
      labelled("y", parts.y, { unit: "m" }),
    ),
    labelled("Sidecar", parts.sidecar, { help: "Write what the format cannot store to a second file next to it." }),
  );
}

function refresh(form, parts) {
  if (!form.format && form.studio.offered) {
    const written = form.studio.offered.formats.filter((format) => format.writes);
    const list = choice(
      written.map(({ name, about }) => [name, `${name}: ${about}`]),
      written[0].name,
      (event) => chooseFormat(form, parts, written.find(({ name }) => name === event.target.value)),
    );
    parts.formats.replaceChildren(labelled("Export as", list));
    chooseFormat(form, parts, written[0]);
  }
  showTime(form, parts);
}

function chooseFormat(form, parts, format) {
  form.format = format;
  form.given = {};
  parts.options.replaceChildren(...optionFields(format.options, form.given));
  parts.at.value = format.changes ? "" : "0";
  parts.at.placeholder = format.changes ? "as it changes" : "";
  showTime(form, parts);
}

// Shows the field for a time if the world has events.
function showTime(form, parts) {
  parts.time.hidden = !form.studio.model.world.events;
}

// Returns the options as the server expects them.
function asked(form, parts) {
  checkOptions(parts.options);
  for (const input of [parts.at, parts.x, parts.y])
    if (!input.validity.valid) {
      input.focus();
      throw new Refused("Enter a number; a time must be 0 or more.");
    }
  if ((parts.x.value === "") !== (parts.y.value === "")) throw new Refused("An origin has x and y; enter both or neither.");
  const changing = form.studio.model.world.events !== null;
  return {
    options: form.given,
    at: changing && parts.at.value !== "" ? parts.at.valueAsNumber : null,
    origin: parts.x.value === "" ? null : [parts.x.valueAsNumber, parts.y.valueAsNumber],
    sidecar: parts.sidecar.checked,
  };
}

async function exportAs(form, parts, inFolder, wrote) {
  const { studio, format } = form,
    more = asked(form, parts);
  const name = (studio.model.world.name || "world.grid").replace(/\.grid(\.gz)?$/, "") + format.suffixes[0];
  const message = { format: format.name, name, world: messageOf(studio.model.world), keep: inFolder, ...more };
  const answer = await overwriting(name, (overwrite) => studio.connection.ask("export", { ...message, overwrite }));
  if (!answer) return `${name} was not changed.`;
  for (const file of answer.files || []) keep(file.name, new Blob([bytesOf(file.data)]));
  if (inFolder) wrote();
  const where = inFolder
    ? `Wrote ${answer.written.join(", ")}.`
    : `Downloaded ${answer.files.map((file) => file.name).join(", ")}${answer.inside.length > 1 ? `, with ${answer.inside.join(" and ")}` : ""}.`;
  return [where, ...answer.lost, ...answer.notes].join(" ");
}

// Overwrites a file only after asking; null if the user declines.
async function overwriting(name, write) {
  try {
    return await write(false);
  } catch (error) {
    if (!(error instanceof Refused) || error.code !== "file-exists") throw error;
    return confirm(`${name}, or a file that belongs to it, already exists. Overwrite?`) ? write(true) : null;
  }
}
