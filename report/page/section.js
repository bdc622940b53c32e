// What all sections of results have.
import { element } from "./dom.js";
import { Figure } from "./figure.js";
import { quantity } from "./units.js";

export const left = (value, kind) =>
  value < 1e-12 ? "nothing beyond rounding" : quantity(value, kind);
export const norm = (v) => Math.hypot(...v);

export function section(name, ...about) {
  const charts = element("div", { class: "charts" });
  const node = element("section", {}, element("h2", {}, name), ...about.filter(Boolean), charts);
  return { node, add: (spec, view) => charts.append(new Figure(spec, view).node) };
}

export const headingOf = (result) => `${result.command ?? "result"}: ${result.inputs?.name ?? result.link ?? ""}`;
export const sourceOf = (result) =>
  `Source: ${result.inputs?.robot?.file ?? result.inputs?.name ?? "result"}.`;
