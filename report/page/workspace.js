// Where in the workspace the error is: arrows at the poses, and a map of pose against direction of load.
import { plain, slider } from "./dom.js";
import { axis, layout, onColours, rising, scene } from "./look.js";
import { choosing } from "./marks.js";
import { groups, largest, rms } from "./numbers.js";
import { skeletonTraces } from "./skeleton.js";
import { number, quantity, unitFor } from "./units.js";

const translations = ["dx", "dy", "dz"];
const extent = (points) =>
  Math.max(
    ...[0, 1, 2].map(
      (k) => Math.max(...points.map((p) => p[k])) - Math.min(...points.map((p) => p[k])),
    ),
  );

/** The next lower of 1, 2, 5, 10, ... */
export function roundFactor(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [5, 2, 1].find((digit) => digit * power <= value) * power;
}

export function arrows(readings, view, source) {
  const measured = translations.filter((c) => readings.components.includes(c));
  const used = readings.used(measured[0]);
  const size = extent(readings.poses.map((p) => p.position)) || 0.1;
  const longest = Math.max(
    ...readings.models.map((_, m) =>
      largest(measured.flatMap((c) => used.map((i) => readings.residual(m, c, i) ?? 0))),
    ),
  );
  const start = roundFactor((0.25 * size) / longest);
  const vector = (i) =>
    translations.map((c) =>
      measured.includes(c) ? (readings.residual(view.get("model"), c, i) ?? 0) : 0,
    );
  const numbers = () =>
    used.map((i) => [readings.id[i], ...readings.poses[readings.pose[i]].position, ...vector(i)]);
  return {
    id: "arrows",
    least: 320,
    title: "Residuals in the workspace",
    n: used.length,
    source,
    height: 460,
    heavy: true,
    follows: ["model", "pose", "magnify"],
    ...choosing(readings, view),
    say: `Measured minus predicted, an arrow a reading, drawn at its pose and magnified as the slider says (${number(start)} times at first). The longest is ${quantity(longest, "length")}; grey crosses: the noise on the same scale.`,
    controls: [
      slider(
        "Magnification",
        { from: -1, to: 1, step: 0.05, value: 0, show: (v) => `${number(start * 10 ** v)} times` },
        (v) => view.set({ magnify: start * 10 ** v }),
      ),
    ],
    numbers: () => ({
      columns: ["reading", "x [m]", "y [m]", "z [m]", "ex [m]", "ey [m]", "ez [m]"],
      rows: numbers(),
    }),
    draw(look) {
      const magnify = view.get("magnify") ?? start;
      const { factor, unit } = unitFor("length", size);
      const lines = (name, members, color, width) => {
        const xyz = [[], [], []];
        for (const i of members) {
          const from = readings.poses[readings.pose[i]].position;
          const e = vector(i);
          for (let k = 0; k < 3; ++k)
            xyz[k].push(from[k] / factor, (from[k] + magnify * e[k]) / factor, null);
        }
        return {
          type: "scatter3d",
          mode: "lines",
          name,
          x: xyz[0],
          y: xyz[1],
          z: xyz[2],
          line: { color, width },
          customdata: members.flatMap((i) => [i, i, i]),
          text: members.flatMap((i) => Array(3).fill(plain(readings.text(i)))),
          hovertemplate: "%{text}<extra></extra>",
        };
      };
      const chosen = view.get("pose");
      const sigma = translations.map((c) =>
        measured.includes(c) ? (readings.noiseOf(c) ?? 0) : 0,
      );
      const cross = readings.poses.flatMap((p) =>
        [0, 1, 2].flatMap((k) =>
          [-1, 1]
            .map((sign) =>
              p.position.map((x, m) => (x + (m === k ? sign * magnify * sigma[k] : 0)) / factor),
            )
            .concat([[null, null, null]]),
        ),
      );
      const noise = {
        type: "scatter3d",
        mode: "lines",
        name: "noise",
        meta: "guide",
        x: cross.map((p) => p[0]),
        y: cross.map((p) => p[1]),
        z: cross.map((p) => p[2]),
        line: { color: look.noise, width: 6 },
        hoverinfo: "skip",
      };
      const poses = {
        type: "scatter3d",
        mode: "markers",
        name: "poses",
        meta: "guide",
        x: readings.poses.map((p) => p.position[0] / factor),
        y: readings.poses.map((p) => p.position[1] / factor),
        z: readings.poses.map((p) => p.position[2] / factor),
        text: readings.poses.map((p) => plain(p.label)),
        hovertemplate: "%{text}<extra></extra>",
        marker: {
          size: readings.poses.map((_, p) => (p === chosen ? 7 : 3)),
          color: readings.poses.map((_, p) => (p === chosen ? look.chosen : look.ink)),
        },
      };
      const held = used.filter((i) => readings.heldOut(i));
      return {
        data: [
          lines(
            "fitted",
            used.filter((i) => !readings.heldOut(i)),
            look.fitted,
            3,
          ),
          ...(held.length ? [lines("kept out", held, look.held, 3)] : []),
          ...(chosen === null
            ? []
            : [
                {
                  ...lines(
                    "chosen pose",
                    used.filter((i) => readings.pose[i] === chosen),
                    look.chosen,
                    5,
                  ),
                  meta: "guide",
                },
              ]),
          ...(readings.sigma ? [noise] : []),
          poses,
          ...(readings.poses[0].skeleton
            ? skeletonTraces(readings.poses[0].skeleton, look, factor, {
                faint: true,
                name: "robot in the first pose",
              }).map((t) => ({ ...t, meta: "guide", visible: "legendonly" }))
            : []),
        ],
        layout: layout(look, { margin: { l: 0, r: 0, t: 0, b: 0 }, scene: scene(look, unit) }),
      };
    },
  };
}

export function poseMap(readings, view, source) {
  const directions = [...new Set(readings.id.map((_, i) => readings.direction(i)))]
    .filter((d) => d !== "none")
    .sort((a, b) => a.slice(1).localeCompare(b.slice(1)) || a.localeCompare(b));
  const cells = (model) => {
    const found = new Map();
    for (const component of readings.components)
      for (const [key, members] of groups(
        readings.used(component),
        (i) => `${readings.pose[i]}/${readings.direction(i)}`,
      )) {
        if (!found.has(key)) found.set(key, []);
        found.get(key).push(...members.map((i) => readings.whitened(model, component, i)));
      }
    return readings.poses.map((_, p) =>
      directions.map((d) => (found.has(`${p}/${d}`) ? rms(found.get(`${p}/${d}`)) : null)),
    );
  };
  const scale = readings.sigma
    ? { factor: 1, unit: "times the noise" }
    : unitFor("length", largest(cells(0).flat()));
  const top = Math.max(...readings.models.map((_, m) => largest(cells(m).flat()))) / scale.factor;
  return {
    id: "pose-map",
    least: 420,
    title: "Pose against direction of load",
    n: readings.poses.length * directions.length,
    source,
    height: Math.max(300, Math.min(700, 90 + 22 * readings.poses.length)),
    follows: ["model", "pose"],
    choose: (point) => view.set({ pose: point.y }),
    step: choosing(readings, view).step,
    say: `rms residual of all components, ${scale.unit}; the same colours for every model${readings.sigma ? ", from 1 (noise)" : ""}. A row that stands out is a posture, a column a direction. Poses with readings kept out are marked •.`,
    numbers: () => ({
      columns: ["pose", ...directions],
      rows: cells(view.get("model")).map((row, p) => [readings.poseText(p), ...row]),
    }),
    draw(look) {
      const z = cells(view.get("model")).map((row) =>
        row.map((v) => (v === null ? null : v / scale.factor)),
      );
      const heldPoses = new Set(readings.pose.filter((_, i) => readings.heldOut(i)));
      const few = readings.poses.length <= 40;
      const chosen = view.get("pose");
      return {
        data: [
          {
            type: "heatmap",
            z,
            x: directions,
            y: readings.poses.map((_, p) => p),
            colorscale: rising(look),
            zmin: readings.sigma ? 1 : 0,
            zmax: Math.max(top, 1.5),
            xgap: 1,
            ygap: few ? 1 : 0,
            text: z.map((row) => row.map((v) => (v === null ? "" : number(v, 2)))),
            texttemplate: few ? "%{text}" : undefined,
            textfont: onColours(look),
            hovertemplate: `pose %{customdata}, %{x}: %{z:.3g} ${scale.unit}<extra></extra>`,
            customdata: z.map((row, p) => row.map(() => plain(readings.poseText(p)))),
            colorbar: {
              title: { text: scale.unit, side: "right" },
              thickness: 12,
              tickfont: { color: look.ink },
            },
          },
        ],
        layout: layout(look, {
          showlegend: false,
          margin: { l: 60, r: 10, t: 30, b: 44 },
          shapes:
            chosen === null
              ? []
              : [
                  {
                    type: "rect",
                    xref: "paper",
                    x0: 0,
                    x1: 1,
                    y0: chosen - 0.5,
                    y1: chosen + 0.5,
                    line: { color: look.chosen, width: 3 },
                  },
                ],
          xaxis: axis(look, "direction of load", { type: "category" }),
          yaxis: axis(look, "", {
            autorange: "reversed",
            ...(few
              ? {
                  tickvals: readings.poses.map((_, p) => p),
                  ticktext: readings.poses.map((pose, p) =>
                    plain(`${heldPoses.has(p) ? "• " : ""}${readings.poseName(p)}`),
                  ),
                  tickfont: { size: 11 },
                }
              : { title: { text: "pose" } }),
          }),
        }),
      };
    },
  };
}
