// Knowledge of the fit: parameters with their errors, and dependences of the error.
import { bars } from "./bars.js";
import { plain } from "./dom.js";
import { number, stated } from "./units.js";

/** Relative standard error of a fitted parameter [%]. */
const looseness = (p) =>
  100 * Math.abs(p.standard_error_of_log_factor ?? p.standard_error / (p.fitted || 1));

export function identifiability(assessment, source) {
  const rows = assessment.parameters;
  const value = (p) =>
    p.fitted === undefined ? `factor ${number(p.factor)}` : stated(p.fitted, p.unit ?? "");
  const nominal = (p) => (p.designed === undefined ? "1" : stated(p.designed, p.unit ?? ""));
  return {
    id: "identifiability",
    title: "How well the readings know each parameter",
    n: rows.length,
    source,
    height: 110 + 30 * rows.length,
    say:
      "Standard error of the fitted parameters; below 5 % is well known, above 50 % these readings hardly determine it. " +
      (assessment.weak_combinations.length
        ? `Weak: ${assessment.weak_combinations.join("; ")}`
        : "No combination of them is weak."),
    numbers: () => ({
      columns: ["parameter", "nominal", "fitted", "unit", "standard error [%]", "bound"],
      rows: rows.map((p) => [
        p.parameter,
        p.designed ?? 1,
        p.fitted ?? p.factor,
        p.unit ?? "",
        looseness(p),
        p.bound ?? "",
      ]),
    }),
    draw(look) {
      const shown = rows.map((p) => (p.bound ? null : Math.max(looseness(p), 0.01)));
      return bars(look, {
        names: rows.map(
          (p) => `${plain(p.parameter)}<br>${plain(value(p))}${p.bound ? (p.bound === "kept" ? " (kept)" : " (at a bound)") : ""}`,
        ),
        values: shown,
        colours: shown.map((v) => (v > 50 ? look.bad : v > 5 ? look.held : look.good)),
        hover: rows.map(
          (p) =>
            `${plain(p.parameter)}: ${plain(nominal(p))} nominal, ${plain(value(p))} ± ${number(looseness(p), 2)} %`,
        ),
        limits: [5, 50].map((at) => [at, look.noise, 2]),
        x: { title: "standard error [%]", type: "log", dtick: 1, range: [-1.5, 2.3] },
      });
    },
  };
}

/** Dependences of the residual: -log10 of Holm's p-value of each test. */
export function dependences(assessment, source) {
  const smaller = (f) => Math.min(f.mean?.holm_p_value ?? 1, f.size?.holm_p_value ?? 1);
  const rows = assessment.patterns.factors
    .filter((f) => f.mean || f.size)
    .map((f) => [f.factor, smaller(f)]);
  for (const [name, test] of [
    ["sign under reversal", assessment.patterns.reversal?.test],
    ["area of load loops", assessment.patterns.loop_area],
    ["return to zero", assessment.patterns.return_to_zero],
  ])
    if (test) rows.push([name, test.holm_p_value]);
  rows.sort((a, b) => a[1] - b[1]);
  return {
    id: "dependences",
    title: "What the error depends on",
    n: rows.length,
    source,
    height: 110 + 24 * rows.length,
    say: "Evidence against 'the error does not depend on this', -log10 p after Holm's correction for all of these tests. Right of the line: it does depend.",
    numbers: () => ({ columns: ["factor", "p after Holm's correction"], rows }),
    draw(look) {
      const size = rows.map(([, p]) => Math.min(300, -Math.log10(Math.max(p, 1e-300))));
      return bars(look, {
        names: rows.map(([name]) => plain(name)),
        values: size,
        colours: size.map((v) => (v > 1.301 ? look.held : look.nominal)),
        text: size.map((v) => number(v, 2)),
        hover: size.map((v) => number(v)),
        limits: [[1.301, look.bad, 2]],
        x: { title: "-log10 p (line: 5 %)", rangemode: "tozero" },
      });
    },
  };
}
