// Imports maps from other programs: files on this computer or in the folder, and the options for
// reading them.

import { askToOpen } from "#studio/shared/asking.js";
import { choice, el } from "#player/dom.js";
import { checkOptions, isField, isGood, labelled, number, optionFields } from "#studio/shared/fields.js";
import { Refused } from "#studio/shared/refusals.js";

const AS_FOUND = ""; // lets the server recognise the format

/**
 * Makes the form.
 * @param {Studio} studio
 * @param {(act: () => Promise<string | void>) => Promise<void>} trying - Runs an action that the
 *   server may refuse, and shows the result
 * @returns {any}
 */
export function makeImport(studio, trying) {
  const form = { studio, trying, brought: null, found: AS_FOUND, given: {} };
  const parts = { formats: el("div"), options: el("div") };
  parts.file = el("input", {
    type: "file",
    id: "import",
    multiple: true,
    onchange: () => bringFiles(form, parts, [...parts.file.files]).then(() => (parts.file.value = "")),
  });
  const element = el(
    "div",
    {},
    labelled("Import a map", parts.file, {
      help: "Any format that worldgen formats lists, with the files that it refers to. You can also drop them on the page.",
    }),
    morePart(form, parts),
  );
  return {
    element,
    refresh: () => refresh(form, parts),
    bring: (files) => bringFiles(form, parts, files),
    bringNamed: (name) => bring(form, parts, { name }),
  };
}

function morePart(form, parts) {
  parts.radius = number("", () => {}, { low: 0 });
  parts.radius.placeholder = "default";
  parts.seed = el("input", { type: "text", inputmode: "numeric", pattern: "[0-9]{1,20}", placeholder: "default", title: "The seed must be a whole number." });
  parts.row = number("", () => {}, { low: 1, step: 1 });
  parts.rows = labelled("Scenario row", parts.row, { help: "The problem from which to take start and target. If empty, they are placed automatically." });
  parts.rows.hidden = true;
  parts.again = el("button", { type: "button", disabled: true, onclick: () => again(form, parts) }, "Import again");
  const more = el(
    "details",
    { id: "import-more" },
    el("summary", {}, "Import options"),
    parts.formats,
    parts.options,
    parts.rows,
    el(
      "div",
      { class: "pair-fields" },
      labelled("Robot radius", parts.radius, { unit: "m" }),
      labelled("Seed for places", parts.seed),
    ),
    el("div", { class: "actions" }, parts.again),
  );
  more.addEventListener("keydown", (event) => {
    const enters = event.key === "Enter" && isField(event.target) && !parts.again.disabled;
    if (enters) setTimeout(() => again(form, parts)); // after the field has taken the typed value
  });
  parts.more = more;
  return more;
}

function refresh(form, parts) {
  if (parts.format || !form.studio.offered) return;
  form.readable = form.studio.offered.formats.filter((format) => format.reads);
  const named = form.readable.map(({ name, about }) => [name, `${name}: ${about}`]);
  parts.format = choice([[AS_FOUND, "as recognised"], ...named], AS_FOUND, () => showOptions(form, parts));
  parts.formats.replaceChildren(labelled("Format", parts.format));
  showFound(form, parts);
}

// Shows how the last map was read, once the list of formats is loaded.
function showFound(form, parts) {
  if (parts.format) parts.format.options[0].textContent = form.found ? `as recognised: ${form.found}` : "as recognised";
}

// Returns the chosen format, or else the one recognised in the last map.
const formatOf = (form, parts) => (parts.format ? parts.format.value : AS_FOUND) || form.found;

// Shows the format's options at their defaults.
function showOptions(form, parts) {
  const format = (form.readable || []).find(({ name }) => name === formatOf(form, parts));
  form.given = {};
  parts.options.replaceChildren(...optionFields(format ? format.read_options : [], form.given));
}

/** Replaces the world by files from the browser: a map, and the files that it refers to. */
async function bringFiles(form, parts, files) {
  if (files.length === 0) return;
  await form.trying(async () => {
    const total = files.reduce((sum, { size }) => sum + size, 0);
    const most = form.studio.limits?.dropped ?? Infinity;
    if (total > most) throw new Refused(`Dropped files can have at most ${most / 2 ** 20} MiB; put larger ones into the folder.`);
    const sent = await Promise.all(files.map(async (file) => ({ name: file.name, data: await textOf(file) })));
    return bring(form, parts, { files: sent });
  });
}

// Returns a file's bytes in base64.
async function textOf(file) {
  let bytes;
  try {
    bytes = new Uint8Array(await file.arrayBuffer());
  } catch {
    throw new Refused(`${file.name} cannot be read; drop files, not folders.`);
  }
  let text = "";
  for (let k = 0; k < bytes.length; k += 8192) text += String.fromCharCode(...bytes.subarray(k, k + 8192));
  return btoa(text);
}

/* Reads another map, in the chosen format or else the one recognised.
     brought    { files }, or { name } of a file in the folder */
function bring(form, parts, brought) {
  form.brought = brought;
  form.found = AS_FOUND;
  // options of another map do not apply
  if (!parts.format || parts.format.value === AS_FOUND) showOptions(form, parts);
  parts.row.value = "";
  parts.rows.hidden = true;
  parts.again.disabled = false;
  return ask(form, parts);
}

// Reads the same map again with the current options.
function again(form, parts) {
  return form.trying(() => ask(form, parts));
}

async function ask(form, parts) {
  const message = { ...form.brought, ...asked(form, parts) };
  let answer;
  try {
    answer = await askToOpen(form.studio.connection, "bring", message);
  } catch (error) {
    if (error instanceof Refused && error.opens === "import") parts.more.open = true;
    throw error;
  }
  form.studio.show(answer, "", answer.main);
  const fresh = form.found !== (answer.format || AS_FOUND);
  form.found = answer.format || AS_FOUND;
  if (fresh && (!parts.format || parts.format.value === AS_FOUND)) showOptions(form, parts);
  showFound(form, parts);
  parts.rows.hidden = !(answer.rows > 1);
  [parts.row.max, parts.row.value] = [answer.rows || "", answer.row || ""];
  const more = answer.rows > 1 && !answer.row ? [`Its scenario has ${answer.rows} rows: choose one in Import options.`] : [];
  return [`Imported ${answer.main}.`, ...(answer.notes || []), ...more].join(" ");
}

// Returns the options as the server expects them.
function asked(form, parts) {
  checkOptions(parts.options);
  for (const input of [parts.radius, parts.seed, parts.row])
    if (!isGood(input)) {
      input.focus();
      throw new Refused("An import option is not valid; see the marked field.");
    }
  const format = formatOf(form, parts);
  const valueOf = (input) => (input.value === "" ? null : input.valueAsNumber);
  return {
    format: format || null,
    options: form.given,
    radius: valueOf(parts.radius),
    row: parts.rows.hidden ? null : (valueOf(parts.row) ?? 0),
    seed: parts.seed.value.trim() || null,
  };
}
