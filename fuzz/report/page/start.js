// Starts the page: selects the view by address, and sets up keys and colours.

import { short } from "#player/archive.js";
import { byId, causeWords, el, grouped, plural } from "#player/dom.js";
import { followSystem } from "#player/theme.js";
import { COLOURS, makeAnswer } from "#report/answer.js";
import { makeCampaign } from "#report/charts.js";
import { makeDetail } from "#report/detail.js";
import { failureOf, makeOverview } from "#report/overview.js";
import { keyListener, showKeys } from "#report/page_keys.js";

/** @type {ReportData} */
const data = JSON.parse(byId("data").textContent);
const everything = [...data.failures, ...data.extras];
const views = { overview: byId("overview"), campaign: byId("campaign"), detail: byId("detail") };
/**
 * @type {{ answer: { redraw(): void } | null, overview: Overview | null, detail: Detail | null, id:
 *   string, scroll: number }}
 */
const page = { answer: null, overview: null, detail: null, id: "", scroll: 0 };

function redraw() {
  page.answer?.redraw();
  if (page.overview) page.overview.redraw();
  if (page.detail) page.detail.redraw();
}

function showTotals() {
  const { failures, campaigns, others } = data;
  const causes = new Set(failures.map((failure) => `${failure.controller}\n${failure.motion}\n${failure.group}`)).size;
  const confirmed = failures.filter((failure) => failure.confirmed).length;
  const some = (count, one, many = `${one}s`) => ["", grouped(count), ` ${count === 1 ? one : many}`];
  const items = [some(failures.length, "failure"), some(causes, "cause")];
  if (failures.length > 0)
    items.push(["", `${grouped(confirmed)} of ${grouped(failures.length)}`, " confirmed by running them again"]);
  // one campaign's folder
  const all = campaigns.length === 1 && failures.every((failure) => failure.campaign === 0);
  for (const { seed, units, units_cut, worlds, steps, seconds } of all ? campaigns : []) {
    items.push(
      ["seed ", seed, ""],
      units_cut ? ["", grouped(units), ` ${units === 1 ? "unit" : "units"} and ${grouped(units_cut)} cut short`] : some(units, "unit"),
      some(worlds, "world"),
      ["", short(steps), " steps"],
      ["", seconds.toFixed(1), " s"],
    );
  }
  if (campaigns.length > 1) items.push(some(campaigns.length, "campaign"));
  if (others > 0)
    items.push(some(others, "world without a failure ignored", "worlds without a failure ignored"));
  byId("totals").append(...items.map(([before, value, after]) => el("span", {}, before, el("b", {}, value), after)));
  if (failures.length > confirmed) byId("totals").after(el("p", { class: "bad" }, unconfirmed(failures.filter((failure) => !failure.confirmed))));
}

// Most often one reason explains all, such as a controller that is in another folder.
function unconfirmed(failures) {
  const reasons = new Set(failures.map((failure) => failure.reason));
  const more = reasons.size > 1 ? `, and ${plural(reasons.size - 1, "other reason")}` : "";
  return `${plural(failures.length, "failure is", "failures are")} not confirmed: ${[...reasons][0]}${more}.`;
}

function showTabs(current) {
  const tab = (href, words, here) => el("a", { href, "aria-current": here ? "page" : null }, words);
  byId("tabs").replaceChildren(
    tab("#", `Failures ${grouped(data.failures.length)}`, current !== "campaign"),
    ...(data.campaigns.length > 0
      ? [tab("#campaign", data.campaigns.length === 1 ? "Campaign" : "Campaigns", current === "campaign")]
      : []),
  );
}

/**
 * @param {string} id
 * @returns {Neighbours}
 */
function neighboursOf(id) {
  const shown = page.overview?.shown() ?? [],
    all = shown.includes(id) ? shown : data.failures.map((failure) => failure.id);
  const here = all.indexOf(id);
  return [all[here - 1], all[here + 1]];
}

// The address selects the view: empty, "campaign", or a failure's digest.
function route() {
  const name = location.hash.slice(1),
    failure = failureOf(everything, name);
  const view = failure ? "detail" : name === "campaign" && data.campaigns.length > 0 ? "campaign" : "overview";
  const before = page.id;
  if (!views.overview.hidden) page.scroll = scrollY;
  page.detail?.player()?.play(false);
  page.detail?.close();
  page.detail = null;
  page.id = failure ? name : "";
  for (const [key, section] of Object.entries(views)) section.hidden = key !== view;
  byId("answer").hidden = view !== "overview";
  showTabs(view);
  document.title = failure ? `${causeWords(failure.group)} - ${data.title}` : data.title;
  if (failure) {
    page.detail = makeDetail(views.detail, failure, neighboursOf(name), data.live);
    scrollTo(0, 0);
    views.detail.querySelector("h2").focus({ preventScroll: true });
  } else if (view === "overview" && before) {
    scrollTo(0, page.scroll);
    const card = byId(`card-${before}`);
    if (card) card.focus({ preventScroll: true });
  }
}

// Prepares the page for paper, which is light and cannot unfold anything, and returns how to undo
// it. The campaign follows the list of failures.
function preparePaper() {
  const { theme } = document.documentElement.dataset;
  const isList = !views.overview.hidden;
  const folded = [...document.querySelectorAll("main details:not([open])")];
  const hidden = [.../** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll(".folded[hidden]"))];
  if (isList && data.campaigns.length > 0) hidden.push(views.campaign);
  const draw = () => {
    redraw();
    if (isList) page.overview?.drawAll();
  };
  document.documentElement.dataset.theme = "light";
  for (const one of folded) one.setAttribute("open", "");
  for (const one of hidden) one.hidden = false;
  draw();
  return () => {
    document.documentElement.dataset.theme = theme;
    for (const one of folded) one.removeAttribute("open");
    for (const one of hidden) one.hidden = true;
    draw();
  };
}

function start() {
  showTotals();
  page.answer = makeAnswer(byId("answer"), data);
  const rows = data.answers.flatMap((answer) => answer.causes);
  const causes = new Map(rows.flatMap((row) => row.groups.map((group) => [group, COLOURS[row.severity]])));
  if (data.failures.length > 0) page.overview = makeOverview(views.overview, data.failures, causes);
  else if (data.answers.length === 0) views.overview.append(el("p", { class: "quiet" }, "No failure was found."));
  if (data.campaigns.length > 0) makeCampaign(views.campaign, data.campaigns, data.failures);
  followSystem(byId("theme"), redraw);
  byId("show-keys").addEventListener("click", showKeys);
  addEventListener("hashchange", route);
  addEventListener("keydown", keyListener(page, neighboursOf));
  addEventListener("resize", redraw);
  let restore = () => {};
  addEventListener("beforeprint", () => (restore = preparePaper()));
  addEventListener("afterprint", () => restore());
  route();
  page.answer.redraw();
}

start();
