// The robot in three dimensions as lines: turned by dragging or by the arrow keys; every joint is a button.
import { element, svgElement } from "../dom.js";
import { extentOf, magnified } from "../skeleton.js";
import { number, quantity } from "../units.js";
import { roundFactor } from "../workspace.js";

/** Unit vectors of the screen (right, up) in base axes, seen from an azimuth and an elevation [rad]. */
export function screenAxes(azimuth, elevation) {
  const [ca, sa, ce, se] = [
    Math.cos(azimuth),
    Math.sin(azimuth),
    Math.cos(elevation),
    Math.sin(elevation),
  ];
  return { right: [-sa, ca, 0], up: [-se * ca, -se * sa, ce] };
}
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Longest distance that any body or end of a chain moves between two states [m]. */
export function largestMove(from, to) {
  const moves = [
    ...to.bodies.map((body, b) => body.position.map((x, k) => x - from.bodies[b].position[k])),
    ...to.chains.flatMap((chain, c) =>
      chain.points.length === from.chains[c].points.length
        ? chain.points.map((p, k) => p.map((x, i) => x - from.chains[c].points[k][i]))
        : [],
    ),
  ].map((move) => Math.hypot(...move));
  return Math.max(0, ...moves);
}

/** `choose(place)`: a joint was chosen, by its whole name ("arm.q2"). */
export class RobotView {
  constructor(choose) {
    this.choose = choose;
    this.azimuth = -1.0;
    this.elevation = 0.35;
    this.zoom = 1;
    this.bend = 0; // magnifications, as powers of ten of what suits the picture
    this.stretch = 0;
    this.svg = svgElement("svg", {
      class: "robot",
      role: "group",
      tabindex: "0",
      "aria-label": "The robot. Arrow keys turn it, plus and minus make it larger and smaller.",
      onkeydown: (event) => this.key(event),
      onpointerdown: (event) => this.grab(event),
      onpointermove: (event) => this.drag(event),
      onpointerup: () => this.drop(),
      onpointercancel: () => this.drop(),
      onwheel: (event) => {
        event.preventDefault();
        this.enlarge(event.deltaY < 0 ? 1.1 : 1 / 1.1);
      },
    });
    this.legend = element("p", { class: "say legend" });
    const magnifier = (label, key) =>
      element("label", {}, `${label} `, element("input", {
        type: "range",
        min: -1,
        max: 1,
        step: 0.05,
        value: 0,
        "aria-label": `${label} magnified`,
        oninput: (event) => {
          this[key] = Number(event.target.value);
          this.draw();
        },
      }));
    const button = (text, label, act) =>
      element("button", { type: "button", "aria-label": label, onclick: act }, text);
    this.node = element(
      "div",
      { class: "stage" },
      this.svg,
      this.legend,
      element(
        "div",
        { class: "view-tools" },
        magnifier("Deflection", "bend"),
        magnifier("Errors", "stretch"),
        button("Turn left", "Turn the robot left", () => this.turn(-0.26, 0)),
        button("Turn right", "Turn the robot right", () => this.turn(0.26, 0)),
        button("+", "Larger", () => this.enlarge(1.2)),
        button("−", "Smaller", () => this.enlarge(1 / 1.2)),
      ),
    );
    new ResizeObserver(() => this.draw()).observe(this.svg);
  }

  /**
   * skeletons: unloaded and (where there is an equilibrium) loaded; load: {at, force}; errors: [{at, by}], what the model
   * misses, at the posture of each reading [m].
   */
  show(picture) {
    this.picture = picture;
    this.draw();
  }

  /** Joints where a chosen effect acts. */
  mark({ selected, active }) {
    this.selected = selected;
    this.active = new Set(active);
    this.draw();
  }

  key(event) {
    const turns = {
      ArrowLeft: [-0.1, 0],
      ArrowRight: [0.1, 0],
      ArrowUp: [0, 0.1],
      ArrowDown: [0, -0.1],
    }[event.key];
    const zoom = { "+": 1.2, "=": 1.2, "-": 1 / 1.2 }[event.key];
    if (!turns && !zoom) return;
    event.preventDefault();
    if (turns) this.turn(...turns);
    else this.enlarge(zoom);
  }
  turn(azimuth, elevation) {
    this.azimuth += azimuth;
    this.elevation = Math.max(-1.5, Math.min(1.5, this.elevation + elevation));
    this.draw();
  }
  enlarge(by) {
    this.zoom = Math.max(0.2, Math.min(10, this.zoom * by));
    this.draw();
  }
  grab(event) {
    if (event.target.closest(".joint")) return;
    this.held = [event.clientX, event.clientY];
    this.svg.setPointerCapture(event.pointerId);
  }
  drag(event) {
    if (!this.held) return;
    const [x, y] = this.held;
    this.held = [event.clientX, event.clientY];
    this.turn(-0.01 * (event.clientX - x), 0.01 * (event.clientY - y));
  }
  drop() {
    this.held = null;
  }

  /** Base axes [m] to pixels, so that all of the robot fits. */
  projection(points, width, height) {
    const { right, up } = screenAxes(this.azimuth, this.elevation);
    const flat = points.map((p) => [dot(p, right), dot(p, up)]);
    const range = (k) => [Math.min(...flat.map((f) => f[k])), Math.max(...flat.map((f) => f[k]))];
    const [x, y] = [range(0), range(1)];
    const scale =
      this.zoom *
      Math.min(
        (width - 90) / Math.max(1e-9, x[1] - x[0]),
        (height - 70) / Math.max(1e-9, y[1] - y[0]),
      );
    const middle = [(x[0] + x[1]) / 2, (y[0] + y[1]) / 2];
    return (p) => [
      width / 2 + scale * (dot(p, right) - middle[0]),
      height / 2 - scale * (dot(p, up) - middle[1]),
    ];
  }

  draw() {
    const box = this.svg.getBoundingClientRect();
    if (!this.picture || box.width < 10) return;
    const focused = document.activeElement?.dataset?.place;
    const { skeletons, load, errors } = this.picture;
    const [from, to] = [skeletons[0], skeletons.at(-1)];
    const size = extentOf([from]);
    const move = largestMove(from, to);
    const bend = move > 0 ? roundFactor((0.08 * size) / move) * 10 ** this.bend : 1;
    const shown = magnified(from, to, bend);
    const longest = Math.max(0, ...errors.map((e) => Math.hypot(...e.by)));
    const stretch = longest > 0 ? roundFactor((0.2 * size) / longest) * 10 ** this.stretch : 1;
    const tip = ({ at, by }) => at.map((x, k) => x + stretch * by[k]);
    const ground = this.ground(from, size);
    const all = [
      ...from.chains.flatMap((c) => c.points),
      ...shown.chains.flatMap((c) => c.points),
      ...errors.map((e) => e.at),
      ...ground.flat(),
    ];
    const [width, height] = [box.width, box.height];
    const at = this.projection(all, width, height);
    const path = (points) => points.map((p) => at(p).map((v) => v.toFixed(1)).join(",")).join(" ");
    const straight = (a, b, kind) => {
      const [p, q] = [at(a), at(b)];
      return svgElement("line", { class: kind, x1: p[0], y1: p[1], x2: q[0], y2: q[1] });
    };
    const arms = (state, kind) =>
      state.chains.map((c) => svgElement("polyline", { class: kind, points: path(c.points) }));
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.svg.replaceChildren(
      ...ground.map(([a, b]) => straight(a, b, "ground")),
      ...arms(from, "ghost"),
      ...errors.map((e) => straight(e.at, tip(e), "miss")),
      ...arms(shown, "arm"),
      ...this.loadArrow(load, shown, to, size, straight, at),
      ...this.jointSigns(shown, at),
    );
    this.svg.querySelector(`[data-place="${CSS.escape(focused ?? "")}"]`)?.focus();
    const said = [
      move > 0
        ? `deflection ${number(bend)} times, largest ${quantity(move, "length")}`
        : "without load",
    ];
    if (longest > 0)
      said.push(`red: what the model misses, ${number(stretch)} times, largest ${quantity(longest, "length")}`);
    if (load) said.push(`blue arrow: ${quantity(Math.hypot(...load.force), "force")}`);
    this.legend.textContent = `${said.join("; ")}.`;
  }

  ground(from, size) {
    const points = from.chains.flatMap((c) => c.points);
    const low = Math.min(0, ...points.map((p) => p[2]));
    const step = roundFactor(0.3 * size);
    const reach = [-2, -1, 0, 1, 2].map((k) => k * step);
    return reach.flatMap((r) => [
      [
        [r, -2 * step, low],
        [r, 2 * step, low],
      ],
      [
        [-2 * step, r, low],
        [2 * step, r, low],
      ],
    ]);
  }

  loadArrow(load, shown, to, size, straight, at) {
    const most = load ? Math.hypot(...load.force) : 0;
    if (!(most > 0)) return [];
    const tip = load.at.map((x, k) => x + shown.bodies[0].position[k] - to.bodies[0].position[k]);
    const start = tip.map((x, k) => x - (0.25 * size * load.force[k]) / most);
    const [a, b] = [at(start), at(tip)];
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
    const [u, v] = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    const corners = [b, [b[0] - 12 * u - 6 * v, b[1] - 12 * v + 6 * u], [b[0] - 12 * u + 6 * v, b[1] - 12 * v - 6 * u]];
    return [
      straight(start, tip, "load"),
      svgElement("polygon", { class: "load-tip", points: corners.map((c) => c.join(",")).join(" ") }),
    ];
  }

  /** Joints that are seen at one place stand beside each other, so that each can be chosen. */
  jointSigns(shown, at) {
    const taken = [];
    const beside = ([x, y]) => {
      while (taken.some((t) => Math.hypot(t[0] - x, t[1] - y) < 12)) x += 18;
      taken.push([x, y]);
      return [x, y];
    };
    return shown.chains.flatMap((c) => c.joints.map((j) => this.joint(c, j, beside(at(j.at)))));
  }

  joint(chain, joint, [x, y]) {
    const place = `${chain.name}.${joint.name}`;
    const chosen = this.selected === place;
    const act = () => this.choose(place);
    return svgElement(
      "g",
      {
        class: `joint${chosen ? " selected" : ""}${this.active?.has(place) ? " active" : ""}`,
        role: "button",
        tabindex: "0",
        "data-place": place,
        "aria-pressed": String(chosen),
        "aria-label": `Joint ${place}, ${joint.turns ? "turns" : "slides"}`,
        onclick: act,
        onkeydown: (event) => {
          if (event.key !== "Enter" && event.key !== " ") return;
          event.preventDefault();
          event.stopPropagation();
          act();
        },
      },
      svgElement("circle", { cx: x, cy: y, r: 15, class: "reach" }),
      svgElement("circle", { cx: x, cy: y, r: joint.role === "actuated" ? 7 : 4 }),
      svgElement("text", { x: x - 4, y: y - 13 }, joint.role === "actuated" ? joint.name : ""),
    );
  }
}
