// The files of the opened folder: open, save, import, export.

import { askToOpen } from "#studio/shared/asking.js";
import { el, grouped, plural } from "#player/dom.js";
import { exampleButtons } from "#studio/draw/examples.js";
import { Ended } from "#studio/shared/connection.js";
import { makeExport } from "#studio/draw/export_form.js";
import { labelled } from "#studio/shared/fields.js";
import { makeImport } from "#studio/draw/import_form.js";
import { messageOf } from "#studio/shared/world_message.js";
import { Refused } from "#studio/shared/refusals.js";

/**
 * @param {Studio} studio
 * @returns {any}
 */
export function makeFiles(studio) {
  const parts = {
    list: el("ul", { class: "files", "aria-label": "Files in the folder" }),
    found: el("details", { hidden: true }, el("summary", {}), el("ul", { class: "files", "aria-label": "Found by campaigns" })),
    said: Object.fromEntries(["save", "import", "export", "open"].map((name) => [name, el("p", { role: "status" })])),
  };
  const files = { parts, files: [], named: "", sheet: null };
  parts.find = el("input", {
    type: "search",
    placeholder: "Find",
    "aria-label": "Find a file",
    oninput: () => showList(studio, files),
  });
  parts.folder = el("p", { class: "quiet folder" });
  parts.name = el("input", { type: "text", id: "save-name", placeholder: "world.grid", autocomplete: "off" });
  const element = el(
    "div",
    {},
    savePart(studio, files),
    parts.said.save,
    exchangePart(studio, files),
    el("h2", {}, "Open"),
    parts.said.open,
    parts.folder,
    parts.find,
    parts.list,
    parts.found,
  );
  return {
    element,
    list: () => list(studio, files),
    bring: (dropped) => {
      parts.exchange.open = true;
      parts.imported.bring(dropped);
    },
    refresh: () => {
      if (files.shown !== studio.model.world.name) showList(studio, files);
      followName(studio.model.world, files);
      parts.imported.refresh();
      parts.exported.refresh();
    },
  };
}

// Sets the name for saving: the world's own name until the user types another, which stays until
// another world is drawn.
function followName({ name, sheet }, files) {
  if (files.named === name && files.sheet === sheet) return;
  Object.assign(files, { named: name, sheet });
  files.parts.name.value = name;
}

// Runs an action that the server may refuse, and shows the result next to its button.
async function trying({ said }, where, act) {
  const tell = (words, kind) => {
    for (const [name, place] of Object.entries(said)) {
      place.textContent = name === where ? words : "";
      place.className = kind;
    }
  };
  try {
    tell((await act()) || "", "good");
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    tell(error.message, "bad");
  }
}

function savePart(studio, files) {
  const { parts } = files;
  const save = () => trying(parts, "save", () => saveAs(studio, files, parts.name.value.trim()));
  parts.name.addEventListener("keydown", (event) => {
    if (event.key === "Enter") save();
  });
  return el(
    "div",
    {},
    el("h2", {}, "Save"),
    labelled("Name in the folder", parts.name),
    el("div", { class: "actions" }, el("button", { type: "button", class: "main", onclick: save }, "Save")),
  );
}

/**
 * Saves under a name; asks before overwriting any file but the one opened or saved here.
 * @param {Studio} studio
 * @param {any} files
 * @param {string} name
 * @returns {Promise<string>}
 */
export async function saveAs(studio, files, name) {
  if (!name) throw new Refused("Give the file a name, such as world.grid.");
  const full = /\.grid(\.gz)?$/.test(name) ? name : `${name}.grid`;
  const mark = studio.model.mark(),
    { world } = studio.model;
  const message = { name: full, world: messageOf(world), replaces: full === world.name ? world.file : null };
  let answer;
  try {
    answer = await studio.connection.ask("save", { ...message, overwrite: false });
  } catch (error) {
    if (!(error instanceof Refused)) throw error;
    const changed = error.code === "file-changed";
    if (!changed && error.code !== "file-exists") throw error;
    const why = changed ? "was changed by another program since it was opened here" : "already exists";
    if (!confirm(`${full} ${why}. Overwrite it?`)) return `${full} was not changed.`;
    answer = await studio.connection.ask("save", { ...message, overwrite: true });
  }
  if (studio.model.world.sheet === world.sheet) studio.model.markSaved(answer.name, answer.world.source, answer.file, mark);
  if (files) list(studio, files);
  return `Saved ${answer.name}.`;
}

function exchangePart(studio, files) {
  const { parts } = files;
  parts.imported = makeImport(studio, (act) => trying(parts, "import", act));
  parts.exported = makeExport(studio, (act) => trying(parts, "export", act), () => list(studio, files));
  parts.exchange = el(
    "details",
    {},
    el("summary", {}, "Import and export"),
    parts.imported.element,
    parts.said.import,
    parts.exported.element,
    parts.said.export,
  );
  return parts.exchange;
}

async function list(studio, files) {
  const { parts } = files;
  try {
    files.files = await studio.connection.ask("files");
    parts.folder.textContent = studio.folder;
    showList(studio, files);
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    parts.folder.textContent = error.message;
  }
}

function showList(studio, files) {
  const { parts } = files;
  files.shown = studio.model.world.name;
  const wanted = parts.find.value.toLowerCase();
  const shown = files.files.filter(({ name }) => name.toLowerCase().includes(wanted));
  const [own, found] = [false, true].map((which) => shown.filter((file) => file.found === which));
  const items = (listed) => listed.map((file) => el("li", {}, fileButton(studio, files, file)));
  parts.list.replaceChildren(...items(own));
  parts.found.querySelector("summary").textContent = `Found by campaigns (${grouped(found.length)})`;
  parts.found.querySelector("ul").replaceChildren(...items(found));
  parts.found.hidden = found.length === 0;
  if (own.length === 0 && found.length > 0) parts.found.open = true;
  if (files.files.length === 0) {
    const told = el("p", { role: "status" });
    parts.list.append(el("li", { class: "quiet" }, "This folder has no worlds yet. Save the drawing, drop a map on the page, or start with an example:", el("div", { class: "actions" }, exampleButtons(studio, (words) => (told.textContent = words))), told));
  }
  if (shown.length === 0 && files.files.length > 0)
    parts.list.append(el("li", { class: "quiet" }, `None of ${plural(files.files.length, "file")} matches.`));
}

function fileButton(studio, { parts }, file) {
  const open = () => (file.world ? openFile(studio, file) : parts.imported.bringNamed(file.name));
  const current = file.name === studio.model.world.name ? "true" : null;
  return el(
    "button",
    { type: "button", class: "file", "aria-current": current, onclick: () => trying(parts, "open", open) },
    el("span", { class: file.world ? "" : "quiet" }, file.name),
    el("span", { class: "quiet" }, `${grouped(Math.ceil(file.bytes / 1024))} kB`),
  );
}

/**
 * Opens a world from the folder or imports another file, unless `wanted` returns false by the time
 * it arrives.
 * @param {Studio} studio
 * @param {{name: string, world: boolean}} file
 * @param {() => boolean} [wanted]
 * @returns {Promise<any>}
 */
export async function openFile(studio, file, wanted = () => true) {
  const answer = await askToOpen(studio.connection, file.world ? "open" : "bring", { name: file.name });
  if (!wanted()) return "";
  // archives cannot be written
  studio.show(answer, file.world && answer.file ? file.name : "", file.name);
  return [`${file.world ? "Opened" : "Imported"} ${file.name}.`, ...(answer.notes || [])].join(" ");
}
