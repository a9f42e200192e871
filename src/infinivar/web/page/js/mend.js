// What then: a button that seeks changes with which a drive is within all limits, and a button to apply each.
import { make } from "./dom.js";
import { Superseded } from "./transport.js";

/** The button and its list. `ask()` gives the answer `mend`, `apply(changes)` sets the values of one row as one step. */
export function mendBox({ ask, apply }) {
  const list = make("ul", { role: "status" });
  const button = make("button", { type: "button", on: { click: seek } }, "What would mend it?");
  const box = make("div", { className: "mend" }, button, list);

  async function seek() {
    button.disabled = true;
    list.replaceChildren(make("li", {}, "searching …"));
    try {
      const { header } = await ask();
      if (header.faults?.length) throw new Error(header.faults.map((fault) => fault.message).join(" "));
      button.remove();
      list.replaceChildren(...(header.rows.length ? header.rows.map(line) : [make("li", {}, header.reason)]));
    } catch (problem) {
      button.disabled = false;
      list.replaceChildren(...(problem instanceof Superseded ? [] : [make("li", { className: "no" }, problem.message)]));
    }
  }

  function line(changes) {
    const parts = changes.map(({ label, text, was }, k) => [k ? " and " : "", make("b", {}, `${label} ${text}`), make("span", {}, ` instead of ${was}`)]);
    return make("li", {}, make("button", { type: "button", on: { click: () => apply(changes) } }, "Apply"), make("span", {}, ...parts.flat()));
  }
  return box;
}
