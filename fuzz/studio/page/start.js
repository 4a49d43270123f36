// The studio: what all pages share, which page is shown, and whether the server is there.

import { byId, el, keyButton, say } from "/player/dom.js";
import { followSystem } from "/player/theme.js";
import { makeCampaign } from "./campaign.js";
import { Ended, Refused, makeConnection } from "./connection.js";
import { makeDraw } from "./draw.js";
import { openFile, saveAs } from "./files.js";
import { listen, showKeys } from "./keys.js";
import { Model, draft, emptyWorld, openedBefore, worldOf } from "./model.js";
import { makePlay } from "./play.js";
import { listenToBoard } from "./pointer.js";
import { makeProver } from "./proof.js";

const PAGES = { draw: ["Draw", "1"], play: ["Play", "2"], campaign: ["Campaign", "3"] };
const SIDE = 40; // cells of the world that one begins with

const studio = {
  model: new Model(emptyWorld(SIDE, SIDE), () => changed()),
  connection: null,
  offered: null, // what the server has to choose from
  widest: null,
  say: (words) => say(words),
  page: () => (Object.hasOwn(PAGES, location.hash.slice(1)) ? location.hash.slice(1) : "draw"),
  go: (page) => {
    location.hash = page;
  },
  show,
  undo: () => step("Undone", studio.model.undo()),
  redo: () => step("Redone", studio.model.redo()),
  save,
  run: () => (studio.page() === "play" ? studio.play.run() : studio.go("play")),
};
const prove = makeProver(studio, setProof, setWidest);
let scheduled = 0;

// After a change: everything is drawn once a frame, however much has changed.
function changed() {
  if (!studio.draw) return;
  studio.draw.board.proof = null;
  if (!scheduled)
    scheduled = requestAnimationFrame(() => {
      scheduled = 0;
      studio.draw.refresh();
      showName();
    });
  prove();
  studio.draw.senseSignal();
  clearTimeout(changed.keeping);
  changed.keeping = setTimeout(() => studio.model.keepDraft(), 800);
}

function step(what, label) {
  if (label) say(`${what}: ${label}`);
}

function setProof(proof) {
  studio.draw.board.proof = proof;
  studio.draw.refresh();
}

function setWidest(widest) {
  if (studio.widest === widest) return;
  studio.widest = widest;
  studio.draw.refresh();
}

function showName() {
  const { unsaved, past, future, world } = studio.model;
  byId("name").replaceChildren(
    world.name || "not saved yet",
    unsaved ? el("span", { class: "quiet" }, " · changed") : "",
  );
  document.title = `${unsaved ? "• " : ""}${world.name || "new world"} - worldgen studio`;
  byId("undo").disabled = past.length === 0;
  byId("redo").disabled = future.length === 0;
}

/** Another world takes the place of the one that is drawn; undo brings that back. */
function show(answer, name, label) {
  const world = worldOf(answer.world, name);
  studio.model.change(`open ${label}`, world);
  studio.draw.board.view = studio.draw.board.selection = null;
  if (name) studio.model.markSaved(name, world.source);
  if (answer.failure) studio.play.prefer(answer.failure);
  say(`Opened ${label}`);
}

async function save() {
  const { name } = studio.model.world;
  if (!name) {
    studio.go("draw");
    studio.draw.panel("files");
    byId("save-name").focus();
    return;
  }
  try {
    say(await saveAs(studio, null, name));
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    notice(error.message);
  }
}

function route() {
  const page = studio.page();
  for (const name of Object.keys(PAGES)) byId(name).hidden = name !== page;
  byId("tabs").replaceChildren(
    ...Object.entries(PAGES).map(([name, [words, key]]) =>
      el("a", { href: `#${name}`, "aria-current": name === page ? "page" : null, "aria-keyshortcuts": key }, words),
    ),
  );
  if (page !== "play") studio.play.pause();
  if (page === "play") studio.play.begin();
  else if (page === "campaign") studio.campaign.begin();
  else studio.draw.refresh();
}

function notice(words) {
  if (byId("gone").textContent === words) return; // a screen reader says it once
  byId("gone").textContent = words;
  byId("gone").hidden = words === "";
}

// The connection is there, at first or again: what was asked for in vain is asked again.
async function begun(begins) {
  notice("");
  const first = studio.offered === null;
  try {
    studio.offered = await studio.connection.ask("hello");
    const file = openedBefore() || begins.file;
    if (first && file && studio.model.past.length === 0)
      await openFile(studio, { name: file, world: /\.grid(\.gz)?$/.test(file) });
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    if (error instanceof Refused) notice(error.message);
  }
  studio.play.refresh();
  studio.campaign.refresh();
  changed();
  if (first && studio.page() === "play") studio.play.begin();
}

function lost(forbidden) {
  studio.draw.board.proof = null;
  notice(
    forbidden
      ? "The studio was started anew and does not know this page any more. Open the address that it has printed: what is drawn here comes along."
      : "The studio does not answer. What you draw stays here, and this page comes back by itself when worldgen studio runs again.",
  );
}

function begin() {
  history.replaceState(null, "", `${location.pathname}${location.hash}`); // the token has done its work
  byId("tools").append(
    keyButton("↶", "Undo", "Control+Z", studio.undo, { id: "undo" }),
    keyButton("↷", "Redo", "Control+Y", studio.redo, { id: "redo" }),
    keyButton("Save", "Save", "Control+S", save),
    el("button", { type: "button", id: "theme", "aria-keyshortcuts": "d" }),
    keyButton(["Keys ", el("kbd", {}, "?")], "Keys", "?", showKeys),
  );
  studio.draw = makeDraw(byId("draw"), studio);
  studio.play = makePlay(byId("play"), studio);
  studio.campaign = makeCampaign(byId("campaign"), studio);
  listenToBoard(studio.draw);
  followSystem(byId("theme"), () => {
    if (studio.draw.board.signal) studio.draw.board.signal.picture = null;
    studio.draw.board.draw();
    studio.play.redraw();
    studio.campaign.redraw();
  });
  listen(studio);
  takeDrops();
  addEventListener("hashchange", route);
  addEventListener("beforeunload", () => studio.model.keepDraft());
  const kept = draft();
  if (kept) {
    studio.model.change("what was drawn before", kept);
  }
  studio.connection = makeConnection(begun, lost);
  route();
  showName();
}

function takeDrops() {
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files.length > 0) studio.draw.bring(event.dataTransfer.files[0]);
  });
}

begin();
