// The playground: the editor of reports on worlds that the documentation brings along. An address
// such as #loop, or ?loop, chooses a scene; in a frame of another page it is only the figure.

import { bytesOf } from "#player/decode.js";
import { byId, el } from "#player/dom.js";
import { followSystem } from "#player/theme.js";
import { canChange, makeChange } from "#report/change.js";

/**
 * @typedef {object} PlayScene
 * @property {string} name
 * @property {string} title
 * @property {string} controller name of the one that it begins with; empty for the proof alone
 * @property {string} parameter whose values its worlds have; empty for one world
 * @property {{ value: string, question: LiveWorld, source: string, drawn: DrawnWorld, kind: number }[]} worlds
 */
/** @typedef {{ scenes: PlayScene[], runs: Record<string, LiveRecipe>[], sensors: Record<string, any>, controllers: string[] }} Packed */

const NONE = "only the proof";
const isFigure = window !== window.top;
/** @type {{ live?: LiveCore, packed: string }} */
const data = JSON.parse(byId("data").textContent);
const state = { player: /** @type {Player | null} */ (null) };
/** @type {{ end(): void, element: HTMLElement, open(): Promise<void>, drive(run: LiveRecipe | null): void } | null} */
let change = null;

async function start() {
  const stream = new Blob([bytesOf(data.packed)]).stream().pipeThrough(new DecompressionStream("gzip"));
  /** @type {Packed} */
  const packed = JSON.parse(await new Response(stream).text());
  const [scene, controller, value] = ["scene", "controller", "value"].map((name) => /** @type {HTMLInputElement} */ (byId(name)));
  scene.append(...packed.scenes.map(({ name, title }) => el("option", { value: name }, title)));
  controller.append(...[NONE, ...packed.controllers].map((name) => el("option", { value: name }, name)));

  const chosen = () => packed.scenes.find(({ name }) => name === scene.value) ?? packed.scenes[0];
  const world = () => chosen().worlds[value.valueAsNumber];
  const run = () => packed.runs[world().kind][controller.value] ?? null;
  const show = () => {
    byId("shown").textContent = world().value;
    open(world(), run(), packed.sensors[controller.value] ?? null, `${scene.value} ${value.value}`);
  };
  const choose = () => {
    const { controller: first, parameter, worlds } = chosen();
    controller.value = first || NONE;
    byId("step").hidden = !parameter;
    byId("parameter").textContent = parameter;
    Object.assign(value, { max: String(worlds.length - 1), value: String(Math.floor((worlds.length - 1) / 2)) });
    byId("more").querySelector("a")?.setAttribute("href", `${location.pathname}#${scene.value}`);
    show();
  };
  const follow = () => {
    scene.value = (location.hash || location.search).slice(1) || packed.scenes[0].name;
    if (!scene.value) scene.value = packed.scenes[0].name;
    choose();
  };
  scene.addEventListener("change", () => (location.hash = scene.value));
  value.addEventListener("input", show);
  controller.addEventListener("change", () => change?.drive(run()));
  addEventListener("hashchange", follow);
  follow();
}

// Opens a world in the editor; what was drawn in it stays while the page is open.
function open({ question, source, drawn, value }, run, sensors, id) {
  change?.end();
  /** @type {any} */
  const failure = {
    id,
    verdict: "",
    test: "",
    tries: [],
    live: { question: { world: question, run, why: "" }, source, label: "" },
    now: { name: `world-${value || "1"}`, world: drawn, run: null, sensors, named: [], file: "", events: 0 },
  };
  if (!canChange(data.live, failure)) {
    byId("missing").hidden = false;
    return;
  }
  const [stage, canvas, under] = ["stage", "canvas", "under"].map(byId);
  state.player = null;
  const editor = makeChange(failure, /** @type {LiveCore} */ (data.live), { stage, canvas: /** @type {any} */ (canvas), under, state, restore() {} });
  change = editor;
  byId("editor").replaceChildren(editor.element);
  editor.open().then(() => editor.drive(run));
}

document.body.classList.toggle("figure", isFigure);
byId("more").hidden = !isFigure;
followSystem(el("button"), () => state.player?.draw());
await start();
