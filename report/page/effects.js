// Candidates of a diagnosis: ranking with the detection threshold, and effects with similar signatures.
import { bars } from "./bars.js";
import { plain } from "./dom.js";
import { axis, layout, onColours, rising } from "./look.js";
import { number } from "./units.js";

const shown = 16;
const nameOf = (candidate) => `${candidate.effect} at ${candidate.at}`;

/** Of a law: what the verdict gives its class and place, times its share of them. */
function probabilityOf(candidate, decision) {
  for (const answer of decision?.answers ?? [])
    for (const law of answer.laws)
      if (law.effect === candidate.effect && law.at === candidate.at) return answer.probability * law.share;
  return candidate.fit?.probability ?? null;
}

const onBar = (p) => (p > 0.999 ? "over 99.9 %" : p >= 0.001 ? `${number(100 * p, 3)} %` : "< 0.1 %");

/** `decision`: of the round, where something was found in it. */
export function ranking(step, round, source, decision) {
  const observable = step.ranking.filter((candidate) => candidate.observable);
  const rows = observable.slice(0, shown);
  const open = new Set(step.indistinguishable.map((k) => nameOf(step.ranking[k])));
  const hidden = step.ranking.length - observable.length;
  const rest = observable.length - rows.length;
  return {
    id: `ranking-${round}`,
    title:
      round === 1
        ? "Which effect: ranking"
        : `Which effect beside those found: ranking of round ${round}`,
    n: step.ranking.length,
    source,
    least: 420,
    height: 90 + 24 * rows.length,
    paper: 90 + 16 * rows.length,
    say: `Significance of each candidate's signature, -ln p. On the bars: probability of each law (the verdict adds those of one class and place). Right of the detection threshold, which noise alone reaches in 5 %, is more than noise, although ${step.ranking.length} candidates were tried (chance of a false alarm ${number(100 * step.gate.p_value, 2)} %, ${step.gate.draws} simulations). ${open.size > 1 ? "Coloured: not distinguished by these readings. " : ""}${rest} more with smaller signatures, ${hidden} not observable.`,
    numbers: () => ({
      columns: [
        "candidate",
        "observable",
        "significance -ln p",
        "d' at usual size",
        "probability",
        "held-out gain",
        "discriminability d'",
        "reason",
      ],
      rows: step.ranking.map((r) => [
        nameOf(r),
        r.observable ? "yes" : "no",
        r.surprise,
        r.detectability,
        probabilityOf(r, decision),
        r.fit?.log_score_gain ?? null,
        r.fit?.told_apart ?? null,
        r.reason ?? r.not_fitted ?? "",
      ]),
    }),
    draw(look, narrow) {
      const least = 0.3; // a logarithmic axis has no 0
      const most = 1.3 * Math.max(step.gate.critical, ...rows.map((r) => r.surprise));
      const thresholdIsRight = step.gate.critical > Math.sqrt(least * most);
      return bars(look, {
        names: rows.map((r) => plain(nameOf(r))),
        values: rows.map((r) => Math.max(r.surprise, least)),
        colours: rows.map((r) => (open.has(nameOf(r)) ? look.final : look.nominal)),
        text: rows.map((r) =>
          r.fit ? onBar(probabilityOf(r, decision)) : "not fitted",
        ),
        hover: rows.map(
          (r) =>
            `${plain(nameOf(r))}<br>-ln p = ${number(r.surprise)}, d' at usual size ${number(r.detectability)}${r.fit ? `<br>probability ${number(probabilityOf(r, decision))}, held-out gain ${number(r.fit.log_score_gain)} ± ${number(r.fit.log_score_deviation)}` : r.not_fitted ? `<br>not fitted: ${r.not_fitted}` : ""}`,
        ),
        limits: [[step.gate.critical, look.bad, 2]],
        x: {
          title: "significance, -ln p",
          type: "log",
          dtick: 1,
          range: [least, most].map(Math.log10),
        },
        small: true,
        more: {
          annotations: narrow ? [] : [
            {
              x: Math.log10(step.gate.critical),
              y: 1,
              yref: "paper",
              yanchor: "bottom",
              text: "detection threshold",
              showarrow: false,
              font: { color: look.bad, size: 11 },
              xanchor: thresholdIsRight ? "right" : "left",
            },
          ],
        },
      });
    },
  };
}

export function confusion({ candidates, cosines }, round, source) {
  return {
    id: `confusion-${round}`,
    title: "Which effects have the same signature",
    n: candidates.length ** 2,
    source,
    least: 230 + 30 * Math.min(12, candidates.length),
    height: Math.min(640, 200 + 26 * candidates.length),
    paper: 160 + 15 * candidates.length,
    say: "Cosine between the signatures of two effects in these readings, beside the fitted parameters: at 1 no amount of such readings distinguishes them; at 0 each is observable by itself.",
    numbers: () => ({
      columns: ["effect", ...candidates],
      rows: candidates.map((name, i) => [name, ...cosines[i]]),
    }),
    draw(look) {
      const names = candidates.map(plain);
      const at = candidates.map((_, k) => k);
      return {
        data: [
          {
            type: "heatmap",
            z: cosines,
            x: at,
            y: at,
            zmin: 0,
            zmax: 1,
            colorscale: rising(look),
            textfont: onColours(look),
            xgap: 1,
            ygap: 1,
            text: cosines.map((row) => row.map((v) => v.toFixed(2))),
            texttemplate: candidates.length <= 12 ? "%{text}" : undefined,
            customdata: names.map((a) => names.map((b) => `${a}<br>${b}`)),
            hovertemplate: "%{customdata}<br>cosine %{z:.3f}<extra></extra>",
            colorbar: { thickness: 12, title: { text: "cosine", side: "right" } },
          },
        ],
        layout: layout(look, {
          showlegend: false,
          margin: { l: 60, r: 16, t: 30, b: 44 },
          xaxis: axis(look, "", {
            tickangle: -60,
            tickfont: { size: 10 },
            tickvals: at,
            ticktext: names,
          }),
          yaxis: axis(look, "", {
            autorange: "reversed",
            tickfont: { size: 10 },
            tickvals: at,
            ticktext: names,
          }),
        }),
      };
    },
  };
}
