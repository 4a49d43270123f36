// The collapsed part of the world panel about the robot's body and goals, by the options of the command
// line: the server reads them, and returns the world with the text of its file.

import { choice, el } from "#player/dom.js";
import { askAbout } from "#studio/shared/asking.js";
import { Ended } from "#studio/shared/connection.js";
import { labelled } from "#studio/shared/fields.js";
import { Refused } from "#studio/shared/refusals.js";
import { messageOf } from "#studio/shared/world_message.js";

const ARRIVALS = [["", "touch the target"], ["step", "end a step in it"], ["stop", "stop in it"]];

/**
 * @param {Studio} studio
 * @returns {{element: HTMLElement, refresh: () => void}}
 */
export function goalPart(studio) {
  const { model } = studio;
  const text = (placeholder) => el("input", { type: "text", autocomplete: "off", placeholder, onchange: change });
  const fields = {
    footprint: text("a disc, or 0.62x0.9"),
    heading: text("any, or 1.57:0.25"),
    arrival: choice(ARRIVALS, "", change),
    waypoints: text("none, or 1.2,3.4 0.5,2.1"),
  };
  const fault = el("p", { class: "bad", role: "alert", hidden: true });
  const element = el(
    "details",
    { class: "more", id: "goal" },
    el("summary", {}, "Body, goal and waypoints"),
    labelled("Footprint", fields.footprint, { unit: "m" }),
    labelled("Heading at the target", fields.heading, { unit: "rad, with its tolerance" }),
    labelled("To arrive", fields.arrival),
    labelled("Waypoints", fields.waypoints, { unit: "m" }),
    fault,
  );

  let asked = 0, // only the newest texts count, whatever is drawn meanwhile
    answered = 0;
  async function change() {
    asked += 1;
    const own = asked;
    const values = Object.fromEntries(Object.entries(fields).map(([name, field]) => [name, field.value.trim()]));
    const wrong = (words) => {
      fault.hidden = !words;
      fault.textContent = words;
    };
    try {
      const { source, robot_radius } = await askAbout(studio.connection, () => asked, "goal", /** @type {any} */ ({ world: messageOf(model.world), ...values }));
      answered = own;
      wrong("");
      model.change("goal", { source, robot_radius });
    } catch (error) {
      if (!(error instanceof Refused || error instanceof Ended)) throw error;
      if (own !== asked) return; // a newer one is on its way
      answered = own;
      wrong(error.message);
    }
  }

  const shown = { footprint: "", heading: "", arrival: "", waypoints: "" };
  const refresh = () => {
    const texts = textsOf(model.world.source ?? "");
    // What a user types stays until it is answered, and the world's own texts change.
    if (JSON.stringify(texts) === JSON.stringify(shown) || asked !== answered) return;
    for (const [name, field] of Object.entries(fields)) {
      const isTyping = field === document.activeElement && field.value !== shown[name];
      if (isTyping) continue;
      shown[name] = texts[name];
      field.value = texts[name];
    }
    if (Object.values(texts).some(Boolean)) element.open = true;
  };
  return { element, refresh };
}

/**
 * Returns the options of the first robot in the text of a file; empty for what it has not.
 * @param {string} source
 * @returns {Record<"footprint" | "heading" | "arrival" | "waypoints", string>}
 */
function textsOf(source) {
  const table = source.startsWith("%worldgen-grid 2") ? (source.slice(0, source.indexOf("%cells")).split("[[robot]]")[1] ?? "") : "";
  const value = (name) => new RegExp(`^${name} = (.*)$`, "m").exec(table)?.[1] ?? "";
  const join = (...parts) => parts.filter(Boolean).join(":");
  const corners = value("footprint") ? JSON.parse(value("footprint")) : [];
  const [wide, high] = [0, 1].map((axis) => corners.map((corner) => Math.abs(corner[axis])));
  const isBox = corners.length === 4 && [wide, high].every((sides) => sides.every((side) => side === sides[0]));
  const goals = [...value("waypoints").matchAll(/\btarget = \[([^\]]*)\]/g)].map(([, numbers]) => numbers.replaceAll(" ", ""));
  const arrival = value("arrival").replaceAll('"', "");
  return {
    footprint: isBox ? `${2 * wide[0]}x${2 * high[0]}` : corners.map((corner) => corner.join(",")).join(" "),
    heading: join(value("target_heading"), value("heading_tolerance")),
    arrival: arrival === "touch" ? "" : arrival,
    waypoints: goals.join(" "),
  };
}
