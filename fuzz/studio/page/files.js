// The files of the opened folder: open, save, import, export.

import { choice, el, grouped, plural } from "/player/dom.js";
import { Ended, Refused } from "./connection.js";
import { download, labelled } from "./fields.js";
import { messageOf } from "./model.js";

export function makeFiles(studio) {
  const parts = {
    list: el("ul", { class: "files", "aria-label": "Files of the folder" }),
    said: el("p", { role: "status" }),
  };
  const files = { parts, files: [] };
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
    parts.said,
    exchangePart(studio, files),
    el("h2", {}, "Open"),
    parts.folder,
    parts.find,
    parts.list,
  );
  return {
    element,
    list: () => list(studio, files),
    bring: (file) => bringFile(studio, parts, file),
    refresh: () => {
      if (files.shown !== studio.model.world.name) showList(studio, files);
      if (document.activeElement !== parts.name) parts.name.value = studio.model.world.name;
      fillFormats(studio, parts);
    },
  };
}

// Does something that the server may refuse; what it says is shown.
async function trying(parts, act) {
  try {
    const words = await act();
    parts.said.className = "good";
    parts.said.textContent = words || "";
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    parts.said.className = "bad";
    parts.said.textContent = error.message;
  }
}

function savePart(studio, files) {
  const { parts } = files;
  const save = () => trying(parts, () => saveAs(studio, files, parts.name.value.trim()));
  parts.name.addEventListener("keydown", (event) => {
    if (event.key === "Enter") save();
  });
  return el(
    "div",
    {},
    el("h2", {}, "Save"),
    labelled("Name in the folder", parts.name),
    el("div", { class: "actions" }, el("button", { type: "button", id: "save", class: "main", onclick: save }, "Save")),
  );
}

/** Saves under a name; a file of another world is overwritten only after it was said so. */
export async function saveAs(studio, files, name) {
  if (!name) throw new Refused("Give the file a name, such as world.grid.");
  const full = /\.grid(\.gz)?$/.test(name) ? name : `${name}.grid`;
  const message = { name: full, world: messageOf(studio.model.world) };
  let answer;
  try {
    answer = await studio.connection.ask("save", { ...message, overwrite: full === studio.model.world.name });
  } catch (error) {
    if (!(error instanceof Refused) || !error.message.includes("there already")) throw error;
    if (!confirm(`${full} is there already. Overwrite it?`)) return `${full} is as it was.`;
    answer = await studio.connection.ask("save", { ...message, overwrite: true });
  }
  studio.model.markSaved(answer.name, answer.world.source);
  if (files) list(studio, files);
  return `Saved ${answer.name}.`;
}

function exchangePart(studio, files) {
  const { parts } = files;
  parts.format = el("div");
  const file = el("input", {
    type: "file",
    id: "import",
    onchange: () => bringFile(studio, parts, file.files[0]).then(() => (file.value = "")),
  });
  const keep = (inFolder) => trying(parts, () => exportAs(studio, parts, inFolder));
  return el(
    "details",
    {},
    el("summary", {}, "Import and export"),
    labelled("Import a map", file, { help: "Any format of worldgen formats; or drop a file on the page." }),
    parts.format,
    el(
      "div",
      { class: "actions" },
      el("button", { type: "button", onclick: () => keep(false) }, "Download"),
      el("button", { type: "button", onclick: () => keep(true) }, "Into the folder"),
    ),
  );
}

function fillFormats(studio, parts) {
  if (parts.formats || !studio.offered) return;
  const written = studio.offered.formats.filter((format) => format.writes);
  parts.formats = choice(
    written.map(({ name, about }) => [name, `${name}: ${about}`]),
    written[0].name,
    () => {},
  );
  parts.format.replaceChildren(labelled("Export as", parts.formats));
}

async function exportAs(studio, parts, keep) {
  const format = studio.offered.formats.find(({ name }) => name === parts.formats.value);
  const name = (studio.model.world.name || "world.grid").replace(/\.grid(\.gz)?$/, "") + format.suffixes[0];
  const message = { format: format.name, name, world: messageOf(studio.model.world), keep, overwrite: false };
  const answer = await studio.connection.ask("export", message);
  for (const file of answer.files || []) download(file.name, file.data);
  const where = keep
    ? `Wrote ${answer.written.join(", ")}.`
    : `Downloaded ${answer.files.map((file) => file.name).join(", ")}.`;
  return [where, ...answer.lost, ...answer.notes].join(" ");
}

/** A file of the browser's becomes the world. */
export async function bringFile(studio, parts, file) {
  if (!file) return;
  await trying(parts, async () => {
    const bytes = new Uint8Array(await file.arrayBuffer());
    let text = "";
    for (let k = 0; k < bytes.length; k += 8192) text += String.fromCharCode(...bytes.subarray(k, k + 8192));
    const answer = await studio.connection.ask("bring", { name: file.name, data: btoa(text) });
    studio.show(answer, "", file.name);
    return [`Imported ${file.name}.`, ...(answer.notes || [])].join(" ");
  });
}

async function list(studio, files) {
  const { parts } = files;
  try {
    const answer = await studio.connection.ask("files");
    files.files = answer.files;
    parts.folder.textContent = answer.folder;
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
  const open = (file) => () => trying(parts, () => openFile(studio, file));
  parts.list.replaceChildren(
    ...shown.map((file) =>
      el(
        "li",
        {},
        el(
          "button",
          {
            type: "button",
            class: "file",
            "aria-current": file.name === studio.model.world.name ? "true" : null,
            onclick: open(file),
          },
          el("span", { class: file.world ? "" : "quiet" }, file.name),
          el("span", { class: "quiet" }, `${grouped(Math.ceil(file.bytes / 1024))} kB`),
        ),
      ),
    ),
  );
  if (shown.length === 0 && files.files.length > 0)
    parts.list.append(el("li", { class: "quiet" }, `No file of ${plural(files.files.length, "file")} fits.`));
}

/** Opens a world of the folder, or imports another file of it. */
export async function openFile(studio, file) {
  const answer = await studio.connection.ask(file.world ? "open" : "bring", { name: file.name });
  studio.show(answer, file.world ? file.name : "", file.name);
  return [`${file.world ? "Opened" : "Imported"} ${file.name}.`, ...(answer.notes || [])].join(" ");
}
