// A motion of the load over time, and what each drive spends on it: power, energy and temperature of its windings.
import uPlot from "../../vendor/uPlot/uPlot.esm.js";
import { digits, make } from "../dom.js";
import { colour } from "../theme.js";
import { numbers, onWidth, replace, useStyles, withUnit } from "./shared.js";

const SERIES = 6;
const GAP = 16;
/** Width below which charts stand one below the other, as the style sheet has it. */
const NARROW = 600;
let keys = 0;

export function create(container, host) {
  useStyles();
  keys += 1;
  const sync = `motion-${keys}`;
  const head = make("div");
  const list = make("ul", { className: "verdicts" });
  const charts = make("div", { className: "charts" });
  const below = make("div");
  container.replaceChildren(head, list, charts, below);
  let plots = [];
  let model = null;
  let shape = "";
  const end = onWidth(charts, (width) => { for (const { plot, ratio } of plots) plot.setSize({ width: wide(width, ratio), height: plot.height }); });
  const wide = (width, ratio) => Math.floor(width < NARROW ? width : (width - GAP * (ratio - 1)) / ratio);

  function clear() {
    for (const { plot } of plots) plot.destroy();
    plots = [];
    charts.replaceChildren();
  }

  function draw() {
    const { header, arrays, theme } = model;
    const names = Object.keys(header.drives).filter((name) => `${name}/power` in arrays);
    const colours = Object.keys(header.drives).map((_, place) => colour(`series-${(place % SERIES) + 1}`));
    const colourOf = (name) => colours[Object.keys(header.drives).indexOf(name)];
    const panels = panelsOf(header, arrays, names, colourOf);
    const now = JSON.stringify([theme.dark, panels.map((one) => [one.title, one.series.map((series) => [series.label, series.stroke])])]);
    if (now === shape) {
      panels.forEach((panel, place) => plots[place].plot.setData(panel.data));
      return;
    }
    shape = now;
    clear();
    const styles = { text: colour("muted"), grid: colour("soft"), line: colour("line") };
    for (const panel of panels) {
      const values = make("p", { className: "values", aria: { hidden: "true" } });
      const body = make("div", { role: "img", aria: { label: panel.text } });
      const box = make("section", { className: `chart of-${panel.ratio}` }, make("h3", {}, panel.title), body, values);
      charts.append(box);
      const plot = new uPlot(optionsOf(panel, styles, sync, values, wide(charts.clientWidth, panel.ratio)), panel.data, body);
      plots.push({ plot, ratio: panel.ratio });
    }
  }

  return {
    update(next) {
      model = next;
      replace(head, ...headOf(model, host));
      const names = Object.keys(model.header.drives);
      replace(list, ...names.map((name, place) => verdictOf(model.header.drives[name], place)));
      if (charts.clientWidth > 0 || names.length) draw();
      replace(below, energies(model.header));
    },
    destroy() { clear(); end(); },
  };
}

function headOf({ header, study }, host) {
  const motions = (study?.motions ?? []).filter((one) => one.name);
  const title = make("p", { className: "view-head" }, make("strong", {}, header.title), make("span", {}, Number.isFinite(header.period) ? `${withUnit(header.period, "s")}${header.closed ? ", repeated" : ""}` : ""));
  if (motions.length < 2) return [title];
  const select = make("select", { data: { key: "motion" }, on: { change: (event) => host.ask({ motion: event.target.value }) } },
    ...motions.map((one) => make("option", { value: one.name, selected: one.name === header.motion }, one.title)));
  return [title, make("label", { className: "choice" }, "Motion ", select)];
}

function verdictOf(drive, place) {
  const mark = make("span", { className: `mark series-${(place % SERIES) + 1}` });
  const words = drive.fault ?? drive.verdict;
  const state = drive.fault !== null ? "no" : drive.feasible ? "yes" : "no";
  return make("li", {}, mark, make("strong", {}, drive.title), " ", make("span", { className: `said ${state}` }, words));
}

/** The charts: title, series and data; `ratio` 1 for a chart as wide as the page. */
function panelsOf(header, arrays, names, colourOf) {
  const time = arrays.time;
  if (time === undefined) return [];
  const panels = (header.course ?? []).map((one) => ({
    title: `${one.label} [${one.unit}]`, unit: one.unit, height: 130, ratio: 3, unitOfTime: "s",
    series: [{ label: one.label, stroke: colour("text") }], data: [time, arrays[`course/${one.name}`]], text: `${one.label} over time: ${span(arrays[`course/${one.name}`], one.unit)}`,
  }));
  if (names.length) {
    const lines = (kind) => names.map((name) => arrays[`${name}/${kind}`]);
    const series = names.map((name) => ({ label: header.drives[name].title, stroke: colourOf(name) }));
    const ends = (kind, unit) => names.map((name) => `${header.drives[name].title} ${span(arrays[`${name}/${kind}`], unit)}`).join("; ");
    panels.push({ title: "power from the supply [W]", unit: "W", height: 190, ratio: 2, unitOfTime: "s", series, data: [time, ...lines("power")], text: `Power from the supply over time: ${ends("power", "W")}`, zero: true });
    panels.push({ title: "energy from the supply so far [J]", unit: "J", height: 190, ratio: 2, unitOfTime: "s", series, data: [time, ...lines("energy")], text: `Energy from the supply over time: ${ends("energy", "J")}`, zero: true });
    const heat = heatPanel(header, arrays, names, colourOf);
    if (heat !== null) panels.push(heat);
  }
  return panels;
}

/** Winding temperatures of all motors on one axis of time: each history has its own instants. */
function heatPanel(header, arrays, names, colourOf) {
  const rows = names.flatMap((name) => header.drives[name].heat.map((one, place) => ({ ...one, drive: name, time: arrays[`${name}/heat/${place}/time`], winding: arrays[`${name}/heat/${place}/winding`] }))).filter((one) => one.time?.length > 1);
  if (!rows.length) return null;
  const lasts = rows.map((one) => one.time.at(-1));
  const last = header.closed ? Math.min(Math.max(...lasts), 4 * Math.min(...lasts.filter((one) => one > 0))) : Math.max(...lasts);
  const [unit, factor] = last > 600 ? ["min", 60] : ["s", 1];
  const count = 300;
  const top = 1.15 * Math.max(...rows.map((one) => one.permissible));
  const time = Float64Array.from({ length: count }, (_, k) => (k * last) / (count - 1) / factor);
  const curves = rows.map((one) => Array.from(time, (at) => within(at * factor, one.time, one.winding, top)));
  const series = rows.map((one) => ({ label: `${header.drives[one.drive].title}, ${one.name}`, stroke: colourOf(one.drive), dash: one.name.startsWith("steering") ? [6, 4] : undefined, permissible: one.permissible }));
  const text = rows.map((one) => `${header.drives[one.drive].title}, ${one.name}: ${one.verdict}`).join("; ");
  return { title: `winding temperature [°C]${header.closed ? ", motion repeated from a cold start" : ""}`, unit: "°C", height: 210, ratio: 1, unitOfTime: unit, apart: true, series, data: [time, ...curves], text, limits: [...new Set(rows.map((one) => one.permissible))] };
}

/** The value of a history at a time, by straight lines; its last value later, and null beyond the top. */
function within(at, times, values, top) {
  let found = values.at(-1);
  for (let k = 0; k < times.length; k += 1) {
    if (times[k] >= at) {
      const before = Math.max(0, k - 1);
      const step = times[k] - times[before];
      found = step > 0 ? values[before] + ((at - times[before]) / step) * (values[k] - values[before]) : values[k];
      break;
    }
  }
  return found <= top ? found : null;
}

function span(values, unit) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) { if (value < low) low = value; if (value > high) high = value; }
  return `from ${digits(low, 3)} to ${withUnit(high, unit)}`;
}

function optionsOf(panel, styles, sync, values, width) {
  const axis = { stroke: styles.text, grid: { stroke: styles.grid, width: 1 }, ticks: { stroke: styles.line, width: 1, size: 4 }, font: "11px system-ui, sans-serif" };
  const telling = (plot) => {
    const at = plot.cursor.idx;
    if (at === null || at === undefined) { values.replaceChildren(); return; }
    const rows = panel.series.map((series, place) => {
      const mark = make("span", { className: "stroke" });
      mark.style.borderColor = series.stroke;
      return make("span", {}, mark, `${panel.series.length > 1 ? `${series.label} ` : ""}${withUnit(plot.data[place + 1][at], panel.unit)}`);
    });
    values.replaceChildren(make("span", {}, `${withUnit(plot.data[0][at], panel.unitOfTime)}:`), ...rows);
  };
  return {
    width, height: panel.height, padding: [8, 10, 0, 0],
    legend: { show: false },
    cursor: { sync: panel.apart ? undefined : { key: sync }, y: false, points: { size: 6 } },
    scales: { x: { time: false }, y: { range: (_, low, high) => rangeOf(low, high, panel) } },
    axes: [{ ...axis, size: 26, space: 44, values: (_, marks) => marks.map((one) => `${digits(one, 4)} ${panel.unitOfTime}`) }, { ...axis, size: 46, space: 24, values: (_, marks) => marks.map((one) => digits(one, 4)) }],
    series: [{}, ...panel.series.map(({ label, stroke, dash }) => ({ label, stroke, dash, width: 1.6, pxAlign: 0, points: { show: false } }))],
    hooks: { setCursor: [telling], draw: panel.limits ? [(plot) => limitLines(plot, panel.limits, styles)] : [] },
  };
}

function rangeOf(low, high, { zero, limits }) {
  if (!Number.isFinite(low) || !Number.isFinite(high)) return [0, 1];
  let [from, to] = zero ? [Math.min(low, 0), Math.max(high, 0)] : [low, high];
  // The nearest limit is in sight, others if they are near, too.
  if (limits) to = Math.max(to, 1.04 * Math.min(...limits));
  const room = 0.08 * (to - from || Math.abs(to) || 1);
  return [zero && from === 0 ? 0 : from - room, to + room];
}

/** Permissible temperatures as dotted lines with their values. */
function limitLines(plot, limits, styles) {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.strokeStyle = styles.text;
  ctx.fillStyle = styles.text;
  ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
  ctx.textAlign = "right";
  ctx.textBaseline = "bottom";
  ctx.setLineDash([2 * devicePixelRatio, 3 * devicePixelRatio]);
  for (const one of limits) {
    if (one > plot.scales.y.max) continue;
    const y = plot.valToPos(one, "y", true);
    ctx.beginPath(); ctx.moveTo(bbox.left, y); ctx.lineTo(bbox.left + bbox.width, y); ctx.stroke();
    ctx.fillText(`${digits(one, 3)} °C allowed`, bbox.left + bbox.width - 4, y - 2 * devicePixelRatio);
  }
  ctx.restore();
}

function energies(header) {
  const rows = Object.values(header.drives).filter((one) => one.fault === null);
  if (!rows.length) return null;
  const cells = rows.map((one) => [one.title, withUnit(one.energy, "J"), withUnit(one.mean_power, "W"), one.losses.slice(0, 5).map((loss) => `${loss.label} ${withUnit(loss.joules, "J")}`).join(", "), one.heat.map((hot) => `${hot.name}: ${hot.verdict}`).join("; ")]);
  const found = numbers(`Energy ${header.per ?? ""}, losses and heat as a table`, ["drive", "energy", "mean power", "largest losses", "heat"], cells);
  return found;
}
