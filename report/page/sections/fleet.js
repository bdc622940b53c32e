// Section of fleet: each quantity over date and serial number, with its control limits.
import { element, list } from "../dom.js";
import { axis, layout } from "../look.js";
import { section } from "../section.js";
import { number, unitFor } from "../units.js";

export const isFleet = ({ result }) => result.command === "fleet" && Array.isArray(result.series);

const called = (member) => [member.serial, member.date].filter(Boolean).join(", ");

function limitLines(limits, last, look) {
  if (!limits) return [];
  return [
    ["upper limit", limits.upper, "dash"],
    ["mean", limits.mean, "solid"],
    ["lower limit", limits.lower, "dash"],
  ].map(([name, value, dash]) => ({
    type: "scatter",
    mode: "lines",
    name,
    x: [0, last],
    y: [value, value],
    line: { color: look.noise, dash, width: 1.5 },
    hovertemplate: `${name} %{y:.4g}<extra></extra>`,
  }));
}

/** Lengths and angles in the unit that the largest of them reads best in. */
function readable(series) {
  const kind = { m: "length", rad: "angle" }[series.unit];
  if (!kind) return { unit: series.unit, factor: 1 };
  return unitFor(kind, Math.max(...series.values.map((v) => Math.abs(v.value))));
}

function chart(result, series, k) {
  const { unit, factor } = readable(series);
  const scaled = (x) => x / factor;
  const limits = series.limits && Object.fromEntries(Object.entries(series.limits).map(([name, x]) => [name, scaled(x)]));
  const outside = new Set(series.outside.map((one) => one.member));
  const names = series.values.map((value) => called(result.members[value.member]));
  return {
    id: `fleet-${k}`,
    title: series.name,
    n: series.values.length,
    source: `Source: ${result.fleet}.`,
    say: series.limits
      ? "Whiskers: two standard deviations. Dashed: mean ± 2.66 times the mean moving range; filled red: outside."
      : "Whiskers: two standard deviations. Too few values for limits.",
    numbers: () => ({
      columns: ["robot", `value${unit ? ` [${unit}]` : ""}`, "standard deviation", "outside"],
      rows: series.values.map((v, i) => [names[i], scaled(v.value), v.deviation === null ? null : scaled(v.deviation), outside.has(v.member) ? "yes" : ""]),
    }),
    draw: (look) => ({
      data: [
        ...limitLines(limits, series.values.length - 1, look),
        {
          type: "scatter",
          mode: "lines+markers",
          name: "value",
          x: series.values.map((_, i) => i),
          y: series.values.map((v) => scaled(v.value)),
          text: names,
          error_y: { type: "data", array: series.values.map((v) => 2 * scaled(v.deviation ?? 0)), color: look.quiet, thickness: 1 },
          line: { color: look.line },
          marker: {
            color: series.values.map((v) => (outside.has(v.member) ? look.bad : look.nominal)),
            size: series.values.map((v) => (outside.has(v.member) ? 12 : 7)),
          },
          hovertemplate: "%{text}: %{y:.4g}<extra></extra>",
        },
      ],
      layout: layout(look, {
        xaxis: axis(look, "", {
          tickvals: names.map((_, i) => i),
          ticktext: names,
          tickangle: -60,
        }),
        yaxis: axis(look, unit ? `value [${unit}]` : "value"),
      }),
    }),
  };
}

export function fleetSection({ result }) {
  const said = result.series.flatMap((series) => series.outside.map((one) => `${one.sentence}.`));
  const { node, add } = section(
    `Fleet: ${result.fleet}`,
    said.length ? list(said) : element("p", {}, "Every value lies within its limits."),
    element(
      "p",
      { class: "say" },
      `${number(result.members.length)} diagnoses or robots, by date, then serial number.`,
    ),
  );
  result.series.forEach((series, k) => add(chart(result, series, k)));
  return node;
}
