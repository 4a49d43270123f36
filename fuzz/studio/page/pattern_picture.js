/** A pattern as a picture of one pixel a cell, kept with it. */
export function pictureOf(pattern, colours) {
  const { width, height, cells } = pattern,
    key = `${colours.focus} ${colours.floor}`;
  if (pattern.pictured !== key) {
    pattern.pictured = key;
    pattern.picture = new OffscreenCanvas(width, height);
    const context = pattern.picture.getContext("2d"),
      image = context.createImageData(width, height),
      shades = new Uint32Array(image.data.buffer);
    const kinds = [shadeOf(colours.floor), shadeOf(colours.focus), 0];
    cells.forEach((cell, k) => {
      shades[(height - 1 - Math.floor(k / width)) * width + (k % width)] = kinds[cell];
    });
    context.putImageData(image, 0, 0);
  }
  return pattern.picture;
}

// A colour as a pixel.
function shadeOf(colour) {
  const context = new OffscreenCanvas(1, 1).getContext("2d");
  context.fillStyle = colour;
  context.fillRect(0, 0, 1, 1);
  return new Uint32Array(context.getImageData(0, 0, 1, 1).data.buffer)[0];
}
