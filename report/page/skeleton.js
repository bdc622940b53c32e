// A manipulator as lines: chains, joints, frames.
import { plain } from "./dom.js";

const colours = [
  "#2a6fb5",
  "#c86a12",
  "#12805c",
  "#8a4fbf",
  "#c83489",
  "#5f7d16",
  "#0f7f8c",
  "#a0522d",
];

export function extentOf(skeletons) {
  const points = skeletons.flatMap((s) => s.chains.flatMap((c) => c.points));
  return (
    Math.max(
      ...[0, 1, 2].map(
        (k) => Math.max(...points.map((p) => p[k])) - Math.min(...points.map((p) => p[k])),
      ),
    ) || 1
  );
}

/** Positions of one state, moved away from another by so many times what they differ. */
export function magnified(from, to, factor) {
  const move = (a, b) => a.map((x, k) => x + factor * (b[k] - x));
  return {
    ...to,
    chains: to.chains.map((chain, c) => {
      const base = from.chains[c];
      // A link that was short of a point in one of the states has no partner to move from.
      const points =
        chain.points.length === base.points.length
          ? chain.points.map((p, k) => move(base.points[k], p))
          : chain.points;
      const joints =
        chain.joints.length === base.joints.length
          ? chain.joints.map((j, k) => ({ ...j, at: move(base.joints[k].at, j.at) }))
          : chain.joints;
      return { ...chain, points, joints };
    }),
    bodies: to.bodies.map((body, b) => ({
      ...body,
      position: move(from.bodies[b].position, body.position),
    })),
  };
}

const line = (points, factor) => ({
  x: points.map((p) => p[0] / factor),
  y: points.map((p) => p[1] / factor),
  z: points.map((p) => p[2] / factor),
});

export function skeletonTraces(
  skeleton,
  look,
  factor,
  { faint = false, frames = true, name = "" } = {},
) {
  const traces = skeleton.chains.map((chain, c) => ({
    type: "scatter3d",
    mode: "lines",
    name: faint ? name : `chain ${plain(chain.name)}`,
    legendgroup: faint ? name : chain.name,
    showlegend: !faint || c === 0,
    ...line(chain.points, factor),
    line: { color: faint ? look.noise : colours[c % colours.length], width: faint ? 3 : 6 },
    hoverinfo: "skip",
    opacity: faint ? 0.6 : 1,
  }));
  if (faint) return traces;
  for (const [role, symbol, color] of [
    ["actuated", "square", look.bad],
    ["passive", "circle", look.ink],
  ]) {
    const joints = skeleton.chains.flatMap((chain) =>
      chain.joints.filter((j) => j.role === role).map((j) => ({ ...j, chain: chain.name })),
    );
    if (joints.length)
      traces.push({
        type: "scatter3d",
        mode: "markers",
        name: `${role} joints`,
        ...line(
          joints.map((j) => j.at),
          factor,
        ),
        marker: { symbol, size: 4, color },
        text: joints.map((j) =>
          plain(
            `${j.chain}.${j.name}, ${j.turns ? "turns about" : "slides along"} (${j.axis.map((a) => a.toFixed(2)).join(", ")})`,
          ),
        ),
        hovertemplate: "%{text}<extra></extra>",
      });
  }
  if (frames) traces.push(...frameTraces(skeleton, factor));
  return traces;
}

// Axes of the bodies and of the base: x red, y green, z blue.
function frameTraces(skeleton, factor) {
  const size = 0.12 * extentOf([skeleton]);
  const frames = [
    {
      name: "base",
      position: [0, 0, 0],
      axes: [
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
      ],
    },
    ...skeleton.bodies,
  ];
  return ["#d43d3d", "#2f9e44", "#2f6fde"].map((color, k) => {
    const points = frames.flatMap((f) => [
      f.position,
      f.position.map((x, i) => x + size * f.axes[k][i]),
      [null, null, null],
    ]);
    return {
      type: "scatter3d",
      mode: "lines",
      name: `${"xyz"[k]} axes`,
      legendgroup: "frames",
      showlegend: k === 0,
      ...(k === 0 ? { name: "frames" } : {}),
      hoverinfo: "text",
      text: frames.flatMap((f) => Array(3).fill(plain(`${"xyz"[k]} of ${f.name}`))),
      x: points.map((p) => (p[0] === null ? null : p[0] / factor)),
      y: points.map((p) => (p[0] === null ? null : p[1] / factor)),
      z: points.map((p) => (p[0] === null ? null : p[2] / factor)),
      line: { color, width: 4 },
      meta: "guide",
    };
  });
}
