// Run order, lag, histogram and normal plot of what is left.
import { axis, layout } from "./look.js";
import { marks, ofReadings, scaleOf } from "./marks.js";
import { deviation, largest, mean, normalQuantile } from "./numbers.js";

export function fourPlot(readings, view, source) {
  const values = () => {
    const used = readings.used(view.get("component"));
    return {
      used,
      errors: used.map((i) => readings.whitened(view.get("model"), view.get("component"), i)),
    };
  };
  return ofReadings(readings, view, source, {
    id: "four-plot",
    title: "Four-plot: is the residual noise?",
    wide: true,
    height: 520,
    tall: 1200,
    say: "Run order (drift), each against the one before (dependence), histogram and normal plot (outliers). Pure noise: level, round, bell-shaped, straight; grey shows that.",
    numbers: () => {
      const { used, errors } = values();
      return {
        columns: [
          "reading",
          "order",
          readings.sigma ? "residual, times the noise" : "residual [m or rad]",
        ],
        rows: used.map((i, k) => [readings.id[i], k + 1, errors[k]]),
      };
    },
    draw(look, narrow) {
      const { used, errors } = values();
      const component = view.get("component");
      const scale = readings.sigma
        ? { factor: 1, unit: "noise" }
        : scaleOf(readings, component, (m, i) => readings.residual(m, component, i));
      const e = errors.map((v) => v / scale.factor);
      const order = new Map(used.map((i, k) => [i, k]));
      const at = (x, y) => ({ trace: { xaxis: x, yaxis: y, showlegend: x === "x" } });
      const sorted = used.map((i, k) => [i, e[k]]).sort((a, b) => a[1] - b[1]);
      const rank = new Map(
        sorted.map(([i], k) => [i, normalQuantile((k + 0.625) / (e.length + 0.25))]),
      );
      const most = largest(e);
      const centre = mean(e);
      const spread = readings.sigma ? 1 : deviation(e);
      const width = (2 * most) / Math.min(60, Math.max(12, Math.round(Math.sqrt(e.length) * 2)));
      const bell = Array.from({ length: 81 }, (_, k) => -most + (k * most) / 40);
      const density = (x) =>
        (e.length * width * Math.exp(-0.5 * (x / spread) ** 2)) / (spread * Math.sqrt(2 * Math.PI));
      const name = scale.unit ? `residual [${scale.unit}]` : "residual";
      const guide = {
        meta: "guide",
        type: "scatter",
        mode: "lines",
        showlegend: false,
        hoverinfo: "skip",
        line: { color: look.noise, width: 2, dash: "dash" },
      };
      return {
        data: [
          ...marks(
            readings,
            view,
            look,
            used,
            (i) => [order.get(i) + 1, e[order.get(i)]],
            at("x", "y"),
          ),
          ...marks(
            readings,
            view,
            look,
            used.slice(1),
            (i) => [e[order.get(i) - 1], e[order.get(i)]],
            at("x2", "y2"),
          ),
          {
            type: "histogram",
            x: e,
            name: "all",
            xaxis: "x3",
            yaxis: "y3",
            showlegend: false,
            marker: { color: look.fitted, opacity: 0.8 },
            xbins: { start: -most - width / 2, end: most + width, size: width },
          },
          { ...guide, x: bell, y: bell.map(density), xaxis: "x3", yaxis: "y3" },
          ...marks(
            readings,
            view,
            look,
            sorted.map(([i]) => i),
            (i) => [rank.get(i), e[order.get(i)]],
            at("x4", "y4"),
          ),
          {
            ...guide,
            x: [-3.5, 3.5],
            y: [centre * 0 - 3.5 * spread, 3.5 * spread],
            xaxis: "x4",
            yaxis: "y4",
          },
        ],
        layout: layout(look, {
          grid: {
            ...(narrow ? { rows: 4, columns: 1 } : { rows: 2, columns: 2 }),
            pattern: "independent",
            xgap: 0.2,
            ygap: 0.22,
          },
          bargap: 0.05,
          shapes: readings.sigma
            ? [
                ["x domain", "y"],
                ["x2 domain", "y2"],
              ].map(([xref, yref]) => ({
                type: "rect",
                layer: "below",
                xref,
                yref,
                x0: 0,
                x1: 1,
                y0: -2,
                y1: 2,
                fillcolor: look.noise,
                opacity: 0.22,
                line: { width: 0 },
              }))
            : [],
          xaxis: axis(look, "run order"),
          yaxis: axis(look, name),
          xaxis2: axis(look, "the one before"),
          yaxis2: axis(look, name),
          xaxis3: axis(look, name),
          yaxis3: axis(look, "count"),
          xaxis4: axis(look, "normal quantile"),
          yaxis4: axis(look, name),
        }),
      };
    },
  });
}
