// A picture to keep: the map as it is seen now, with what happened, and its legend below it.

import { SAMPLE, drawSample, marksOf } from "#player/legend.js";
import { drawScene } from "#player/picture/map.js";
import { palette } from "#player/picture/pen.js";

const WIDTH = 900; // page pixels
const RATIO = 2; // pixels of the picture for each page pixel
const TALLEST = 760; // page pixels of a map
const EDGE = 16;
const TITLE = 18;
const TEXT = 14;
const LEADING = 1.45;
const FONT = "system-ui, sans-serif";

/**
 * Returns a canvas with one map, or two next to each other, the verdict, sentences, and a legend.
 * @param {Player} player
 * @returns {HTMLCanvasElement}
 */
export function composed(player) {
  const { drawn, step, last, show, view } = player;
  const beside = drawn.beside,
    isWhole = !beside && step >= last;
  const colours = palette();
  const maps = [
    ...(beside ? [{ ...beside, named: [], number: null, others: [], step: beside.run && drawn.run ? (step * drawn.run.dt) / beside.run.dt : 0, view: null, words: beside.words[0] }] : []),
    { ...drawn, step, view: beside ? null : view, words: beside ? beside.words[1] : "" },
  ];
  const wide = Math.floor((WIDTH - EDGE * (maps.length + 1)) / maps.length);
  const seen = view && !beside ? player.canvas : null; // what the player shows of the world
  const high = Math.round(seen ? (wide * seen.clientHeight) / seen.clientWidth : Math.min(TALLEST, Math.max(240, ...maps.map(({ world }) => wide * ((world.height + 0.5) / (world.width + 0.5)) + 18))));
  // First the words, because they say how tall the picture is.
  const canvas = document.createElement("canvas");
  const [head, ...rest] = drawn.says ?? [drawn.name ?? ""];
  const measure = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const lines = [
    ...wrapped(measure, head, `650 ${TITLE}px ${FONT}`).map((words) => ({ words, size: TITLE, font: `650 ${TITLE}px ${FONT}`, colour: colours.ink })),
    ...rest.flatMap((words) => wrapped(measure, words, `${TEXT}px ${FONT}`).map((line) => ({ words: line, size: TEXT, font: `${TEXT}px ${FONT}`, colour: colours.quiet }))),
  ];
  const items = placed(measure, marksOf(drawn, isWhole));
  const wordsHigh = lines.reduce((sum, { size }) => sum + LEADING * size, 0);
  const legendHigh = items.length > 0 ? items[items.length - 1].top + 1.6 * TEXT : 0;
  const top = EDGE + wordsHigh + 8,
    height = Math.ceil(top + high + 12 + legendHigh + EDGE);
  Object.assign(canvas, { width: WIDTH * RATIO, height: height * RATIO });
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.setTransform(RATIO, 0, 0, RATIO, 0, 0);
  context.fillStyle = colours.paper;
  context.fillRect(0, 0, WIDTH, height);
  // The words.
  let down = EDGE;
  context.textBaseline = "alphabetic";
  for (const { words, size, font, colour } of lines) {
    down += LEADING * size;
    context.font = font;
    context.fillStyle = colour;
    context.fillText(words, EDGE, down - 0.35 * size);
  }
  // The maps.
  maps.forEach((one, k) => {
    const map = document.createElement("canvas");
    Object.assign(map, { width: wide * RATIO, height: high * RATIO });
    drawScene(map, { ...one, show, whole: isWhole, on: { width: wide, height: high, ratio: RATIO } }, one.view && { ...one.view, scale: (one.view.scale * wide) / player.canvas.clientWidth });
    const left = EDGE + k * (wide + EDGE);
    context.drawImage(map, left, top, wide, high);
    if (!one.words) return;
    context.font = `600 ${TEXT}px ${FONT}`;
    context.fillStyle = colours.ink;
    context.fillText(one.words, left + 6, top + TEXT + 4);
  });
  // The legend.
  for (const { left, top: row, item } of items) {
    const at = top + high + 12 + row;
    drawSample(context, colours, item.name, left, at, item.number ?? null);
    context.font = `${TEXT - 1}px ${FONT}`;
    context.fillStyle = colours.ink;
    context.fillText(item.words, left + SAMPLE.width + 6, at + 11);
  }
  return canvas;
}

/** @param {CanvasRenderingContext2D} context */
function wrapped(context, text, font) {
  context.font = font;
  const lines = [""];
  for (const word of text.split(/\s+/).filter(Boolean)) {
    const longer = lines[lines.length - 1] ? `${lines[lines.length - 1]} ${word}` : word;
    if (lines[lines.length - 1] && context.measureText(longer).width > WIDTH - 2 * EDGE) lines.push(word);
    else lines[lines.length - 1] = longer;
  }
  return lines.filter(Boolean);
}

/** @param {CanvasRenderingContext2D} context @param {import("#player/legend.js").LegendItem[]} items */
function placed(context, items) {
  context.font = `${TEXT - 1}px ${FONT}`;
  let left = EDGE,
    top = 0;
  return items.map((item) => {
    const width = SAMPLE.width + 6 + context.measureText(item.words).width;
    if (left > EDGE && left + width > WIDTH - EDGE) {
      left = EDGE;
      top += 1.6 * TEXT;
    }
    const place = { left, top, item };
    left += width + 18;
    return place;
  });
}
