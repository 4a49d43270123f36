/* Lines of many corners, kept in pictures of their own, to which is only added.

   A browser without graphics card takes 10 to 30 times as long for a line that is wider than a pixel as for one that is
   not. So a long line is drawn a pixel wide, and then made wider by copies of the whole picture, each a little aside:
   that costs the same however long the line is, and a frame of which nothing is kept is no wait either. */

import { line, seen, stroke } from "#player/pen.js";

const LONG = 300; // corners in sight; a shorter line is drawn anew in each frame
const MORE = 2_000; // rows that are added to a picture; with more of them it is made anew
const AROUND = 1 / 8; // of the window's sides: what a picture holds beyond them when the view follows something
const kept = new WeakMap(); // by the columns: pictures, by their names

/**
 * Draws rows of two columns as a line. Those that were added since the last frame are drawn on; all is drawn anew when
 * the view has changed by more than a shift, or the line has become shorter.
 * @param {Pen} pen
 * @param {{x: Float64Array, y: Float64Array}} columns
 * @param {string} name - Of this part of them; each has its own picture
 * @param {LineLook} look - Its colour lets nothing through
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

// In pixels of the canvas.
function thicknessOf(width, ratio) {
  return Math.max(1, Math.round(width * ratio));
}

// The picture as it is, if it can be added to, or an empty one; none of a line of which there is little to see.
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

// A picture of the window, or of more than that if the view is on its way from `before`.
function emptyPicture(pen, old, colour, before) {
  const { width, height } = pen.context.canvas,
    ratio = ratioOf(pen),
    at = originOf(pen),
    shift = before ? Math.max(...at.map((value, axis) => Math.abs(value - before[axis]))) : 0,
    room = Math.round(AROUND * Math.min(width, height)),
    around = shift > 0 && shift < room ? room : 0;
  const canvas = old || new OffscreenCanvas(1, 1),
    own = canvas.getContext("2d");
  Object.assign(canvas, { width: width + 2 * around, height: height + 2 * around }); // which empties it
  Object.assign(own, { strokeStyle: colour, lineJoin: "round", lineWidth: 1 / ratio });
  const inside = { ...pen, context: own, width: canvas.width / ratio, height: canvas.height / ratio };
  inside.px = (value) => pen.px(value) + around / ratio;
  inside.py = (value) => pen.py(value) + around / ratio;
  return { canvas, own, pen: inside, around, at };
}

// Where the world's corner is, in pixels of the canvas.
function originOf(pen) {
  const ratio = ratioOf(pen);
  return [pen.px(0) * ratio, pen.py(0) * ratio];
}

// Where a picture's corner is in the window, in whole pixels.
function cornerOf({ at, around }, pen) {
  return originOf(pen).map((value, axis) => Math.round(value - at[axis]) - around);
}

function covers(picture, pen) {
  const { width, height } = pen.context.canvas,
    [left, top] = cornerOf(picture, pen);
  return left <= 0 && top <= 0 && left + picture.canvas.width >= width && top + picture.canvas.height >= height;
}

// Many rows at once, a pixel wide and then widened, or a few, each of them as often as it is wide.
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

// Rows, a pixel wide, up and left of their place by half of the width that is to come, and aside from there.
function addThin({ own, pen, ratio, thick }, { x, y, from, to }, across, down) {
  const corner = (1 - thick) / 2;
  own.setTransform(ratio, 0, 0, ratio, corner + across, corner + down);
  line(pen, x, y, from, to);
  own.stroke();
}

// Makes all that is drawn as wide as it shall be, by copies that are as far aside as it is wide by then, at most.
function widen({ own, canvas, thick }) {
  own.setTransform(1, 0, 0, 1, 0, 0);
  for (let wide = 1; wide < thick; ) {
    const by = Math.min(wide, thick - wide);
    own.drawImage(canvas, by, 0);
    own.drawImage(canvas, 0, by);
    wide += by;
  }
}
