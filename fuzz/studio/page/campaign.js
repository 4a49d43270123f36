// The campaign page: which folder is looked at, what its campaign does now, and the failures that lie there.

import { byId, el, plural, say } from "/player/dom.js";
import { makeFailurePanel } from "./campaign_failure.js";
import { makeForm } from "./campaign_form.js";
import { makeStatus } from "./campaign_status.js";
import { makeWall } from "./campaign_wall.js";
import { Ended, Refused } from "./connection.js";

const CHOSEN = "worldgen-studio-campaign"; // under which the browser keeps the folder that was looked at last
const PANELS = { new: "New campaign", failure: "Failure" };

/* The page.
     studio    { connection, offered, model, show, go, ... }: what all pages share */
export function makeCampaign(section, studio) {
  const campaign = { studio, folder: null, states: new Map(), folders: [], offered: null, stamp: "", watched: null, stopping: "" };
  const parts = {
    said: el("p", { class: "said", role: "status", id: "campaign-said" }),
    folders: el("select", { id: "campaign-folder", onchange: (event) => choose(campaign, event.target.value) }),
  };
  Object.assign(campaign, { parts, select: (one) => select(campaign, one), trying: (act) => trying(campaign, act) });
  campaign.begin = (message) => trying(campaign, () => start(campaign, "begin", message));
  campaign.goOn = (message) => trying(campaign, () => start(campaign, "resume", { folder: campaign.folder, ...message }));
  campaign.stop = () => trying(campaign, () => stop(campaign));
  campaign.reload = () => reloadWall(campaign);
  campaign.form = makeForm(campaign);
  campaign.status = makeStatus(campaign);
  campaign.wall = makeWall(campaign);
  campaign.failure = makeFailurePanel(campaign);
  section.replaceChildren(
    el(
      "div",
      { class: "middle" },
      el("div", { class: "strip" }, el("label", { class: "field" }, "Folder", parts.folders), campaign.status.actions),
      parts.said,
      campaign.status.element,
      campaign.wall.element,
    ),
    sidePart(campaign),
  );
  openPanel(campaign, "new");
  return {
    begin: () => begin(campaign),
    refresh: () => refresh(campaign),
    redraw: () => (campaign.wall.redraw(), campaign.failure.redraw()),
  };
}

function sidePart(campaign) {
  const { parts } = campaign;
  const bodies = { new: campaign.form.element, failure: campaign.failure.element };
  parts.tabs = Object.entries(PANELS).map(([name, words]) =>
    el(
      "button",
      { type: "button", role: "tab", id: `tab-${name}`, "aria-controls": `panel-${name}`, onclick: () => openPanel(campaign, name) },
      words,
    ),
  );
  parts.panels = Object.entries(bodies).map(([name, body]) =>
    el("div", { class: "panel", role: "tabpanel", id: `panel-${name}`, "aria-labelledby": `tab-${name}` }, body),
  );
  return el("aside", { class: "side" }, el("div", { class: "panel-tabs", role: "tablist", "aria-label": "Panels" }, parts.tabs), parts.panels);
}

function openPanel({ parts, form }, name) {
  for (const tab of parts.tabs) tab.setAttribute("aria-selected", String(tab.id === `tab-${name}`));
  for (const panel of parts.panels) panel.hidden = panel.id !== `panel-${name}`;
  if (name === "new") form.refresh();
}

// Does something that the server may refuse; what it says is shown.
async function trying({ parts }, act) {
  try {
    const words = await act();
    parts.said.className = "said quiet";
    parts.said.textContent = words || "";
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    parts.said.className = error instanceof Refused ? "said bad" : "said quiet";
    parts.said.textContent = error instanceof Refused ? error.message : "";
  }
}

// The page was opened, or the connection is there again.
async function begin(campaign) {
  if (!campaign.studio.offered) return;
  await trying(campaign, () => list(campaign));
  await look(campaign);
}

async function list(campaign) {
  const answer = await campaign.studio.connection.ask("campaigns");
  campaign.offered = answer;
  campaign.folders = answer.folders;
  campaign.states = new Map(answer.campaigns.map((state) => [state.folder, state]));
  const names = [...campaign.states.keys(), ...answer.folders.map(({ name }) => name)];
  const running = answer.campaigns.find((state) => state.running);
  if (campaign.folder === null || !names.includes(campaign.folder)) {
    const kept = localStorage.getItem(CHOSEN);
    campaign.folder = running ? running.folder : names.includes(kept) ? kept : (names[0] ?? null);
  }
  campaign.form.refresh();
  showFolders(campaign);
  return answer.faults.join(" ");
}

function showFolders({ parts, folder, folders, states }) {
  const counts = new Map(folders.map(({ name, worlds }) => [name, worlds]));
  const option = (value, words) => el("option", { value, selected: value === folder }, words);
  const campaigns = [...states.values()].map((state) => {
    const worlds = `(${counts.get(state.folder) || 0})`;
    return option(state.folder, `${state.folder} ${state.running ? "· running" : worlds}`);
  });
  const others = folders
    .filter(({ name }) => !states.has(name))
    .map(({ name, worlds }) => option(name, `${name || "the whole opened folder"} (${worlds})`));
  const group = (label, options) => (options.length > 0 ? el("optgroup", { label }, options) : null);
  parts.folders.replaceChildren(...[group("Campaigns", campaigns), group("Other folders", others)].filter(Boolean));
  parts.folders.disabled = campaigns.length + others.length === 0;
}

function choose(campaign, folder) {
  campaign.folder = folder;
  campaign.parts.said.textContent = "";
  localStorage.setItem(CHOSEN, folder);
  return look(campaign);
}

// Shows the chosen folder; while its campaign runs, follows it.
async function look(campaign) {
  campaign.stamp = "";
  campaign.watched = null;
  campaign.wall.forget();
  campaign.status.show(campaign.states.get(campaign.folder) || null);
  await reloadWall(campaign);
  if (campaign.states.get(campaign.folder)?.running) watch(campaign);
}

async function watch(campaign) {
  const { folder } = campaign;
  if (campaign.watched === folder) return;
  campaign.watched = folder;
  try {
    const answer = await campaign.studio.connection.ask("watch", { folder }, ({ state }) => take(campaign, state));
    take(campaign, answer.state);
    say(`The campaign in ${folder} stands still: ${plural(answer.state.worlds, "world")}.`);
    if (campaign.folder === folder) await trying(campaign, () => list(campaign));
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
  }
  if (campaign.watched === folder) campaign.watched = null;
}

function take(campaign, state) {
  campaign.states.set(state.folder, state);
  if (!state.running && campaign.stopping === state.folder) campaign.stopping = "";
  if (state.folder !== campaign.folder) return;
  campaign.status.show(state);
  if (state.failures !== campaign.stamp) reloadWall(campaign, state.failures);
}

async function reloadWall(campaign, stamp = campaign.stamp) {
  const { folder } = campaign;
  campaign.stamp = stamp;
  if (folder === null) {
    campaign.wall.show(null);
    return;
  }
  try {
    const answer = await campaign.studio.connection.ask("failures", { folder });
    if (folder === campaign.folder) campaign.wall.show(answer);
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    if (error instanceof Refused) campaign.wall.refuse(error.message);
  }
}

// Begins a campaign, or goes on with one, and shows it.
async function start(campaign, kind, message) {
  const { parts } = campaign;
  parts.said.className = "said quiet";
  parts.said.textContent = "Beginning …";
  const { state } = await campaign.studio.connection.ask(kind, message);
  campaign.folder = state.folder;
  localStorage.setItem(CHOSEN, state.folder);
  await list(campaign);
  take(campaign, state);
  look(campaign);
  return "";
}

async function stop(campaign) {
  campaign.stopping = campaign.folder;
  campaign.status.show(campaign.states.get(campaign.folder));
  const { state } = await campaign.studio.connection.ask("stop", { folder: campaign.folder });
  take(campaign, state);
  return "";
}

function select(campaign, failure) {
  openPanel(campaign, "failure");
  campaign.failure.show(failure);
}

function refresh(campaign) {
  campaign.watched = null;
  campaign.form.refresh();
  if (!byId("campaign").hidden) begin(campaign);
}
