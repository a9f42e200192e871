// The plane of frequency and power: which shaking of a mass each drive can do, and how well.
import { digits, make } from "../dom.js";
import { paintScale, tint } from "../paint.js";
import { axes, numbers, onWidth, replace, svg, useStyles, withUnit } from "./shared.js";

const SERIES = 6;
const FREQUENCIES = [0.1, 0.3, 1, 3, 10, 30];

export function create(container) {
  useStyles();
  const head = make("div");
  const maps = make("div", { className: "planes" });
  const edges = make("div");
  const below = make("div");
  container.replaceChildren(head, maps, edges, below);
  let model = null;
  const end = onWidth(maps, () => draw());

  function draw() {
    if (model === null || model.header.reason !== null || maps.clientWidth === 0) return;
    const names = Object.keys(model.header.drives);
    const known = names.filter((name) => `${name}/performance` in model.arrays);
    const width = Math.min(460, Math.floor(maps.clientWidth / Math.max(1, Math.min(known.length, Math.floor(maps.clientWidth / 300) || 1))) - 12);
    replace(maps, ...names.map((name) => (known.includes(name) ? map(model, name, width) : make("p", { className: "blank" }, model.header.drives[name].fault))));
    replace(edges, ...(known.length > 1 ? boundaries(model, known, Math.min(edges.clientWidth || width, 760)) : []));
    replace(below, table(model, known));
  }

  return {
    update(next) {
      model = next;
      const { header } = model;
      for (const one of [maps, edges, below]) one.hidden = header.reason !== null;
      if (header.reason !== null) { replace(head, make("p", { className: "blank" }, header.reason)); return; }
      const over = Object.values(header.drives).some((one) => one.best > 1);
      const scale = make("canvas", { className: over ? "ramp over" : "ramp", aria: { hidden: "true" } });
      paintScale(scale, "efficiency");
      replace(head, make("p", { className: "view-head" }, make("strong", {}, `Shaking ${withUnit(header.load_mass, header.mass_unit)}`),
        make("span", {}, `to and fro, over frequency and RMS power up to ${withUnit(header.power, "W")}`),
        make("span", { className: "scale" }, "performance 0", scale, over ? "1 or more" : "1")));
      draw();
    },
    destroy() { end(); },
  };
}

const tintOf = (words, dark) => tint(NAMES.find(([text]) => words.includes(text))?.[1] ?? "other", dark);
const NAMES = [["slip", "SLIP"], ["continuous torque", "THERMAL"], ["voltage", "VOLTAGE"], ["steering range", "STEERING"], ["speed", "SPEED"], ["gearhead", "GEAR"], ["regeneration", "REGENERATION"], ["peak", "PEAK"]];

function frame(header, width, height) {
  return axes({ width, height, logarithmic: true, x: { low: 0.1, high: 30, label: "frequency [Hz]", ticks: FREQUENCIES }, y: { low: 0, high: header.power, label: "RMS power [W]" } });
}

/** The plane of one drive: performance as colours, limits as tints with their names. */
function map({ header, arrays, theme }, name, width) {
  const row = header.drives[name];
  const height = Math.round(0.66 * width) + 30;
  const place = frame(header, width, height);
  const { frequency, power } = arrays;
  const [count, limit] = [frequency.length, arrays[`${name}/limit`]];
  const performance = arrays[`${name}/performance`];
  const canvas = make("canvas", { width: count, height: power.length });
  const context = canvas.getContext("2d");
  const ramp = make("canvas");
  paintScale(ramp, "efficiency");
  const colours = ramp.getContext("2d").getImageData(0, 0, 256, 1).data;
  const image = context.createImageData(count, power.length);
  const sums = {};
  for (let j = 0; j < power.length; j += 1) {
    for (let i = 0; i < count; i += 1) {
      const at = j * count + i;
      const pixel = 4 * ((power.length - 1 - j) * count + i);
      const code = limit[at];
      let rgb;
      if (code > 0) {
        const words = row.limits[code - 1];
        const hex = tintOf(words, theme.dark);
        rgb = [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
        const sum = (sums[words] ??= { x: 0, y: 0, n: 0 });
        sum.x += i; sum.y += j; sum.n += 1;
      } else {
        const k = 4 * Math.max(0, Math.min(255, Math.round(255 * performance[at])));
        rgb = [colours[k], colours[k + 1], colours[k + 2]];
      }
      image.data.set([...rgb, 255], pixel);
    }
  }
  context.putImageData(image, 0, 0);
  const { inner } = place;
  const cell = inner.width / count;
  const labels = Object.entries(sums).filter(([words, { x, y, n }]) => fits(words, Math.round(x / n), Math.round(y / n))).map(([words, { x, y, n }]) =>
    svg("text", { class: "region", x: inner.left + cell * (x / n + 0.5), y: inner.top + inner.height * (1 - (y / n + 0.5) / power.length), "text-anchor": "middle" }, words));
  const legend = make("ul", { className: "legend" }, ...Object.keys(sums).map((words) => {
    const swatch = make("span", { className: "swatch" });
    swatch.style.background = tintOf(words, theme.dark);
    return make("li", {}, swatch, words);
  }));

  /** Whether the name of a region fits between its ends to the left and to the right of its middle. */
  function fits(words, x, y) {
    const own = row.limits.indexOf(words) + 1;
    const half = Math.ceil((3.2 * words.length + 4) / cell);
    for (let i = x - half; i <= x + half; i += 1) if (i < 0 || i >= count || limit[y * count + i] !== own) return false;
    return true;
  }
  const picture = svg("svg", { viewBox: `0 0 ${width} ${height}`, width, height, class: "drawn", role: "img", "aria-label": `${row.title}: within limits in ${(100 * row.share).toFixed(0)} % of the plane, best performance ${digits(row.best ?? NaN, 2)}` },
    svg("image", { href: canvas.toDataURL(), x: inner.left, y: inner.top, width: inner.width, height: inner.height, preserveAspectRatio: "none", class: "pixels" }), ...place.parts, ...labels);
  const readout = make("p", { className: "values" }, `within limits in ${(100 * row.share).toFixed(0)} % of the plane; best performance ${digits(row.best ?? NaN, 2)}`);
  const usual = readout.textContent;
  picture.addEventListener("pointermove", (event) => {
    const box = picture.getBoundingClientRect();
    const i = Math.floor((((event.clientX - box.left) * width) / box.width - inner.left) / inner.width * count);
    const j = Math.floor((1 - (((event.clientY - box.top) * height) / box.height - inner.top) / inner.height) * power.length);
    if (i < 0 || j < 0 || i >= count || j >= power.length) { readout.textContent = usual; return; }
    const at = j * count + i;
    const state = limit[at] ? `beyond ${row.limits[limit[at] - 1]}` : `performance ${digits(performance[at], 2)}`;
    readout.textContent = `${withUnit(frequency[i], "Hz", 2)}, ${withUnit(power[j], "W", 2)}: ${state}`;
  });
  picture.addEventListener("pointerleave", () => { readout.textContent = usual; });
  const figure = make("figure", { className: "plane" }, make("figcaption", {}, row.title), picture, legend, readout);
  figure.style.width = `${width}px`;
  return figure;
}

/** The largest power of each drive over frequency, in one chart. */
function boundaries({ header, arrays }, names, width) {
  const height = 250;
  const place = frame(header, width, height);
  const order = Object.keys(header.drives);
  const lines = names.map((name) => svg("polyline", { class: `edge stroke-${(order.indexOf(name) % SERIES) + 1}`, points: Array.from(arrays.frequency, (one, k) => `${place.x(one).toFixed(1)},${place.y(arrays[`${name}/edge`][k]).toFixed(1)}`).join(" ") }));
  const title = "Largest power within all limits, by frequency";
  return [
    make("h3", {}, title),
    svg("svg", { viewBox: `0 0 ${width} ${height}`, width, height, class: "drawn", role: "img", "aria-label": `${title}: ${names.map((name) => header.drives[name].title).join(", ")}` }, ...place.parts, ...lines),
    make("ul", { className: "legend" }, ...names.map((name) => make("li", {}, make("span", { className: `mark series-${(order.indexOf(name) % SERIES) + 1}` }), header.drives[name].title))),
  ];
}

function table({ header, arrays }, names) {
  const at = FREQUENCIES.map((wanted) => arrays.frequency.reduce((best, one, k) => (Math.abs(Math.log(one / wanted)) < Math.abs(Math.log(arrays.frequency[best] / wanted)) ? k : best), 0));
  const rows = at.map((k) => [withUnit(arrays.frequency[k], "Hz", 2), ...names.map((name) => (arrays[`${name}/edge`][k] > 0 ? withUnit(arrays[`${name}/edge`][k], "W") : "none"))]);
  return numbers("Largest power within all limits as a table", ["frequency", ...names.map((name) => header.drives[name].title)], rows);
}
