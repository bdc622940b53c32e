// The error falls: on readings that were kept out of the fit, from the nominal model to the noise floor.
import { plain } from "./dom.js";
import { axis, layout } from "./look.js";
import { groups, rms, rmsInterval } from "./numbers.js";
import { number, unitFor } from "./units.js";
import { modelInWords } from "./words.js";

/** From a diagnosis: {stages, what, unit}. */
export function stagesOfDiagnosis(diagnosis) {
  return {
    stages: diagnosis.waterfall.map((stage) => ({ ...stage, name: modelInWords(stage.name) })),
    what: `${diagnosis.held_out} left out of the fit in turn`,
    unit: "times the noise",
    factor: 1,
  };
}

/** From the readings themselves, kept out where any are: intervals by bootstrap over poses. */
export function stagesOfReadings(readings) {
  const held = readings.hasHeldOut();
  const known = Boolean(readings.sigma);
  const components = known
    ? readings.components
    : readings.components.filter((c) => c.startsWith("d"));
  const pick = components.length ? components : readings.components;
  const lists = (model) => {
    const byPose = new Map();
    for (const component of pick)
      for (const [pose, members] of groups(
        readings.used(component).filter((i) => !held || readings.heldOut(i)),
        (i) => readings.pose[i],
      )) {
        if (!byPose.has(pose)) byPose.set(pose, []);
        byPose.get(pose).push(...members.map((i) => readings.whitened(model, component, i)));
      }
    return [...byPose.values()];
  };
  const stages = readings.models.map((model, k) => {
    const found = lists(k);
    const interval = rmsInterval(found);
    return {
      name: model.name,
      whitened: rms(found.flat()),
      lower: interval?.[0],
      upper: interval?.[1],
    };
  });
  const scale = known
    ? { factor: 1, unit: "times the noise" }
    : unitFor(pick[0].startsWith("r") ? "angle" : "length", stages[0].whitened);
  if (known) stages.push({ name: "noise floor", whitened: 1, lower: 1, upper: 1 });
  return {
    stages,
    what: held
      ? "readings kept out of the fit"
      : "the readings that were fitted: none were kept out",
    ...scale,
  };
}

const confirmedTrace = (stages, factor, look) => ({
  type: "scatter",
  mode: "markers",
  meta: "guide",
  x: stages.map((_, k) => k),
  y: stages.map((s) => (Number.isFinite(s.confirmed) ? s.confirmed / factor : null)),
  marker: { symbol: "diamond", size: 11, color: look.held, line: { color: look.paper, width: 1 } },
  hovertemplate: "kept to confirm: %{y:.3g}<extra></extra>",
});

/** In lines of at most so many letters, broken at spaces. */
const inLines = (text, most) =>
  text
    .split(" ")
    .reduce((lines, word) => {
      const last = lines.at(-1);
      if (last !== undefined && `${last} ${word}`.length <= most) lines[lines.length - 1] += ` ${word}`;
      else lines.push(word);
      return lines;
    }, [])
    .join("<br>");

export function waterfall({ stages, what, unit, factor }, source, count) {
  const first = stages[0].whitened;
  const floor = stages.find((stage) => stage.name === "noise floor");
  const last = [...stages].reverse().find((stage) => stage !== floor);
  const title =
    last === stages[0]
      ? "The error beside the noise"
      : last.whitened < first
        ? "The error falls"
        : "The error does not fall";
  const confirmed = stages.filter((s) => Number.isFinite(s.confirmed));
  // By what the digits show: a stage that makes the error larger does not look like one that helps.
  const visible = 1.005;
  const rises = stages.map(
    (s, k) => k > 0 && s !== floor && s.whitened > visible * stages[k - 1].whitened,
  );
  const rows = () =>
    stages.map((s) => [
      s.name,
      s.whitened / factor,
      (s.lower ?? NaN) / factor,
      (s.upper ?? NaN) / factor,
      (s.confirmed ?? NaN) / factor,
    ]);
  return {
    id: "waterfall",
    title,
    n: count,
    source,
    height: 360,
    tall: 420,
    say: `rms error on ${what}, ${unit}: ${number(first / factor)} (${stages[0].name})${last === stages[0] ? "" : `, ${number(last.whitened / factor)} (${last.name})`}. Whiskers: 95 %.${rises.includes(true) ? " Orange: larger than before." : ""}${confirmed.length ? " Diamonds: readings kept to confirm." : ""}`,
    numbers: () => ({
      columns: ["stage", `rms error [${unit}]`, "95 % from", "to", "kept to confirm"],
      rows: rows(),
    }),
    draw(look, narrow) {
      const colour = (s, k) =>
        s === floor
          ? look.noise
          : rises[k]
            ? look.held
            : k === 0
              ? look.nominal
              : /^(\+|with|after|as adopted)/.test(s.name)
                ? look.final
                : look.fitted;
      const drops = stages.slice(1).map((s, k) => ({
        type: "line",
        x0: k + 0.4,
        x1: k + 1.4,
        y0: stages[k].whitened / factor,
        y1: stages[k].whitened / factor,
        line: { color: look.quiet, width: 1, dash: "dot" },
      }));
      return {
        data: [
          {
            type: "bar",
            x: stages.map((_, k) => k),
            y: stages.map((s) => s.whitened / factor),
            marker: { color: stages.map(colour) },
            width: 0.8,
            text: stages.map((s) => `<b>${number(s.whitened / factor)}</b>`),
            textposition: "inside",
            insidetextanchor: "middle",
            textangle: 0,
            insidetextfont: {
              color: stages.map((s) => (s === floor ? look.ink : look.paper)),
              size: 15,
            },
            outsidetextfont: { color: look.ink },
            error_y: {
              type: "data",
              symmetric: false,
              color: look.ink,
              thickness: 1.5,
              array: stages.map((s) => ((s.upper ?? s.whitened) - s.whitened) / factor),
              arrayminus: stages.map((s) => (s.whitened - (s.lower ?? s.whitened)) / factor),
            },
            hovertemplate: stages.map(
              (s) =>
                `${plain(s.name)}: ${number(s.whitened / factor)} (${number((s.lower ?? NaN) / factor)} to ${number((s.upper ?? NaN) / factor)}) ${unit}<extra></extra>`,
            ),
            cliponaxis: false,
          },
          ...(confirmed.length ? [confirmedTrace(stages, factor, look)] : []),
        ],
        layout: layout(look, {
          showlegend: false,
          margin: { l: 60, r: 16, t: 30, b: 44 },
          shapes: [
            ...drops,
            ...(floor
              ? [
                  {
                    type: "line",
                    xref: "paper",
                    x0: 0,
                    x1: 1,
                    y0: floor.whitened,
                    y1: floor.whitened,
                    line: { color: look.noise, width: 2, dash: "dash" },
                  },
                ]
              : []),
          ],
          xaxis: axis(look, "", {
            tickvals: stages.map((_, k) => k),
            ticktext: stages.map((s) => inLines(plain(s.name), narrow ? 20 : 14)),
            ...(narrow ? {} : { tickangle: 0 }),
            showgrid: false,
          }),
          yaxis: axis(look, `error [${unit}]`, { rangemode: "tozero" }),
        }),
      };
    },
  };
}
