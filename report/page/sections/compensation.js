// Section of compensate: the error along the path, before and after.
import { list } from "../dom.js";
import { axis, layout } from "../look.js";
import { largest } from "../numbers.js";
import { headingOf, left, norm, section, sourceOf } from "../section.js";
import { quantity, unitFor } from "../units.js";

export const isCompensation = ({ result }) =>
  result.command === "compensate" && Array.isArray(result.points);

export function compensationSection({ result }) {
  const source = sourceOf(result);
  const { node, add } = section(
    headingOf(result),
    list([
      `Largest error of position ${quantity(result.error.largest_translation, "length")} before, ${left(result.residual.largest_translation, "length")} after; of rotation ${quantity(result.error.largest_rotation, "angle")} before, ${left(result.residual.largest_rotation, "angle")} after.`,
    ]),
  );
  const points = result.points.map((p, k) => ({ ...p, k: k + 1 })).filter((p) => p.error);
  for (const [title, kind, first] of [
    ["position", "length", 0],
    ["rotation", "angle", 3],
  ]) {
    const size = (p, key) => norm(p[key].slice(first, first + 3));
    const { factor, unit } = unitFor(kind, largest(points.map((p) => size(p, "error"))));
    const noise = kind === "length" ? 1e-12 : 1e-12;
    add({
      id: `compensation-${title}`,
      title: `Error of ${title} along the path`,
      n: points.length,
      source,
      say: "Of the platform, without and with the corrected targets. What is not there is below rounding.",
      numbers: () => ({
        columns: ["pose", `before [${kind === "length" ? "m" : "rad"}]`, "after"],
        rows: points.map((p) => [p.k, size(p, "error"), size(p, "residual")]),
      }),
      draw: (look) => ({
        data: [
          ["before", "error", look.nominal],
          ["after", "residual", look.final],
        ].map(([name, key, color]) => ({
          type: "scatter",
          mode: "lines+markers",
          name,
          x: points.map((p) => p.k),
          y: points.map((p) => (size(p, key) > noise ? size(p, key) / factor : 0)),
          line: { color },
          marker: { color, size: 6 },
        })),
        layout: layout(look, {
          xaxis: axis(look, "pose of the path"),
          yaxis: axis(look, `error [${unit}]`, { rangemode: "tozero" }),
        }),
      }),
    });
  }
  return node;
}
