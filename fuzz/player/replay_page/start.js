// The page of one world: its robots, any of which can be shown in front, and the player.

import { buildPlayer, dragToMove } from "#player/controls.js";
import { byId, el, shortName, verdictSign } from "#player/dom.js";
import { robotColour } from "#player/picture/pen.js";
import { cameraKeys, clockKeys, layerKeys } from "#player/keys.js";
import { endingOf, sceneOf, showInstruments, showRobots } from "#player/robots.js";
import { followSystem } from "#player/theme.js";

/** @type {ReplayData} */
const data = JSON.parse(byId("data").textContent);
const canvas = el("canvas", { id: "stage", role: "img" });
const under = el("div", { class: "under" }),
  instruments = el("p", { class: "instruments", id: "instruments" }),
  list = el("ol", { class: "robots", "aria-label": "Results" });
/** @type {{ player: Player | null, looked: number }} */
const page = { player: null, looked: data.robots.findIndex((one) => one.run) };

function look(number) {
  if (!data.world) return;
  page.looked = number;
  const front = data.robots[number];
  if (page.player) page.player.play(false);
  const drawn = { ...sceneOf(data.world, data.robots, number), name: data.title };
  page.player = buildPlayer(canvas, under, drawn, page.player, (player) => showInstruments(instruments, player));
  canvas.setAttribute("aria-label", `${front.name}: ${endingOf(front)}`);
  showRobots(list, data.robots, number, look);
}

function onKey(event) {
  if (!page.player || event.ctrlKey || event.metaKey || event.altKey) return;
  const { target, key } = event;
  if (target.matches("select, input[type=range]") && /^(Arrow|Home|End|Page)/.test(key)) return;
  if (/^( |Enter)$/.test(key) && target.matches("button, summary, select, input")) return;
  const keys = { d: () => byId("theme").click(), ...cameraKeys(page.player), ...layerKeys(page.player) };
  const act = { ...keys, ...clockKeys(page.player, event.shiftKey ? 10 : 1) }[key];
  if (!act) return;
  event.preventDefault();
  act();
}

// Controller, verdict and reason come before the picture, so that nobody has to scroll for them.
byId("endings").append(...data.robots.map((one, k) => {
  const chip = data.robots.length > 1 ? el("span", { class: `chip ${robotColour(k + 1)}` }, String(k + 1)) : null;
  const sign = one.error ? null : verdictSign(one.verdict);
  return el("li", { "data-verdict": one.verdict || "crash" }, chip, " ", el("b", {}, shortName(one.name)), ": ", el("span", { class: "ending" }, sign, " ", one.error || one.verdict), one.error ? "" : ` ${one.why}`);
}));
byId("main").append(el("div", { class: "stage" }, canvas), instruments, under, list);
dragToMove(canvas, page);
followSystem(byId("theme"), () => page.player && page.player.draw());
addEventListener("keydown", onKey);
addEventListener("resize", () => page.player && page.player.draw());
if (data.world && page.looked >= 0) look(page.looked);
else byId("main").replaceChildren(el("p", { class: "notice" }, "There is nothing to draw: the world is too large, or no robot has run."));
