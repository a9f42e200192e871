// What is painted on the canvas of a map: cells, limits and their names, contours, the required region, axes and the point.
// Arrays have the force as first index and the speed as second; force runs to the right, speed upwards.
import { digits } from "./dom.js";

const EFFICIENCY = table("440154470d6048186a482374472e7c4538824241863e4a893a548c365d8d32658e2e6d8e2b758e287d8e25848e228c8d1f948c1e9c8920a38625ab822eb37c3aba7648c16e58c7656ccd5a7fd34e93d741a8db34c0df25d5e21aeae51afde725");
const CHANGE = table("67001f960f27bb2a34d25849e58368f5ac8bfbceb7fbe6daf6f7f7deebf2c0dceb98c8e068abd03e8cbf2870b115508d053061");
const LOSS = table("fffedffff9c6fff0adfee493fed26dfebd49fea332f88a21ed7215");
const HATCH = 7;  // distance of its lines [pixels]
const LEVELS = [0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

const TINTS = {
  light: { SLIP: "#dfe6ee", THERMAL: "#f4e3da", VOLTAGE: "#e7e2f3", STEERING: "#deecdc", SPEED: "#efe9d2", GEAR: "#f3dfe8", REGENERATION: "#d9eaea", PEAK: "#eedfd0", other: "#e8e8ea" },
  dark: { SLIP: "#2a3743", THERMAL: "#432f27", VOLTAGE: "#352f4c", STEERING: "#283b29", SPEED: "#3d3823", GEAR: "#432d39", REGENERATION: "#233b3c", PEAK: "#3f3222", other: "#2d3238" },
};
const CHANGED = { light: { better: "#9fdcc3", worse: "#f0aaa2" }, dark: { better: "#1f6a50", worse: "#7d3029" } };

/** 256 colours between those of a text of hexadecimal digits, as pixels (little endian: alpha, blue, green, red). */
function table(text) {
  const stops = text.match(/../g).map((one) => parseInt(one, 16));
  const last = stops.length / 3 - 1;
  return Uint32Array.from({ length: 256 }, (_, index) => {
    const place = (index / 255) * last;
    const low = Math.min(Math.floor(place), last - 1);
    const mixed = [0, 1, 2].map((channel) => stops[3 * low + channel] + (place - low) * (stops[3 * low + 3 + channel] - stops[3 * low + channel]));
    return pixel(...mixed);
  });
}

function pixel(red, green, blue) {
  return ((255 << 24) | (Math.round(blue) << 16) | (Math.round(green) << 8) | Math.round(red)) >>> 0;
}

const ofHex = (text) => pixel(parseInt(text.slice(1, 3), 16), parseInt(text.slice(3, 5), 16), parseInt(text.slice(5, 7), 16));

/** Colour of the region of a limit, by its name. */
export const tint = (name, dark) => TINTS[dark ? "dark" : "light"][name] ?? TINTS[dark ? "dark" : "light"].other;

/** Colours of regions that a change brought within limits, or beyond them. */
export const changed = (dark) => CHANGED[dark ? "dark" : "light"];

/** Fill a small canvas with the colours of a scale, from left to right. */
export function paintScale(canvas, kind) {
  const colours = { efficiency: EFFICIENCY, change: CHANGE, loss: LOSS }[kind];
  canvas.width = 256;
  canvas.height = 1;
  const image = new ImageData(256, 1);
  new Uint32Array(image.data.buffer).set(colours);
  canvas.getContext("2d").putImageData(image, 0, 0);
}

/** Upper end of the scale of losses that maps share, by the largest in their required regions; 0 if none is drawn. [W] */
export function lossReachOf(maps) {
  return 1.5 * Math.max(0, ...maps.filter((map) => map.loss !== undefined).map((map) => map.header.largest_loss));
}

/** An even end of a scale of changes that holds the largest one. [1] */
export function reachOf(largest) {
  return [0.01, 0.02, 0.05, 0.1, 0.2, 0.5].find((end) => largest <= end) ?? 1;
}

const scratch = document.createElement("canvas");

/** Paint an image scaled to a box. */
function paintImage(context, box, image) {
  if (scratch.width !== image.width || scratch.height !== image.height) [scratch.width, scratch.height] = [image.width, image.height];
  scratch.getContext("2d").putImageData(image, 0, 0);
  context.imageSmoothingEnabled = image.width < 0.9 * box.width;
  context.imageSmoothingQuality = "high";
  context.drawImage(scratch, box.left, box.top, box.width, box.height);
}

/** Give pixels without a colour that of a neighbour: the line of a limit crosses cells, and colours reach up to it. */
function spread(pixels, count) {
  const from = pixels.slice();
  for (let at = 0; at < from.length; at += 1) if (from[at] === 0) pixels[at] = (at % count && from[at - 1]) || ((at + 1) % count && from[at + 1]) || from[at - count] || from[at + count] || 0;
}

/** Paint the cells of a map, and over them what is beyond limits; returns how many cells each limit has. */
export function paintCells(context, box, map, { dark, surface, before = null, reach = 0.1, lossReach = 0 }) {
  const { efficiency, limit, loss, count } = map;
  const { limit_names: names } = map.header;
  const image = new ImageData(count, count);
  const pixels = new Uint32Array(image.data.buffer);
  const blank = ofHex(surface);
  const lossScale = lossReach > 0 ? 255 / lossReach : 0;
  const counts = new Uint32Array(names.length);
  const better = ofHex(changed(dark).better);
  for (let i = 0, index = 0; i < count; i += 1) {
    for (let j = count - 1; j >= 0; j -= 1, index += 1) {
      const cell = i * count + (count - 1 - j);
      const target = j * count + i;
      const code = limit[cell];
      counts[code] += 1;
      if (code !== 0) continue;
      const value = efficiency[cell];
      if (before !== null) {
        if (before.limit[cell] !== 0) pixels[target] = better;
        else {
          const change = value - before.efficiency[cell];
          pixels[target] = Number.isNaN(change) ? blank : CHANGE[Math.max(0, Math.min(255, Math.round(127.5 + (127.5 * change) / reach)))];
        }
      } else if (value === value) pixels[target] = EFFICIENCY[Math.max(0, Math.min(255, Math.round(255 * value)))];
      else if (loss !== undefined && loss[cell] === loss[cell]) pixels[target] = LOSS[Math.max(0, Math.min(255, Math.round(lossScale * loss[cell])))];
      else pixels[target] = blank;
    }
  }
  for (let ring = 0; ring < 2; ring += 1) spread(pixels, count);
  paintImage(context, box, image);
  paintBeyond(context, box, map, [...names.map((name) => tint(name, dark)), changed(dark).worse], (cell) => (before !== null && before.limit[cell] === 0 ? names.length : limit[cell]), dark);
  return counts;
}

/** Paint what is beyond limits, pixel by pixel, where margins fall below 1 between the centres of cells; oblique lines tell it without
 *  colours. `placeOf` is the place of a cell's colour among colours, as #rrggbb. */
function paintBeyond(context, box, { margin, limit, count }, colours, placeOf, dark) {
  const ratio = context.getTransform().a;
  const [width, height] = [box.width, box.height].map((side) => Math.round(side * ratio));
  const image = new ImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer);
  const plain = colours.map(ofHex);
  const lined = colours.map((hex) => pixel(...[1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16) + (dark ? 22 : -22))));
  const [period, line] = [HATCH, 1].map((one) => Math.round(one * ratio));
  // The cell before a place along an axis, and how far the place is on the way to the next; beyond the outer centres, these.
  const along = (place, size) => {
    const at = Math.min(Math.max(((place + 0.5) / size) * count - 0.5, 0), count - 1);
    const first = Math.min(Math.floor(at), count - 2);
    return [first, at - first];
  };
  const columns = Array.from({ length: width }, (_, x) => along(x, width));
  for (let y = 0; y < height; y += 1) {
    const [j, up] = along(height - 1 - y, height);
    for (let x = 0; x < width; x += 1) {
      const [i, right] = columns[x];
      const at = i * count + j;
      const below = margin[at] + right * (margin[at + count] - margin[at]);
      const above = margin[at + 1] + right * (margin[at + count + 1] - margin[at + 1]);
      if (below + up * (above - below) >= 1) continue;
      const nearest = at + (right < 0.5 ? 0 : count) + (up < 0.5 ? 0 : 1);
      const cell = limit[nearest] ? nearest : [at, at + 1, at + count, at + count + 1].find((one) => limit[one]);
      pixels[y * width + x] = ((x + y) % period < line ? lined : plain)[placeOf(cell)];
    }
  }
  paintImage(context, box, image);
}

/** Add the lines where values pass rising levels to a path, and call `seen` with a point of each piece and the place of its level;
 *  values that are nan have none. */
function trace(path, values, count, step, levels, x, y, seen = null) {
  const [least, most] = [levels[0], levels.at(-1)];
  for (let i = 0; i + step < count; i += step) {
    for (let j = 0, at = i * count; j + step < count; j += step, at += step) {
      const a = values[at];
      const b = values[at + step * count];
      const c = values[at + step * count + step];
      const d = values[at + step];
      const low = Math.min(a, b, c, d);
      const high = Math.max(a, b, c, d);
      if (!(high >= least && low < most)) continue;
      for (let k = 0; k < levels.length; k += 1) {
        const level = levels[k];
        if (high < level || low >= level) continue;
        let open = false;
        const put = (p, q) => {
          if (open) path.lineTo(x(p), y(q)); else path.moveTo(x(p), y(q));
          open = !open;
        };
        if (a >= level !== b >= level) put(i + (step * (level - a)) / (b - a), j);
        if (b >= level !== c >= level) put(i + step, j + (step * (level - b)) / (c - b));
        if (d >= level !== c >= level) put(i + (step * (level - d)) / (c - d), j + step);
        if (a >= level !== d >= level) put(i, j + (step * (level - a)) / (d - a));
        if (seen !== null) seen(i, j, k);
      }
    }
  }
}

/** Cells between the points that a line is traced through: finer is not seen. */
const stepOf = (count) => Math.max(1, Math.round(count / 100));

const placesOf = (box, count) => [
  (i) => box.left + (box.width * (i + 0.5)) / count,
  (j) => box.top + box.height - (box.height * (j + 0.5)) / count,
];

/** Lines between the regions of limits: bold where a limit is reached, dotted between two limits. */
export function paintEdges(context, box, { limit, margin, count }, colour, faint) {
  const bold = new Path2D();
  const thin = new Path2D();
  const [x, y] = placesOf(box, count);
  trace(bold, margin, count, stepOf(count), [1], x, y);
  for (let i = 0; i < count - 1; i += 1) {
    for (let j = 0, at = i * count; j < count - 1; j += 1, at += 1) {
      const a = limit[at];
      const b = limit[at + count];
      const d = limit[at + 1];
      if (a === 0 || b === 0 || d === 0 || (a === b && a === d) || (i + j) % 2) continue;
      thin.rect(x(i + 0.5) - 0.5, y(j + 0.5) - 0.5, 1, 1);
    }
  }
  context.fillStyle = faint;
  context.fill(thin);
  context.lineWidth = 2;
  context.lineCap = "round";
  context.strokeStyle = colour;
  context.stroke(bold);
}

/** Lines of equal efficiency with their percentages. */
export function paintContours(context, box, { efficiency, count }) {
  const path = new Path2D();
  const [x, y] = placesOf(box, count);
  const found = LEVELS.map(() => null);
  trace(path, efficiency, count, stepOf(count), LEVELS, x, y, (i, j, k) => {
    const off = Math.abs(i - j - 0.08 * count) + (Math.min(i, j) < 0.06 * count ? count : 0);
    if (off < (found[k]?.off ?? 0.25 * count)) found[k] = { off, level: LEVELS[k], x: x(i), y: y(j) };
  });
  const marks = [];
  for (const mark of found) if (mark !== null && marks.every((other) => Math.hypot(other.x - mark.x, other.y - mark.y) > 22)) marks.push(mark);
  context.strokeStyle = "rgb(255 255 255 / 70%)";
  context.lineWidth = 0.8;
  context.stroke(path);
  context.font = "600 10px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.lineJoin = "round";
  for (const mark of marks) {
    context.lineWidth = 3;
    context.strokeStyle = "rgb(20 30 60 / 55%)";
    context.strokeText(`${Math.round(100 * mark.level)} %`, mark.x, mark.y);
    context.fillStyle = "#fff";
    context.fillText(`${Math.round(100 * mark.level)} %`, mark.x, mark.y);
  }
}

function wrapped(context, text, width) {
  const lines = [];
  for (const word of text.split(" ")) {
    const joined = lines.length ? `${lines.at(-1)} ${word}` : word;
    if (lines.length && context.measureText(joined).width <= width) lines[lines.length - 1] = joined;
    else lines.push(word);
  }
  return lines;
}

/** How far the region of a label reaches from it to the left, right, down and up. [cells] */
function runs({ limit, count }, i, j) {
  const code = limit[i * count + j];
  const along = (di, dj) => {
    let steps = 0;
    for (let [k, l] = [i + di, j + dj]; k >= 0 && l >= 0 && k < count && l < count && limit[k * count + l] === code; k += di, l += dj) steps += 1;
    return steps;
  };
  return [along(-1, 0), along(1, 0), along(0, -1), along(0, 1)];
}

/** Name each limit within its region: level, upright in a narrow one, and not where it has no room; the legend names it anyway. */
export function paintNames(context, box, plane, map, dark, colour) {
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.lineJoin = "round";
  const size = box.width < 260 ? 10.5 : 11.5;
  const [across, up] = [box.width / map.count, box.height / map.count];
  context.font = `600 ${size}px system-ui, sans-serif`;
  for (const label of map.header.labels) {
    const index = (ends, value) => Math.min(Math.max(Math.floor(share(ends, value) * map.count), 0), map.count - 1);
    const [i, j] = [index(plane.force, label.force), index(plane.speed, label.speed)];
    const [left, right, down, above] = runs(map, i, j);
    const room = [2 * Math.min(left, right) * across, 2 * Math.min(down, above) * up];
    const whole = [(left + right) * across, (down + above) * up];
    const text = `beyond ${label.words}`;
    const fit = (width) => {
      const lines = wrapped(context, text, width);
      return { lines, width: Math.max(...lines.map((line) => context.measureText(line).width)), height: lines.length * (size + 2) };
    };
    const level = fit(Math.max(room[0], 0.8 * whole[0]) - 8);
    const upright = fit(0.85 * whole[1]);
    const isLevel = level.width <= whole[0] - 4 && level.height <= whole[1] - 2;
    if (!isLevel && !(upright.width <= whole[1] - 8 && upright.height <= whole[0] - 2)) continue;
    const { lines, width, height } = isLevel ? level : upright;
    const half = isLevel ? [width / 2, height / 2] : [height / 2, width / 2];
    const held = (value, low, high) => (low <= high ? Math.min(Math.max(value, low), high) : (low + high) / 2);
    const [x0, y0] = [box.left + (i + 0.5) * across, box.top + box.height - (j + 0.5) * up];
    const x = held(x0, x0 - left * across + half[0] + 3, x0 + right * across - half[0] - 3);
    const y = held(y0, y0 - above * up + half[1] + 3, y0 + down * up - half[1] - 3);
    context.save();
    context.translate(x, y);
    if (!isLevel) context.rotate(-Math.PI / 2);
    lines.forEach((line, k) => {
      const at = (k - (lines.length - 1) / 2) * (size + 2);
      context.lineWidth = 3;
      context.strokeStyle = tint(label.limit, dark);
      context.strokeText(line, 0, at);
      context.fillStyle = colour;
      context.fillText(line, 0, at);
    });
    context.restore();
  }
}

/** Where a value lies between two ends, 0 to 1. */
export const share = ([low, high], value) => (value - low) / (high - low);

/** Outline the required region in each quadrant required. */
export function paintRequired(context, box, plane, requirement, colour) {
  const path = new Path2D();
  for (const [across, along] of requirement.signs) {
    requirement.outline.forEach(([force, speed], index) => {
      const x = box.left + box.width * share(plane.force, across * force);
      const y = box.top + box.height * (1 - share(plane.speed, along * speed));
      if (index === 0) path.moveTo(x, y); else path.lineTo(x, y);
    });
  }
  context.save();
  context.beginPath();
  context.rect(box.left, box.top, box.width, box.height);
  context.clip();
  context.lineWidth = 4;
  context.strokeStyle = "rgb(255 255 255 / 85%)";
  context.stroke(path);
  context.lineWidth = 2;
  context.strokeStyle = colour;
  context.setLineDash([7, 4]);
  context.stroke(path);
  context.restore();
}

/** Even values for the marks of an axis. */
export function marksOf([low, high], most) {
  const rough = (high - low) / Math.max(1, most);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].map((one) => one * power).find((one) => one >= rough * 0.999);
  const first = Math.ceil(low / step - 1e-6);
  const found = [];
  for (let k = first; k * step <= high * (1 + 1e-9) + 1e-12; k += 1) found.push(Number((k * step).toPrecision(12)));
  return found;
}

/** Axes with names, units and marks. */
export function paintAxes(context, box, plane, { text, muted, line }) {
  context.strokeStyle = line;
  context.lineWidth = 1;
  context.strokeRect(box.left - 0.5, box.top - 0.5, box.width + 1, box.height + 1);
  context.fillStyle = muted;
  context.font = "11px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "top";
  context.beginPath();
  for (const value of marksOf(plane.force, box.width / 62)) {
    const x = box.left + box.width * share(plane.force, value);
    context.moveTo(x, box.top + box.height);
    context.lineTo(x, box.top + box.height + 4);
    context.fillText(digits(value, 3), x, box.top + box.height + 6);
  }
  context.textAlign = "right";
  context.textBaseline = "middle";
  for (const value of marksOf(plane.speed, box.height / 42)) {
    const y = box.top + box.height * (1 - share(plane.speed, value));
    context.moveTo(box.left, y);
    context.lineTo(box.left - 4, y);
    context.fillText(digits(value, 3), box.left - 6, y);
  }
  context.stroke();
  context.fillStyle = text;
  context.font = "11.5px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "alphabetic";
  context.fillText(`${plane.force_name} on the load [${plane.force_unit}]`, box.left + box.width / 2, box.top + box.height + 32);
  context.save();
  context.translate(11, box.top + box.height / 2);
  context.rotate(-Math.PI / 2);
  context.fillText(`${plane.speed_name} of the load [${plane.speed_unit}]`, 0, 0);
  context.restore();
}

/** Cross hairs at a point. */
export function paintPoint(context, box, plane, point, fixed) {
  const x = box.left + box.width * share(plane.force, point.force);
  const y = box.top + box.height * (1 - share(plane.speed, point.speed));
  if (x < box.left || x > box.left + box.width || y < box.top || y > box.top + box.height) return;
  const lines = new Path2D();
  lines.moveTo(box.left, y);
  lines.lineTo(x - 7, y);
  lines.moveTo(x + 7, y);
  lines.lineTo(box.left + box.width, y);
  lines.moveTo(x, box.top);
  lines.lineTo(x, y - 7);
  lines.moveTo(x, y + 7);
  lines.lineTo(x, box.top + box.height);
  context.lineWidth = 2.5;
  context.strokeStyle = "rgb(255 255 255 / 60%)";
  context.stroke(lines);
  context.lineWidth = 1;
  context.strokeStyle = "rgb(0 0 0 / 75%)";
  context.setLineDash([3, 3]);
  context.stroke(lines);
  context.setLineDash([]);
  context.beginPath();
  context.arc(x, y, 6, 0, 2 * Math.PI);
  context.lineWidth = 4;
  context.strokeStyle = "#fff";
  context.stroke();
  context.lineWidth = 2;
  context.strokeStyle = "#111";
  context.stroke();
  if (fixed) { context.fillStyle = "#fff"; context.fill(); context.beginPath(); context.arc(x, y, 2.5, 0, 2 * Math.PI); context.fillStyle = "#111"; context.fill(); }
}
