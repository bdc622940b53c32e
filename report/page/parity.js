// Measured against predicted.
import { axis, layout } from "./look.js";
import { marks, ofReadings } from "./marks.js";
import { largest } from "./numbers.js";
import { kindOf, unitFor } from "./units.js";

export function parity(readings, view, source) {
  const rows = (component, model) =>
    readings.used(component).map((i) => {
      const measured = readings.measured[component][i];
      return [
        readings.id[i],
        readings.heldOut(i) ? "kept out" : "fitted",
        measured - readings.residual(model, component, i),
        measured,
      ];
    });
  return ofReadings(readings, view, source, {
    id: "parity",
    title: "Measured against predicted",
    say: "On the line the model is right; the grey band is twice the noise, and may be too narrow to see.",
    numbers: () => ({
      columns: ["reading", "role", "predicted [m or rad]", "measured [m or rad]"],
      rows: rows(view.get("component"), view.get("model")),
    }),
    draw(look) {
      const component = view.get("component");
      const model = view.get("model");
      const used = readings.used(component);
      const { factor, unit } = unitFor(
        kindOf(component),
        largest(used.map((i) => readings.measured[component][i])),
      );
      const most = (1.05 * largest(used.map((i) => readings.measured[component][i]))) / factor;
      const half = (2 * (readings.noiseOf(component) ?? 0)) / factor;
      const line = (shift, name, fill) => ({
        type: "scatter",
        mode: "lines",
        meta: "guide",
        name,
        x: [-most, most],
        y: [-most + shift, most + shift],
        hoverinfo: "skip",
        showlegend: fill === undefined && shift === 0,
        line: { color: shift === 0 ? look.quiet : look.noise, width: shift === 0 ? 1 : 0 },
        ...(fill ? { fill, fillcolor: `${look.noise}55` } : {}),
      });
      const place = (i) => {
        const m = readings.measured[component][i];
        return [(m - readings.residual(model, component, i)) / factor, m / factor];
      };
      return {
        data: [
          line(-half, "", undefined),
          line(half, "noise", "tonexty"),
          line(0, "equal"),
          ...marks(readings, view, look, used, place),
        ].map((t, k) => (k === 0 ? { ...t, showlegend: false } : t)),
        layout: layout(look, {
          xaxis: axis(look, `predicted ${component} [${unit}]`),
          yaxis: axis(look, `measured ${component} [${unit}]`),
        }),
      };
    },
  });
}
