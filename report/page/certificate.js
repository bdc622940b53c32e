// Accuracy certificate: how large errors are, before and after, and how large the noise makes them anyway.
import { table } from "./dom.js";
import { axis, layout, modelColour } from "./look.js";
import { largest, mean, normalQuantile, quantile, rms } from "./numbers.js";
import { kindOf, number, unitFor } from "./units.js";

const fitOrHeld = (readings) =>
  readings.hasHeldOut()
    ? [
        ["fitted", (i) => !readings.heldOut(i)],
        ["kept out", (i) => readings.heldOut(i)],
      ]
    : [["fitted", () => true]];

export function certificateTable(readings) {
  const rows = [];
  for (const component of readings.components) {
    const used = readings.used(component);
    const { factor, unit } = unitFor(
      kindOf(component),
      largest(used.map((i) => readings.residual(0, component, i))),
    );
    const noise = readings.noiseOf(component);
    for (const [which, member] of fitOrHeld(readings))
      readings.models.forEach((model, m) => {
        const errors = used.filter(member).map((i) => readings.residual(m, component, i));
        if (errors.length === 0) return;
        const sizes = errors.map(Math.abs).sort((a, b) => a - b);
        rows.push([
          component,
          which,
          model.name,
          errors.length,
          ...[seenMean(errors), rms(errors), quantile(sizes, 0.95), sizes.at(-1), noise].map((v) =>
            v === null ? "-" : number(v / factor),
          ),
          unit,
        ]);
      });
  }
  return table(
    ["component", "readings", "model", "n", "mean", "rms", "95 %", "max", "noise", "unit"],
    rows,
    "Accuracy certificate: 95 % of the errors are smaller than the column says",
  );
}

/** What a frame or an offset that is fitted leaves of a mean is rounding: 0. */
const seenMean = (errors) => (Math.abs(mean(errors)) < 1e-6 * rms(errors) ? 0 : mean(errors));

/** The readings that a model explains least, each with its line in the file and its expanded uncertainty. */
export function worstReadings(readings, model, most = 10) {
  if (!readings.sigma) return null;
  const rows = readings.components
    .flatMap((component) =>
      readings.used(component).map((i) => ({ component, i, size: Math.abs(readings.whitened(model, component, i)) })),
    )
    .sort((a, b) => b.size - a.size)
    .slice(0, most)
    .map(({ component, i, size }) => {
      const error = readings.residual(model, component, i);
      const spread = 2 * readings.sigmaAt(component, i);
      const { factor, unit } = unitFor(kindOf(component), Math.max(Math.abs(error), spread));
      const line = readings.line?.[i];
      return [
        String(readings.id[i]),
        line ? `${readings.file ?? "line"}:${line}` : "-",
        component,
        number(error / factor),
        number(spread / factor),
        unit,
        number(size),
        readings.poseName(readings.pose[i]).replace(/^posture /, ""),
      ];
    });
  return table(
    ["reading", "in the file", "component", "error", "U (k = 2)", "unit", "times the noise", "posture"],
    rows,
    `The ${rows.length} readings that the ${readings.models[model].name} model explains least; U: expanded uncertainty of the reading`,
  );
}

/** Share of errors below a size, for every model and for the noise alone. */
export function errorShares(readings, view, source) {
  const component = () => view.get("component");
  const curves = () => {
    const held = readings.hasHeldOut();
    const used = readings.used(component()).filter((i) => !held || readings.heldOut(i));
    return readings.models.map((model, m) => ({
      name: model.name,
      sizes: used.map((i) => Math.abs(readings.residual(m, component(), i))).sort((a, b) => a - b),
    }));
  };
  const thinned = (sizes) => {
    const step = Math.max(1, Math.floor(sizes.length / 400));
    return sizes
      .map((size, k) => [size, (k + 1) / sizes.length])
      .filter((_, k) => k % step === 0 || k === sizes.length - 1);
  };
  return {
    id: "shares",
    title: "How large errors are",
    n: () => curves()[0].sizes.length,
    source,
    follows: ["component"],
    say: `Share of readings ${readings.hasHeldOut() ? "kept out of the fit " : ""}whose error is below a size; the further left the better. Dashed: nothing but noise.`,
    numbers: () => ({
      columns: ["model", "error [m or rad]", "share"],
      rows: curves().flatMap((c) =>
        c.sizes.map((size, k) => [c.name, size, (k + 1) / c.sizes.length]),
      ),
    }),
    draw(look) {
      const all = curves();
      const { factor, unit } = unitFor(kindOf(component()), largest(all.flatMap((c) => c.sizes)));
      const noise = readings.noiseOf(component());
      const data = all.map((curve, m) => {
        const points = thinned(curve.sizes);
        return {
          type: "scatter",
          mode: "lines",
          name: curve.name,
          x: points.map((p) => p[0] / factor),
          y: points.map((p) => 100 * p[1]),
          line: { color: modelColour(look, m), width: 2.5, shape: "hv" },
        };
      });
      if (noise) {
        const shares = Array.from({ length: 99 }, (_, k) => (k + 1) / 100);
        data.push({
          type: "scatter",
          mode: "lines",
          meta: "guide",
          name: "noise alone",
          x: shares.map((p) => (noise * normalQuantile((1 + p) / 2)) / factor),
          y: shares.map((p) => 100 * p),
          line: { color: look.noise, dash: "dash", width: 2 },
        });
      }
      return {
        data,
        layout: layout(look, {
          xaxis: axis(look, `|error| of ${component()} [${unit}]`, { rangemode: "tozero" }),
          yaxis: axis(look, "share of readings [%]", { range: [0, 101] }),
        }),
      };
    },
  };
}
