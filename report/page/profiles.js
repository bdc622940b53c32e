// How much worse every other value of one parameter is, all others fitted again.
import { axis, layout } from "./look.js";
import { largest } from "./numbers.js";
import { number, stated, unitOf } from "./units.js";

const limit = 3.841; // of chi-square with one degree of freedom, 95 %

/** In what the parameter is shown: {of(coordinate), unit}; stiffnesses are fitted by the logarithm of a factor. */
function scaleOfProfile(profile) {
  const logarithm = profile.log_factor !== undefined;
  const size = largest(profile.points.map((p) => p.value));
  if (!logarithm) {
    const { factor, unit } = unitOf(size, profile.unit ?? "");
    return { of: (v) => v / factor, unit };
  }
  if (profile.designed === undefined) return { of: Math.exp, unit: "times nominal" };
  const { factor, unit } = unitOf(profile.designed, profile.unit);
  return { of: (v) => (profile.designed * Math.exp(v)) / factor, unit };
}

/** Of the linearised fit: [best, standard deviation] of the coordinate. */
const linearised = (p) =>
  p.log_factor === undefined
    ? [p.fitted, p.standard_error]
    : [p.log_factor, p.standard_error_of_log_factor];

const names = (p) => (p.log_factor === undefined ? p.parameter : `stiffness of ${p.parameter}`);

export function likelihoodProfile(profile, place, source) {
  const { of, unit } = scaleOfProfile(profile);
  const [best, deviation] = linearised(profile);
  const parabola = (v) => ((v - best) / deviation) ** 2;
  const shown = (v) => (v === null ? "beyond" : `${number(of(v))} ${unit}`.trim());
  const [low, high] = profile.interval;
  const [from, to] = [profile.points[0].value, profile.points.at(-1).value];
  const grid = Array.from({ length: 61 }, (_, k) => from + ((to - from) * k) / 60);
  return {
    id: `profile-${place}`,
    title: `Likelihood profile: ${names(profile)}`,
    n: profile.points.length,
    source,
    height: 300,
    say:
      `Chi-square above its least with this value held and all others fitted again; under the line is the 95 % interval, ${shown(low)} to ${shown(high)}. Dashed: the parabola that ± ${profile.log_factor === undefined ? stated(deviation, profile.unit ?? "", 2) : `${number(100 * deviation, 2)} %`} stands for.` +
      (profile.ended ? ` Ends early: ${profile.ended}.` : ""),
    numbers: () => ({
      columns: [`value [${unit || "-"}]`, "chi-square above its least", "of the parabola"],
      rows: profile.points.map((p) => [of(p.value), p.rise, parabola(p.value)]),
    }),
    draw: (look) => ({
      data: [
        {
          type: "scatter",
          mode: "lines",
          meta: "guide",
          name: "linearised",
          x: grid.map(of),
          y: grid.map(parabola),
          hoverinfo: "skip",
          line: { color: look.noise, width: 2, dash: "dash" },
        },
        {
          type: "scatter",
          mode: "lines+markers",
          name: "profile",
          x: profile.points.map((p) => of(p.value)),
          y: profile.points.map((p) => p.rise),
          hovertemplate: "%{x:.5g}: %{y:.3g} above the least<extra></extra>",
          line: { color: look.final, width: 2.5 },
          marker: { color: look.final, size: 6 },
        },
      ],
      layout: layout(look, {
        shapes: [
          {
            type: "line",
            xref: "paper",
            x0: 0,
            x1: 1,
            y0: limit,
            y1: limit,
            line: { color: look.bad, width: 2, dash: "dot" },
          },
        ],
        xaxis: axis(look, `${names(profile)} [${unit || "-"}]`),
        yaxis: axis(look, "chi-square above its least", { rangemode: "tozero" }),
      }),
    }),
  };
}
