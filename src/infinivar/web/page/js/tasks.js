// Studies of machines have tasks in place of maps: one row a task, one column a machine, with the power and the tightest limit.
import { byId, digits, make } from "./dom.js";

const watts = (value) => (Number.isFinite(value) ? `${digits(value, 3)} W` : "–");
const differs = (power, steady) => Number.isFinite(steady) && watts(power) !== watts(steady);
const beside = (power, steady) => (differs(power, steady) ? make("small", {}, ` steady ${watts(steady)}`) : "");

/** Draw the answer `tasks`; `onTask(row, machine)` is called with the cell that is chosen. */
export function drawTasks({ header, task, drive, onTask }) {
  const machines = Object.entries(header.machines);
  if (!machines.length) return;
  const head = make("tr", {}, make("th", { scope: "col" }, "Task"), ...machines.map(([name, own]) => make("th", { scope: "col", className: name === drive ? "chosen" : "" }, own.title)));
  const rows = machines[0][1].tasks.map((first, k) => make("tr", {},
    make("th", { scope: "row" }, first.title, make("small", {}, first.group === "paths" ? "path, mean power" : "task")),
    ...machines.map(([name, own]) => cell(name, own, own.tasks[k]))));
  const foot = make("tr", {}, make("th", { scope: "row" }, "Over all"), ...machines.map(([, own]) => make("td", {}, make("b", { className: own.feasible ? "yes" : "no" }, own.feasible ? "feasible" : "infeasible"),
    make("small", {}, [Number.isFinite(own.mean_power) ? `mean power ${watts(own.mean_power)}` : "", differs(own.mean_power, own.steady_power) ? `steady ${watts(own.steady_power)}` : "", Number.isFinite(own.motor_mass) ? `motors ${digits(1000 * own.motor_mass, 3)} g` : ""].filter(Boolean).join(", ")))));

  function cell(name, own, row) {
    const chosen = row.name === task && name === drive;
    const button = make("button", { type: "button", aria: { pressed: String(chosen) }, data: { key: `${name}/${row.key}` }, on: { click: () => onTask(row, name) } },
      make("b", {}, watts(row.power)), beside(row.power, row.steady_power), make("span", { className: row.feasible ? "yes" : "no" }, row.feasible ? "feasible" : "infeasible"), make("small", {}, [row.tightest, row.servos].filter(Boolean).join("; ")));
    return make("td", {}, button);
  }

  const focused = document.activeElement?.dataset?.key;
  byId("strip").replaceChildren(make("div", { className: "wide" }, make("table", { className: "tasks", aria: { label: "Tasks of the machines" } }, make("thead", {}, head), make("tbody", {}, ...rows), make("tfoot", {}, foot))));
  byId("where").hidden = false;
  byId("where").textContent = `${header.verdict} Choose a cell to see the machine in that task.`;
  if (focused) byId("strip").querySelector(`[data-key="${CSS.escape(focused)}"]`)?.focus();
}
