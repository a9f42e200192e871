// The rolling contact: where the wheel stands on its creep curve, and the patch to scale with its areas of stick and slip.
import { digits, make } from "../dom.js";
import { axes, heading, line, numbers, onWidth, picture, replace, svg, terms, useStyles, withUnit } from "./shared.js";

/** Pixels of a style sheet in a millimetre. */
const PIXELS = 96 / 25.4;

export function create(container, host) {
  useStyles();
  const head = make("div");
  const curve = make("div");
  const patch = make("div");
  const words = make("div");
  container.replaceChildren(head, make("div", { className: "three" }, curve, patch, words));
  let model = null;
  const ends = [onWidth(curve, () => draw()), onWidth(patch, () => draw())];

  function draw() {
    if (model === null || model.header.reason !== null) return;
    if (curve.clientWidth) replace(curve, ...creepCurve(model, Math.min(curve.clientWidth, 520)));
    if (patch.clientWidth) replace(patch, ...patchDrawn(model, Math.min(patch.clientWidth, 440)));
  }

  return {
    update(next) {
      model = next;
      const { header } = model;
      for (const one of [curve, patch, words]) one.hidden = header.reason !== null;
      if (header.reason !== null) { replace(head, heading(header), make("p", { className: "blank" }, header.reason)); return; }
      const slip = header.slips ? `${header.wheel}: slips` : `${header.wheel}: ${(100 * header.slip_demand).toFixed(0)} % of the slip limit`;
      replace(head, heading(header, slip, header.slips ? false : null), chooser(header, host));
      draw();
      replace(words, make("h3", {}, "In numbers"), terms(header.state));
    },
    destroy() { for (const end of ends) end(); },
  };
}

/** A choice among the wheels of a machine. */
function chooser(header, host) {
  if (header.wheels.length < 2) return null;
  const select = make("select", { data: { key: "wheel" }, on: { change: (event) => host.ask({ part: Number(event.target.value) }) } },
    ...header.wheels.map((name, place) => make("option", { value: String(place + 1), selected: name === header.wheel }, name)));
  return make("label", { className: "choice" }, "Wheel ", select);
}

function creepCurve({ header, arrays }, width) {
  const height = Math.max(230, Math.round(0.62 * width));
  const last = arrays.creepage.at(-1);
  const place = axes({ width, height, x: { low: 0, high: last, label: "creepage [‰]" }, y: { low: 0, high: 1.12 * header.slip_force, label: `${header.force_name} [N]` } });
  const edge = place.inner.left + place.inner.width;
  const items = [
    ...place.parts,
    svg("rect", { class: "beyond", x: place.x(header.slip_creepage), y: place.inner.top, width: Math.max(0, edge - place.x(header.slip_creepage)), height: place.inner.height }),
    svg("line", { class: "limit", x1: place.inner.left, x2: edge, y1: place.y(header.slip_force), y2: place.y(header.slip_force) }),
    svg("text", { class: "note", x: place.inner.left + 6, y: place.y(header.slip_force) - 5 }, `slip limit μP = ${withUnit(header.slip_force, "N")}`),
    svg("text", { class: "note", x: edge - 5, y: place.inner.top + place.inner.height - 8, "text-anchor": "end" }, "slips"),
    svg("polyline", { class: "faint", points: line(arrays.creepage, arrays.linear, place) }),
    svg("polyline", { class: "curve", points: line(arrays.creepage, arrays.force, place) }),
  ];
  let at = "The wheel slips here: it has no place on the curve.";
  if (header.point !== null) {
    const { creepage, force } = header.point;
    const [x, y] = [place.x(creepage), place.y(force)];
    at = `The wheel is at ${withUnit(creepage, "‰")} and ${withUnit(force, "N")}.`;
    items.push(svg("path", { class: "drop", d: `M${place.inner.left} ${y}H${x}V${place.inner.top + place.inner.height}` }), svg("circle", { class: "here", cx: x, cy: y, r: 5.5 }));
    const far = x > place.inner.left + 0.6 * place.inner.width;
    items.push(svg("text", { class: "callout", x: x + (far ? -10 : 10), y: Math.min(y + 18, place.inner.top + place.inner.height - 6), "text-anchor": far ? "end" : "start" }, `${withUnit(force, "N")} at ${withUnit(creepage, "‰")}`));
  }
  const title = `Creep curve, law “${header.law}”`;
  const step = Math.max(1, Math.floor(arrays.creepage.length / 10));
  const rows = [];
  for (let k = 0; k < arrays.creepage.length; k += step) rows.push([withUnit(arrays.creepage[k], "‰"), withUnit(arrays.force[k], "N")]);
  return [
    make("h3", {}, title),
    picture(width, height, title, `${header.force_name} over creepage, up to the slip limit of ${withUnit(header.slip_force, "N")}. ${at}`, ...items),
    header.law === "linear" || header.law === "faulring" ? null : make("p", { className: "small" }, "Thin line: without slip within the patch."),
    numbers("Curve as a table", ["creepage", header.force_name], rows),
  ].filter(Boolean);
}

function patchDrawn({ header, arrays }, width) {
  const title = "Contact patch from above, to scale";
  if (header.patch === null) return [make("h3", {}, "Contact patch"), make("p", { className: "blank" }, header.patch_reason)];
  const { patch } = header;
  const outline = arrays["patch/outline"];
  const n = outline.length / 2;
  const reach = [0, 1].map((axis) => Math.max(...outline.subarray(axis * n, (axis + 1) * n).map(Math.abs)));
  const scale = Math.min((width - 60) / (2 * reach[0]), 250 / (2 * reach[1]));
  const high = 2 * reach[1] * scale + 76;
  const middle = { x: width / 2, y: reach[1] * scale + 26 };
  const x = (value) => middle.x + scale * value;
  const y = (value) => middle.y - scale * value;
  const path = Array.from({ length: n }, (_, k) => `${k ? "L" : "M"}${x(outline[k]).toFixed(1)} ${y(outline[n + k]).toFixed(1)}`).join("") + "Z";
  const clip = `patch-${Math.random().toString(36).slice(2)}`;
  const [rows, cells] = arrays["patch/x"].shape;
  const painted = [];
  for (let row = 0; row < rows; row += 1) {
    const length = arrays["patch/length"][row];
    for (let cell = 0; cell < cells; cell += 1) {
      const at = row * cells + cell;
      // Cells at the edge reach beyond it, to be clipped there.
      const [before, after] = [cell === 0 ? 2 * length : 0, cell === cells - 1 ? 2 * length : 0];
      const [under, over] = [row === 0 ? patch.width : 0, row === rows - 1 ? patch.width : 0];
      const [from, to] = [x(arrays["patch/x"][at] - length / 2 - before), x(arrays["patch/x"][at] + length / 2 + after)].map(Math.round);
      const [top, bottom] = [y(arrays["patch/y"][at] + patch.width / 2 + over), y(arrays["patch/y"][at] - patch.width / 2 - under)].map(Math.round);
      painted.push(svg("rect", {
        class: arrays["patch/slides"][at] ? "slips" : "sticks", x: from, y: top, width: to - from, height: bottom - top,
        "fill-opacity": (0.16 + 0.74 * Math.min(1, arrays["patch/share"][at])).toFixed(2),
      }));
    }
  }
  const bar = roundBelow((0.5 * (width - 60)) / scale);
  const low = high - 18;
  const items = [
    svg("clipPath", { id: clip }, svg("path", { d: path })),
    svg("g", { class: "cells", "clip-path": `url(#${clip})` }, ...painted),
    svg("path", { class: "outline", d: path }),
    ...arrows(arrays, x, y, scale, rows, cells, reach[0] / 9),
    svg("path", { class: "axisarrow", d: `M${x(0.1 * reach[0])} 12H${x(0.72 * reach[0])}m-7 -4l7 4l-7 4` }),
    svg("text", { class: "note", x: x(0.02 * reach[0]), y: 16, "text-anchor": "end" }, "wheel rolls"),
    svg("path", { class: "bar", d: `M${middle.x - (bar * scale) / 2} ${low}h${bar * scale}m0 -4v8m${-bar * scale} -8v8` }),
    svg("text", { class: "note", x: middle.x, y: low + 15, "text-anchor": "middle" }, `${digits(1000 * bar, 3)} µm`),
  ];
  const share = `${(100 * patch.slip_share).toFixed(0)} %`;
  const text = `Ellipse of ${withUnit(2000 * patch.a, "µm")} along rolling by ${withUnit(2000 * patch.b, "µm")} across, peak pressure ${withUnit(patch.peak_pressure, "GPa")}; it slips in ${share} of its area, at the trailing edge.`;
  return [
    make("h3", {}, title),
    picture(width, high, title, text, ...items),
    make("ul", { className: "legend" }, key("sticks", "sticks"), key("slips", `slips (${share} of the area)`), make("li", {}, "arrows: traction on the surface")),
    make("p", { className: "small" }, `${header.slips ? "Beyond the slip limit the whole patch slides." : "Exact rolling theory, for the force at this point; deeper colour: nearer to the friction limit."} About ${digits(scale / PIXELS, 2)} times its size.`),
  ];
}

function key(look, text) {
  return make("li", {}, svg("svg", { width: 12, height: 12, "aria-hidden": "true", class: "drawn" }, svg("rect", { class: look, width: 12, height: 12, "fill-opacity": 0.8 })), text);
}

/** Tractions as arrows in some of the cells. */
function arrows(arrays, x, y, scale, rows, cells, longest) {
  const traction = arrays["patch/traction"];
  const size = rows * cells;
  let most = 0;
  for (let k = 0; k < size; k += 1) most = Math.max(most, Math.hypot(traction[k], traction[size + k]));
  if (!(most > 0)) return [];
  const found = [];
  const step = 3;
  for (let row = 1; row < rows; row += step) {
    for (let cell = 1; cell < cells; cell += step) {
      const k = row * cells + cell;
      const [u, v] = [traction[k] / most, traction[size + k] / most];
      const long = Math.hypot(u, v) * longest * scale * 1.6;
      if (long < 4) continue;
      const turned = (-Math.atan2(v, u) * 180) / Math.PI;
      found.push(svg("path", { class: "traction", transform: `translate(${x(arrays["patch/x"][k]).toFixed(1)} ${y(arrays["patch/y"][k]).toFixed(1)}) rotate(${turned.toFixed(1)})`, d: `M${-long / 2} 0H${long / 2}m-4 -2.6l4 2.6l-4 2.6` }));
    }
  }
  return found;
}

function roundBelow(wanted) {
  const power = 10 ** Math.floor(Math.log10(wanted));
  return [5, 2, 1].map((one) => one * power).find((one) => one <= wanted * 1.0001);
}
