// Light and dark: as the system has it, or as chosen.
import { byId } from "./dom.js";

const ORDER = ["auto", "light", "dark"];
const NAMES = { auto: "Auto", light: "Light", dark: "Dark" };

/** What a visitor chose earlier; storage may be forbidden. */
export function remembered(key) {
  try { return localStorage.getItem(`infinivar.${key}`); } catch { return null; }
}

export function remember(key, value) {
  try { localStorage.setItem(`infinivar.${key}`, value); } catch { /* a private window forgets */ }
}

export function createTheme() {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const listeners = new Set();
  let chosen = ORDER.includes(remembered("theme")) ? remembered("theme") : "auto";
  const theme = { get dark() { return chosen === "auto" ? system.matches : chosen === "dark"; }, subscribe: (one) => listeners.add(one) };

  function apply() {
    document.documentElement.dataset.theme = theme.dark ? "dark" : "light";
    byId("theme-name").textContent = NAMES[chosen];
    const after = NAMES[ORDER[(ORDER.indexOf(chosen) + 1) % 3]].toLowerCase();
    byId("theme").title = `Colours: ${NAMES[chosen].toLowerCase()}; press for ${after}`;
    byId("theme").setAttribute("aria-label", `Colours: ${NAMES[chosen]}`);
    for (const listener of listeners) listener(theme);
  }

  byId("theme").addEventListener("click", () => {
    chosen = ORDER[(ORDER.indexOf(chosen) + 1) % 3];
    remember("theme", chosen);
    apply();
  });
  system.addEventListener("change", apply);
  apply();
  return theme;
}

/** The value of a colour of the style sheet. */
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
