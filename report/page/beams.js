// Section of beam: beams against finite elements, and the sections along the axis.
import { element, plain } from "./dom.js";
import { Figure } from "./figure.js";
import { motions } from "./links.js";
import { axis, diverging, layout, onColours } from "./look.js";
import { number, unitFor } from "./units.js";
import { View } from "./view.js";

export const isBeam = ({ result }) => Array.isArray(result.models) && result.sections !== undefined;

export function beamSection({ result }) {
  const source = `Source: ${result.link}.`;
  const charts = element("div", { class: "charts" });
  const node = element(
    "section",
    {},
    element("h2", {}, `Beam or finite elements: ${result.link}`),
    charts,
  );
  const add = (spec) => charts.append(new Figure(spec, new View({})).node);
  for (const [k, c] of (result.comparison ?? []).entries()) {
    const most = 100 * Math.max(...result.comparison.map((x) => x.worst_error));
    const shown = c.errors.map((row) => row.map((v) => (v === null ? null : 100 * v)));
    add({
      id: `beam-errors-${k}`,
      title: `${c.model} against finite elements`,
      n: 36,
      source,
      height: 380,
      least: 300,
      say: `Error of each significant entry of the compliance [%]; the worst is ${number(100 * c.worst_error, 2)} %. Blank: not significant.`,
      numbers: () => ({
        columns: ["row", ...motions],
        rows: c.errors.map((row, i) => [motions[i], ...row]),
      }),
      draw: (look, narrow) => ({
        data: [
          {
            type: "heatmap",
            z: shown,
            x: motions,
            y: motions,
            zmin: -most,
            zmax: most,
            colorscale: diverging(look),
            textfont: { ...onColours(look), ...(narrow ? { size: 9 } : {}) },
            showscale: !narrow,
            xgap: 2,
            ygap: 2,
            text: shown.map((row) => row.map((v) => (v === null ? "" : `${number(v, 2)} %`))),
            texttemplate: "%{text}",
            hovertemplate: "%{y}, %{x}: %{z:.3g} %<extra></extra>",
            colorbar: { thickness: 10, title: { text: "%" } },
          },
        ],
        layout: layout(look, {
          showlegend: false,
          xaxis: axis(look, "", { side: "top", type: "category" }),
          yaxis: axis(look, "", { autorange: "reversed", type: "category" }),
        }),
      }),
    });
  }
  const s = result.sections;
  const a = unitFor("length", s.at(-1).arc);
  add({
    id: "sections",
    title: "Sections along the axis",
    n: s.length,
    source,
    say: "Area and second moments of the sections, over their largest values.",
    numbers: () => ({
      columns: ["arc [m]", "area [m^2]", "I1 [m^4]", "I2 [m^4]", "torsion constant [m^4]"],
      rows: s.map((x) => [x.arc, x.area, ...x.second_moments, x.torsion_constant]),
    }),
    draw(look) {
      const curve = (name, f, color) => {
        const v = s.map(f);
        const top = Math.max(...v);
        return {
          type: "scatter",
          mode: "lines",
          name: plain(name(top)),
          x: s.map((x) => x.arc / a.factor),
          y: v.map((x) => x / top),
          line: { color },
        };
      };
      return {
        data: [
          curve(
            (t) => `area, at most ${number(t * 1e6)} mm²`,
            (x) => x.area,
            look.fitted,
          ),
          curve(
            (t) => `I1, ${number(t * 1e12)} mm⁴`,
            (x) => x.second_moments[0],
            look.held,
          ),
          curve(
            (t) => `I2, ${number(t * 1e12)} mm⁴`,
            (x) => x.second_moments[1],
            look.final,
          ),
          curve(
            (t) => `J, ${number(t * 1e12)} mm⁴`,
            (x) => x.torsion_constant,
            look.chosen,
          ),
        ],
        layout: layout(look, {
          xaxis: axis(look, `along the axis [${a.unit}]`),
          yaxis: axis(look, "over the largest", { range: [0, 1.05] }),
        }),
      };
    },
  });
  return node;
}
