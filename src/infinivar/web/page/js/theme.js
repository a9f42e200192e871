// Light and dark: as the system has it, or as chosen.
import { byId } from "./dom.js";

const ORDER = ["auto", "light", "dark"];
const NAMES = { auto: "Auto", light: "Light", dark: "Dark" };

const LONG = 365 * 24 * 3600;  // [s]

/** What a visitor chose earlier, in a cookie: the server may have had another port, which other storage counts as another site. */
export function remembered(key) {
  return document.cookie.split("; ").find((one) => one.startsWith(`infinivar-${key}=`))?.split("=")[1] ?? null;
}

export function remember(key, value) {
  document.cookie = `infinivar-${key}=${value}; path=/; max-age=${LONG}; samesite=strict`;
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
