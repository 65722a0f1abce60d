// The ground of an arena: grid, tasks and walls, drawn once until something of it changes.

/**
 * Decode the image of a plan.
 * @param {Plan} plan
 */
export function imageOf({ image }) {
  return createImageBitmap(
    new Blob([Uint8Array.from(atob(image), (each) => each.charCodeAt(0))], { type: "image/png" }),
  );
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Arena} arena
 * @param {Frame} now Whose tasks are drawn.
 */
export function drawGround(context, arena, now) {
  const { width, height, longer, colours, scale, ratio, world } = arena;
  context.fillStyle = colours.ground;
  context.fillRect(0, 0, width, height);
  context.strokeStyle = colours.line;
  context.lineWidth = ratio;
  context.beginPath();
  const gap = gapOf(longer);
  for (let at = gap; at * scale < Math.max(width, height) - 1; at += gap) {
    const x = Math.round(at * scale) + 0.5,
      y = Math.round(height - at * scale) + 0.5;
    context.moveTo(x, 0);
    context.lineTo(x, height);
    context.moveTo(0, y);
    context.lineTo(width, y);
  }
  context.stroke();
  if (world.plan) drawPlan(context, arena, world.plan);
  drawTasks(context, arena, now);
  if (world.walls) {
    context.strokeStyle = colours.ink;
    context.lineWidth = 6 * ratio; // half of it is outside
    context.strokeRect(0, 0, width, height);
  }
}

/**
 * Return the spacing of the grid: 1, 2 or 5 times a power of ten, so that the longer side has 8 to 20 cells.
 * @param {number} side
 */
export function gapOf(side) {
  const power = 10 ** Math.floor(Math.log10(side / 8));
  return power * ([5, 2].find((each) => each * power <= side / 8) ?? 1);
}

/**
 * Draw zones with their names, no-go cells and walls; the cells as soon as their image is decoded.
 * @param {CanvasRenderingContext2D} context
 * @param {Arena} arena
 * @param {Plan} plan
 */
function drawPlan(context, { plan: image, height, colours, scale, ratio }, { size, zones }) {
  context.fillStyle = context.strokeStyle = colours.zone;
  context.lineWidth = 1.5 * ratio;
  for (const { polygons } of zones) {
    const path = outlineOf(polygons, scale, height);
    context.globalAlpha = 0.12;
    context.fill(path);
    context.globalAlpha = 1;
    context.stroke(path);
  }
  context.fillStyle = colours.ink;
  context.font = `${12 * ratio}px system-ui, sans-serif`;
  context.textBaseline = "top";
  for (const { name, at } of zones)
    context.fillText(name, at[0] * scale + 5 * ratio, height - at[1] * scale + 5 * ratio);
  if (!image) return;
  const inked = new OffscreenCanvas(image.width, image.height),
    pen = /** @type {OffscreenCanvasRenderingContext2D} */ (inked.getContext("2d"));
  pen.drawImage(image, 0, 0);
  pen.globalCompositeOperation = "source-in"; // its opacity, in the ink of the theme
  pen.fillStyle = colours.ink;
  pen.fillRect(0, 0, image.width, image.height);
  const [wide, tall] = [size[0] * scale, size[1] * scale];
  context.imageSmoothingEnabled = wide < image.width;
  context.imageSmoothingQuality = "high";
  context.drawImage(inked, 0, height - tall, wide, tall);
}

/**
 * Return the outline of polygons in units, in pixels.
 * @param {[number, number][][]} polygons
 * @param {number} scale
 * @param {number} height
 */
export function outlineOf(polygons, scale, height) {
  const corners = polygons.map((each) => each.map(([x, y]) => `${x * scale} ${height - y * scale}`));
  return new Path2D(corners.map((each) => `M${each.join("L")}Z`).join(""));
}

/**
 * Draw the tasks; if robots act, those that are done, then those that are taken, and on top, hollow, free ones.
 * @param {CanvasRenderingContext2D} context
 * @param {Arena} arena
 * @param {Frame} now
 */
function drawTasks(context, { ratio, scale, unit, width, height, colours }, { taskX, taskY, taken }) {
  const few = 0.1 * Math.sqrt((width * height) / Math.max(1, taskX.length)), // in a large hall, few tasks are drawn larger
    least = Math.max(1.5 * ratio, Math.min(4.5 * ratio, few)),
    size = Math.max(least, Math.min(0.42 * scale, 9 * ratio)),
    small = size < 4 * ratio,
    fills = [small ? colours.ink : colours.ground, colours.task, colours.muted];
  for (const which of taken ? [2, 1, 0] : [1]) {
    context.fillStyle = fills[which];
    if (small) context.globalAlpha = 0.5; // many tasks would hide the robots
    context.beginPath();
    for (let i = 0; i < taskX.length; i++) {
      if (taken && taken[i] !== which) continue;
      const left = taskX[i] * unit,
        top = height - taskY[i] * unit;
      context.moveTo(left, top - size);
      context.lineTo(left + 0.92 * size, top + 0.66 * size);
      context.lineTo(left - 0.92 * size, top + 0.66 * size);
      context.closePath();
    }
    context.fill();
    context.globalAlpha = 1;
    if (small) continue;
    context.strokeStyle = taken ? colours.ink : colours.ground;
    context.lineWidth = (taken ? 1.3 : 0.8) * ratio;
    context.stroke();
  }
}
