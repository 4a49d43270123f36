/**
 * Returns a pattern as a picture with one pixel per cell, which is kept with the pattern.
 * @param {Pattern} pattern
 * @param {Record<string, string>} colours
 * @returns {OffscreenCanvas}
 */
export function pictureOf(pattern, colours) {
  const { width, height, cells } = pattern,
    key = `${colours.focus} ${colours.floor}`;
  if (pattern.picture && pattern.pictured === key) return pattern.picture;
  const picture = new OffscreenCanvas(width, height);
  const context = /** @type {OffscreenCanvasRenderingContext2D} */ (picture.getContext("2d"));
  const image = context.createImageData(width, height);
  const shades = new Uint32Array(image.data.buffer);
  const kinds = [shadeOf(colours.floor), shadeOf(colours.focus), 0];
  cells.forEach((cell, k) => {
    shades[(height - 1 - Math.floor(k / width)) * width + (k % width)] = kinds[cell];
  });
  context.putImageData(image, 0, 0);
  Object.assign(pattern, { picture, pictured: key });
  return picture;
}

// Returns a colour as a pixel.
function shadeOf(colour) {
  const context = /** @type {OffscreenCanvasRenderingContext2D} */ (new OffscreenCanvas(1, 1).getContext("2d"));
  context.fillStyle = colour;
  context.fillRect(0, 0, 1, 1);
  return new Uint32Array(context.getImageData(0, 0, 1, 1).data.buffer)[0];
}
