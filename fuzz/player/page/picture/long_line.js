/* Draws lines with many corners incrementally, in cached pictures.

   A browser without a graphics card takes 10 to 30 times as long for a line wider than one pixel as
   for a thin one. So it draws a long line one pixel wide, then widens it with slightly shifted
   copies of the whole picture. The cost does not depend on the line's length, so even a frame that
   cannot reuse a picture is drawn without delay. */

import { line, seen, stroke } from "#player/picture/pen.js";

const LONG = 300; // visible corners; a shorter line is drawn again in each frame
// maximum number of rows to add to a picture; if there are more, it is drawn again
const MORE = 2_000;
const AROUND = 1 / 8; // margin around the window while the view is moving, as a share of its side
const kept = new WeakMap(); // pictures by name, by the columns

/**
 * Draws rows of two columns as a line. Rows that are new since the last frame are added to the
 * picture. Everything is drawn again if the view has changed other than by a shift, or if the line
 * has become shorter.
 * @param {Pen} pen
 * @param {{x: Float64Array, y: Float64Array}} columns
 * @param {string} name - Name of this part of the line; each part has its own picture
 * @param {LineLook} look - Its colour must be opaque
 */
export function drawLine(pen, columns, name, look) {
  const { context } = pen;
  context.save();
  context.globalAlpha = look.alpha;
  const picture = pictureFor(pen, columns, name, look);
  if (picture) {
    addRows(picture, columns, look);
    const corner = cornerOf(picture, pen);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.drawImage(picture.canvas, corner[0], corner[1]);
  } else {
    const ratio = ratioOf(pen);
    line(pen, columns.x, columns.y, look.from, look.to);
    stroke(pen, look.colour, thicknessOf(look.width, ratio) / ratio);
  }
  context.restore();
}

function ratioOf({ context }) {
  return context.getTransform().a;
}

// Returns the line's width in pixels of the canvas.
function thicknessOf(width, ratio) {
  return Math.max(1, Math.round(width * ratio));
}

// Returns the cached picture if rows can be added to it, or else an empty one; null if little of
// the line is visible.
function pictureFor(pen, columns, name, look) {
  const { from, to, colour, width, once } = look;
  if (to - from < LONG) return null;
  const pictures = kept.get(columns) || {},
    known = pictures[name],
    ratio = ratioOf(pen),
    { width: wide, height: high } = pen.context.canvas,
    thick = thicknessOf(width, ratio),
    key = [pen.scale, wide, high, ratio, thick, colour, from].join(),
    same = known && known.key === key;
  if (same && known.done <= to && to - known.done <= MORE && covers(known, pen)) return known;
  if (seen(pen, columns.x, columns.y, from, to) < LONG) return null;
  if (!once) kept.set(columns, pictures);
  pictures[name] = { ...emptyPicture(pen, known && known.canvas, colour, same ? known.at : null), key, ratio, thick, done: from };
  return pictures[name];
}

// Makes a picture of the window, or of more than that if the view has been moving since `before`.
function emptyPicture(pen, old, colour, before) {
  const { width, height } = pen.context.canvas,
    ratio = ratioOf(pen),
    at = originOf(pen),
    shift = before ? Math.max(...at.map((value, axis) => Math.abs(value - before[axis]))) : 0,
    margin = Math.round(AROUND * Math.min(width, height)),
    around = shift > 0 && shift < margin ? margin : 0;
  const canvas = old || new OffscreenCanvas(1, 1),
    own = canvas.getContext("2d");
  // this also clears it
  Object.assign(canvas, { width: width + 2 * around, height: height + 2 * around });
  Object.assign(own, { strokeStyle: colour, lineJoin: "round", lineWidth: 1 / ratio });
  const inside = { ...pen, context: own, width: canvas.width / ratio, height: canvas.height / ratio };
  inside.px = (value) => pen.px(value) + around / ratio;
  inside.py = (value) => pen.py(value) + around / ratio;
  return { canvas, own, pen: inside, around, at };
}

// Returns the position of the world's corner, in pixels of the canvas.
function originOf(pen) {
  const ratio = ratioOf(pen);
  return [pen.px(0) * ratio, pen.py(0) * ratio];
}

// Returns the position of a picture's corner in the window, in whole pixels.
function cornerOf({ at, around }, pen) {
  return originOf(pen).map((value, axis) => Math.round(value - at[axis]) - around);
}

function covers(picture, pen) {
  const { width, height } = pen.context.canvas,
    [left, top] = cornerOf(picture, pen);
  return left <= 0 && top <= 0 && left + picture.canvas.width >= width && top + picture.canvas.height >= height;
}

// Adds many rows by drawing them thin and widening the result,
// or a few rows by drawing each several times.
function addRows(picture, columns, { from, to }) {
  if (to <= picture.done) return;
  const { thick, done } = picture;
  const rows = { ...columns, from: Math.max(from, done - 1), to };
  if (done === from) {
    addThin(picture, rows, 0, 0);
    widen(picture);
  } else {
    for (let k = 0; k < thick * thick; k += 1) addThin(picture, rows, k % thick, Math.floor(k / thick));
  }
  picture.done = to;
}

// Draws rows one pixel wide, offset to the upper left by half of the final width.
function addThin({ own, pen, ratio, thick }, { x, y, from, to }, across, down) {
  const corner = (1 - thick) / 2;
  own.setTransform(ratio, 0, 0, ratio, corner + across, corner + down);
  line(pen, x, y, from, to);
  own.stroke();
}

// Widens everything drawn to its final width by shifted copies; the width doubles with each copy.
function widen({ own, canvas, thick }) {
  own.setTransform(1, 0, 0, 1, 0, 0);
  for (let wide = 1; wide < thick; ) {
    const by = Math.min(wide, thick - wide);
    own.drawImage(canvas, by, 0);
    own.drawImage(canvas, 0, by);
    wide += by;
  }
}
