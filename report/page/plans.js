// Experimental design: the batch, the pairs that it would distinguish, and the parameters that it would sharpen.
import { bars } from "./bars.js";
import { element, list, plain, table } from "./dom.js";
import { Figure } from "./figure.js";
import { axis, layout, onColours, rising } from "./look.js";
import { number, stated } from "./units.js";
import { View } from "./view.js";

export const isPlan = ({ result }) => Array.isArray(result.cycles) && Array.isArray(result.splits);
const directionOf = (cycle) => cycle.direction || "no load";
const margin = { l: 60, r: 16, t: 30, b: 44 };

/** Minutes of each posture and direction of load. */
function batchFigure(cycles, source) {
  const postures = [...new Set(cycles.map((c) => c.configuration))].sort((a, b) => a - b);
  const directions = [...new Set(cycles.map(directionOf))];
  const minutes = postures.map((p) =>
    directions.map(
      (d) =>
        cycles
          .filter((c) => c.configuration === p && directionOf(c) === d)
          .reduce((sum, c) => sum + c.minutes, 0) || null,
    ),
  );
  return {
    id: "plan-batch",
    title: "Where to measure next",
    n: cycles.length,
    source,
    height: Math.max(240, 110 + 24 * postures.length),
    say: "Minutes that each posture and direction of load gets in the batch. Blank: nothing there.",
    numbers: () => ({
      columns: [
        "cycle",
        "posture",
        "direction",
        "level [SI]",
        "pattern",
        "readings",
        "minutes",
        "why",
      ],
      rows: cycles.map((c) => [
        c.cycle,
        c.configuration + 1,
        directionOf(c),
        c.level,
        c.pattern,
        c.readings,
        c.minutes,
        c.why,
      ]),
    }),
    draw: (look) => ({
      data: [
        {
          type: "heatmap",
          z: minutes,
          x: directions,
          y: postures.map((_, k) => k),
          colorscale: rising(look),
          textfont: onColours(look),
          zmin: 0,
          zmax: Math.max(...minutes.flat()),
          xgap: 1,
          ygap: 1,
          text: minutes.map((row) => row.map((v) => (v === null ? "" : number(v)))),
          texttemplate: "%{text}",
          hovertemplate: "direction %{x}: %{z:.3g} min<extra></extra>",
          colorbar: { thickness: 12, title: { text: "minutes", side: "right" } },
        },
      ],
      layout: layout(look, {
        showlegend: false,
        margin,
        xaxis: axis(look, "direction of load", { type: "category" }),
        yaxis: axis(look, "posture", {
          autorange: "reversed",
          tickvals: postures.map((_, k) => k),
          ticktext: postures.map((p) => String(p + 1)),
        }),
      }),
    }),
  };
}

function splitsFigure(splits, source) {
  const name = (s) => `${s.a} from ${s.b}`;
  return {
    id: "plan-splits",
    title: "What the batch would distinguish",
    n: splits.length,
    source,
    height: 110 + 30 * splits.length,
    least: 420,
    say: "Evidence that these readings are expected to give for the right one of each pair, in nats; from 4.6 on (a factor of 100) a pair counts as distinguished.",
    numbers: () => ({
      columns: ["a", "b", "nats expected", "most that any batch could give", "d'"],
      rows: splits.map((s) => [s.a, s.b, s.nats, s.most, s.separation]),
    }),
    draw: (look) =>
      bars(look, {
        names: splits.map((s) => `${plain(s.a)}<br>from ${plain(s.b)}`),
        values: splits.map((s) => s.nats),
        colours: splits.map((s) => (s.nats >= 4.6 ? look.final : look.nominal)),
        text: splits.map((s) => number(s.nats)),
        hover: splits.map(
          (s) =>
            `${plain(name(s))}<br>${number(s.nats)} nats${s.advice ? `<br>${plain(s.advice)}` : ""}`,
        ),
        limits: [[4.6, look.bad, 2]],
        x: { title: "evidence expected [nats]", rangemode: "tozero" },
        small: true,
      }),
  };
}

function sharpenedFigure(sharpened, source) {
  return {
    id: "plan-sharpened",
    title: "What the batch would know better",
    n: sharpened.length,
    source,
    height: 110 + 30 * sharpened.length,
    least: 720,
    wide: true,
    say: "Standard deviation of each parameter with these readings, beside that of today.",
    numbers: () => ({
      columns: ["parameter", "unit", "now [SI]", "expected [SI]"],
      rows: sharpened.map((s) => [s.name, s.unit, s.deviation_now, s.deviation_expected]),
    }),
    draw(look) {
      const share = sharpened.map((s) => (100 * s.deviation_expected) / s.deviation_now);
      return bars(look, {
        names: sharpened.map((s) => plain(s.name)),
        values: share,
        colours: look.final,
        text: sharpened.map((s) =>
          plain(
            `${stated(s.deviation_now, s.unit, 2)} to ${stated(s.deviation_expected, s.unit, 2)}`,
          ),
        ),
        hover: share.map((v) => `${number(v)} %`),
        x: { title: "of today's standard deviation [%]", range: [0, 140] },
      });
    },
  };
}

/** A line for each step, as people take them, with a box to tick on paper; a card each on a narrow screen. */
export function workTable(steps) {
  if (!steps?.length) return null;
  const heads = ["#", "load", "how", "where", "times", "readings", "min", "for", "done"];
  const node = table(
    heads,
    steps.map((step, k) => [
      String(k + 1),
      step.load,
      step.how,
      step.posture,
      step.times,
      step.readings,
      number(step.minutes),
      step.for,
      "☐",
    ]),
    "Readings to take next",
  );
  node.classList.add("work");
  for (const row of node.querySelectorAll("tbody tr"))
    [...row.children].forEach((cell, k) => {
      cell.dataset.head = heads[k];
    });
  return node;
}

export function planSection({ result }) {
  const source = `Source: ${result.inputs?.name ?? "plan"}.`;
  const charts = element("div", { class: "charts" });
  const add = (spec) => charts.append(new Figure(spec, new View({})).node);
  const said = [
    `${result.cycles.length} load cycles, ${result.readings} readings, ${number(result.minutes, 4)} of ${number(result.minutes_allowed, 4)} minutes.`,
    ...(result.notes ?? []),
  ];
  if (result.asks_for_weights) said.push("Known weights would show what the load cell cannot.");
  if (result.asks_for_absolute) said.push("Absolute poses would show what differences cannot.");
  if (result.cycles.length) add(batchFigure(result.cycles, source));
  if (result.splits.length) add(splitsFigure(result.splits, source));
  if (result.sharpened?.length) add(sharpenedFigure(result.sharpened, source));
  const rows = result.cycles.map((c) => [
    c.cycle,
    String(c.configuration + 1),
    directionOf(c),
    c.pattern,
    c.readings,
    number(c.minutes),
    c.why,
  ]);
  return element(
    "section",
    {},
    element("h2", {}, `What to measure next: ${result.inputs?.name ?? ""}`),
    list(said),
    workTable(result.work_list) ?? "",
    charts,
    rows.length
      ? table(
          ["cycle", "posture", "direction", "pattern", "readings", "minutes", "why"],
          rows,
          "Every load cycle of the batch",
        )
      : null,
  );
}
