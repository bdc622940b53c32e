// A small picture of each effect: what a gauge shows with it, against the load or what else it depends on.
import { svgElement } from "../dom.js";

const curveOf = (f) => Array.from({ length: 61 }, (_, k) => k / 30 - 1).map((x) => [x, f(x)]);
const sideOf = (x) => Math.sign(x) || 1;
/** The root y of y + y^3 = x, by Newton's method. */
const hardened = (x) => Array.from({ length: 20 }).reduce((y) => y - (y + y ** 3 - x) / (1 + 3 * y * y), x);
/** Up and down again, with another law for each way. */
const loopOf = (up, down) => [...curveOf(up), ...curveOf(down).reverse(), [-1, up(-1)]];

// Displacement against load, the plain spring being y = x; the laws of docs/theory/effects.md at sizes that are seen.
const sketches = {
  load: {
    joint_compliance: curveOf((x) => 1.6 * x),
    link_compliance: curveOf((x) => 1.6 * x),
    bearing_compliance: curveOf((x) => 1.6 * x),
    bearing_tilt: curveOf((x) => 1.6 * x),
    base_compliance: curveOf((x) => 1.6 * x),
    base_tilt: curveOf((x) => 1.6 * x),
    platform_compliance: curveOf((x) => 1.6 * x),
    wrench_gain: curveOf((x) => 1.4 * x),
    wrench_channel_gain: curveOf((x) => 1.4 * x),
    wrench_misalignment: curveOf((x) => 0.6 * x),
    application_point: curveOf((x) => 1.4 * x),
    target_lever_arm: curveOf((x) => 1.4 * x),
    hardening: curveOf(hardened),
    load_hardening: curveOf((x) => x - 0.4 * x * Math.abs(x)),
    wrench_saturation: curveOf((x) => x + 0.5 * x ** 3),
    piecewise_stiffness: curveOf((x) => sideOf(x) * (Math.min(Math.abs(x), 0.35) * 1.7 + 0.7 * Math.max(0, Math.abs(x) - 0.35))),
    directional_stiffness: curveOf((x) => (x < 0 ? x : 1.6 * x)),
    opening_contact: curveOf((x) => x + 1.1 * Math.max(0, x - 0.35)),
    clearance: curveOf((x) => x + 0.35 * sideOf(x)),
    biased_clearance: curveOf((x) => x + 0.35 * sideOf(x + 0.4)),
    friction: loopOf((x) => x - 0.3, (x) => x + 0.3),
    load_friction: loopOf((x) => x - 0.35 * Math.abs(x), (x) => x + 0.35 * Math.abs(x)),
    gauge_play: loopOf((x) => x - 0.3, (x) => x + 0.3),
    preload: curveOf((x) => x + 0.4),
    wrench_zero: curveOf((x) => x + 0.4),
  },
  // Further readings are off by: y = 0 without the effect.
  posture: {
    geometric_error: curveOf((x) => 0.3 + 0.6 * Math.sin(2 * x)),
    gravity_compensator: curveOf((x) => 0.8 * Math.sin(3 * x)),
    self_weight: curveOf((x) => -0.9 * Math.cos(1.4 * x)),
    payload: curveOf((x) => -0.9 * Math.cos(1.4 * x)),
    sensor_frame: curveOf((x) => 0.4 + 0.5 * x),
    sensor_scale: curveOf((x) => 0.9 * x),
    sensor_axis_scale: curveOf((x) => 0.9 * x),
  },
  joint: {
    eccentricity: curveOf((x) => 0.9 * Math.sin(9 * x)),
    periodic_stiffness: curveOf((x) => 0.6 + 0.35 * Math.sin(9 * x)),
    joint_offset: curveOf(() => 0.6),
    transmission_ratio: curveOf((x) => 0.9 * x),
    joint_coupling: curveOf((x) => 0.9 * x),
    stiffness_along_joint: curveOf((x) => 0.35 * Math.exp(x)),
  },
  temperature: {
    thermal_expansion: curveOf((x) => 0.9 * x),
    thermal_softening: curveOf((x) => 0.35 * Math.exp(x)),
  },
  time: {
    creep: curveOf((x) => (x < 0 ? 1 - Math.exp(-4 * (x + 1)) : (1 - Math.exp(-4)) * Math.exp(-4 * x))),
    session_drift: curveOf((x) => 0.45 * (x + 1)),
    target_slip: curveOf((x) => (x < 0.2 ? 0 : 0.8)),
    cycle_offset: curveOf((x) => (Math.abs(x) < 0.3 ? 0.8 : 0)),
  },
};

/** {axis, points, plain}: what it depends on, the curve, and the curve without the effect; null for an effect of one's own. */
export function sketchOf(kind) {
  for (const [axis, kinds] of Object.entries(sketches))
    if (kinds[kind]) return { axis, points: kinds[kind], plain: axis === "load" ? [[-1, -1], [1, 1]] : [[-1, 0], [1, 0]] };
  return null;
}

const sketchSize = { width: 76, height: 52, margin: 4 };

/** The picture; the words beside it say the same. */
export function sketch(kind) {
  const found = sketchOf(kind);
  if (!found) return null;
  const { width, height, margin } = sketchSize;
  const most = Math.max(1, ...found.points.map(([, y]) => Math.abs(y)));
  const at = ([x, y]) =>
    `${(margin + ((x + 1) / 2) * (width - 2 * margin)).toFixed(1)},${(margin + ((most - y) / (2 * most)) * (height - 12 - 2 * margin)).toFixed(1)}`;
  const line = (points, name) => svgElement("polyline", { class: name, points: points.map(at).join(" ") });
  const word = svgElement("text", { x: width / 2, y: height - 1, "text-anchor": "middle" });
  word.textContent = found.axis;
  return svgElement(
    "svg",
    { class: "sketch", viewBox: `0 0 ${width} ${height}`, width, height, "aria-hidden": "true" },
    line(found.plain, "without"),
    line(found.points, "with"),
    word,
  );
}
