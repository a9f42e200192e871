// The power balance from the supply to the load: a band as wide as the power, from which the losses branch off.
import { make } from "../dom.js";
import { mendBox } from "../mend.js";
import { heading, numbers, onWidth, picture, replace, svg, terms, useStyles, withUnit } from "./shared.js";

const BEND = 9;
const ROW = 18;
const BOX = 26;

export function create(container, host) {
  useStyles();
  const flow = make("div", { className: "flow" });
  const beside = make("div", { className: "beside" });
  const head = make("div");
  const below = make("div");
  container.replaceChildren(head, make("div", { className: "two" }, flow, beside), below);
  let header = null;
  const end = onWidth(flow, () => draw());

  function draw() {
    if (header === null || flow.clientWidth === 0) return;
    const width = Math.min(flow.clientWidth, 620);
    replace(flow, header.flows.length ? sankey(header, width) : make("p", { className: "blank" }, "No steady motion is possible here, so that there are no flows to show."), header.flows.length ? table(header) : null);
  }

  return {
    update(model) {
      header = model.header;
      const { name, tables, drive, speed, force } = host.document;
      const mendable = !header.feasible && header.parts === null && Number.isFinite(speed);
      replace(head, heading(header, header.verdict, header.feasible),
        mendable ? mendBox({ ask: () => host.call("mend", { name, tables, drive, speed, force }), apply: host.apply }) : null);
      draw();
      replace(beside, ...shares(header), make("h3", {}, "Operating point"), terms([...(header.flows.length ? sums(header) : []), ...header.state.filter(({ text }) => text !== "–")]));
      replace(below, ...parts(header));
    },
    destroy() { end(); },
  };
}

/** Powers between neighbours, positive from the supply to the load, and the losses of each stage. */
function balanceOf({ stages, flows }) {
  const powers = stages.slice(1).map((after, place) => {
    const flow = flows.find((one) => one.kind === "power" && ((one.from === stages[place] && one.to === after) || (one.to === stages[place] && one.from === after)));
    return flow.from === stages[place] ? flow.watts : -flow.watts;
  });
  const losses = stages.map((stage) => flows.filter((one) => one.kind === "loss" && one.from === stage));
  return { powers, losses };
}

function sankey(header, width) {
  const { stages } = header;
  const { powers, losses } = balanceOf(header);
  const left = width < 480 ? 96 : 132;
  const band = Math.min(150, 0.27 * width);
  const branch = left + band + 24;
  const scale = band / Math.max(...powers.map(Math.abs), 1e-12);
  const items = [];
  const bands = [];
  let y = BOX;
  items.push(end(stages[0], powers[0], 0, left, band, scale));
  stages.slice(1, -1).forEach((stage, k) => {
    const rows = ribbonsOf(losses[k + 1], powers[k], powers[k + 1]);
    const heights = rows.map((row) => Math.max(scale * row.watts, 1.6));
    const spaces = rows.map((row, place) => Math.max(heights[place] + 4, row.label ? ROW : heights[place]));
    const gap = 20;
    const height = Math.max(BEND + spaces.reduce((sum, one) => sum + one, 0) + 6, 34);
    items.push(between(powers[k], y, gap, left, scale, bands));
    y += gap;
    const above = Math.max(scale * Math.max(powers[k], 0), 0);
    const below = Math.max(scale * Math.max(-powers[k + 1], 0), 0);
    const through = powers[k] > 0 && powers[k + 1] > 0 ? scale * powers[k + 1] : powers[k] < 0 && powers[k + 1] < 0 ? scale * -powers[k] : 0;
    if (through > 0) bands.push(svg("rect", { class: "power", x: left, y, width: Math.max(through, 1), height }));
    items.push(svg("text", { class: "stage", x: left - 10, y: y + height / 2 + 4, "text-anchor": "end" }, stage));
    items.push(svg("line", { class: "rule", x1: left - 6, x2: left, y1: y + height / 2, y2: y + height / 2 }));
    // From above the outermost part of the band branches off first; from below, last.
    let down = above;
    let up = below - rows.filter((row) => !row.fromAbove).reduce((sum, row) => sum + scale * row.watts, 0);
    let top = y + BEND;
    rows.forEach((row, place) => {
      const thick = Math.max(scale * row.watts, 0);
      const at = top + (spaces[place] - heights[place]) / 2;
      if (row.fromAbove) { down -= thick; bands.push(ribbon(left + down, left + down + thick, y, at, heights[place], branch, 1, row)); } else {
        bands.push(ribbon(left + up, left + up + thick, y + height, at + heights[place], heights[place], branch, -1, row));
        up += thick;
      }
      if (row.label) {
        items.push(svg("text", { class: "loss", x: branch + 6, y: top + spaces[place] / 2 + 4 }, row.label, svg("tspan", { class: "watts", dx: 7 }, withUnit(row.total, "W"))));
      }
      top += spaces[place];
    });
    y += height;
  });
  const last = powers.at(-1);
  items.push(between(last, y, 20, left, scale, bands));
  y += 20;
  items.push(end(stages.at(-1), last, y, left, band, scale));
  const description = describe(header, powers);
  return picture(width, y + BOX, `Power balance of ${header.title} at ${header.place}`, description, ...bands, ...items);
}

/** Losses as ribbons, from the top down: those fed from above, then those fed from below; one may be fed from both. */
function ribbonsOf(losses, above, below) {
  const shown = losses.filter((one) => one.watts > 0);
  const total = shown.reduce((sum, one) => sum + one.watts, 0);
  let rest = above > 0 ? (below > 0 ? total : Math.min(above, total)) : 0;
  const rows = [];
  for (const one of shown) {
    const fed = Math.min(rest, one.watts);
    rest -= fed;
    const both = fed > 0 && one.watts - fed > 1e-9 * total;
    if (fed > 0) rows.push({ ...one, watts: fed, total: one.watts, fromAbove: true });
    if (fed === 0 || both) rows.push({ ...one, watts: one.watts - fed, total: one.watts, fromAbove: false, label: both ? "" : one.label });
  }
  return rows;
}

/** A branch from a slice of the band: down from `start` and to the right at `row`; `way` -1 mirrors it upwards. */
function ribbon(x1, x2, start, row, thick, end, way, { colour, label, total }) {
  const bend = way * BEND;
  const path = `M${x2} ${start}V${row - bend}Q${x2} ${row} ${x2 + BEND} ${row}H${end}V${row + way * thick}H${x2 + BEND}Q${x1} ${row + way * thick} ${x1} ${row - bend}V${start}Z`;
  return svg("path", { class: thick < 2.5 ? "branch thin" : "branch", d: path, fill: colour }, svg("title", {}, `${label} ${withUnit(total, "W")}`));
}

/** The band between two stages with an arrow, and its power at the left. */
function between(power, y, height, left, scale, bands) {
  const label = svg("text", { class: "watts", x: left - 10, y: y + height / 2 + 4, "text-anchor": "end" }, power === 0 ? "0 W" : `${withUnit(Math.abs(power), "W")} ${power > 0 ? "↓" : "↑"}`);
  if (power === 0) return label;
  const thick = Math.max(scale * Math.abs(power), 1);
  bands.push(svg("rect", { class: "power", x: left, y, width: thick, height }));
  const middle = left + thick / 2;
  const [tip, base] = power >= 0 ? [y + height - 5, y + 5] : [y + 5, y + height - 5];
  const wide = Math.min(9, Math.max(4, thick / 3));
  return svg("g", {}, svg("path", { class: thick > 14 ? "arrow inside" : "arrow", d: `M${middle - wide} ${base}L${middle} ${tip}L${middle + wide} ${base}` }), label);
}

/** Supply or load: a box at the end of the band. */
function end(name, power, y, left, band, scale) {
  const wide = Math.max(scale * Math.abs(power), 34);
  const words = `the ${name} ${name === "load" ? (power >= 0 ? "receives" : "gives") : power >= 0 ? "gives" : "takes back"}`;
  return svg("g", {}, svg("rect", { class: "end", x: left, y, width: wide, height: BOX, rx: 3 }),
    svg("text", { class: "stage", x: left - 10, y: y + BOX / 2 + 4, "text-anchor": "end" }, name),
    svg("text", { class: "endwords", x: left + wide + 10, y: y + BOX / 2 + 4 }, `${words} ${withUnit(Math.abs(power), "W")}`));
}

function describe(header, powers) {
  const both = powers[0] > 0 && powers.at(-1) < 0;
  const flow = both ? `The ${header.stages[0]} and the load both feed the losses` : powers[0] >= 0 ? `Power flows from the ${header.stages[0]} to the load` : `Power flows from the load back to the ${header.stages[0]}`;
  const lost = header.flows.filter((one) => one.kind === "loss" && one.watts > 0).map((one) => `${one.label} ${withUnit(one.watts, "W")}`);
  return `${flow}: ${withUnit(header.power_in, "W")} from the ${header.stages[0]}, ${withUnit(header.power_out, "W")} to the load. Losses: ${lost.join(", ") || "none"}.`;
}

function table(header) {
  const rows = header.flows.map((one) => (one.kind === "loss" ? [`loss: ${one.label}`, one.from, withUnit(one.watts, "W")] : [`${one.from} to ${one.to}`, "", withUnit(one.watts, "W")]));
  return numbers("Flows as a table", ["flow", "in", "power"], rows);
}

/** Powers, efficiency and how well the balance closes. */
function sums({ stages, power_in: given, power_out: got, loss, efficiency, balance_residual: residual }) {
  return [
    { label: `from the ${stages[0] ?? "supply"}`, text: withUnit(given ?? NaN, "W") },
    { label: "to the load", text: withUnit(got ?? NaN, "W") },
    { label: "losses", text: withUnit(loss ?? NaN, "W") },
    { label: "efficiency", text: efficiency === null ? "–" : `${(100 * efficiency).toFixed(1)} %` },
    { label: "residual of the balance", text: residual === null ? "–" : residual.toExponential(0) },
  ];
}

/** Each limit as a bar: the share of what it allows. */
function shares({ utilisation }) {
  const rows = utilisation.filter((one) => one.share !== null && one.share > 0.005).slice(0, 9);
  const unknown = utilisation.filter((one) => one.share === null).map((one) => one.words);
  return [
    make("h3", {}, "Limits, share in use"),
    make("ul", { className: "shares" }, ...rows.map(({ words, share }) => {
      const bar = make("span", { className: share > 1 ? "bar beyond" : "bar" });
      const fill = make("span");
      fill.style.width = `${Math.min(100, (100 * share) / 1.25)}%`;
      bar.append(fill);
      return make("li", {}, make("span", { className: "name" }, words), bar, make("span", { className: share > 1 ? "number no" : "number" }, `${(100 * share).toFixed(0)} %`));
    })),
    rows.length ? null : make("p", { className: "small" }, "No limit is loaded."),
    unknown.length ? make("p", { className: "small" }, `Undefined here: ${[...new Set(unknown)].slice(0, 4).join(", ")}.`) : null,
  ].filter(Boolean);
}

function parts({ parts: rows }) {
  if (!rows) return [];
  const heads = ["part", "force", "speed", "steering", "loss", "tightest limit"];
  const cells = rows.map((one) => [one.part, one.force, one.speed, one.steering, one.loss, one.demand]);
  const found = numbers("Each part", heads, cells);
  found.open = true;
  return [found];
}
