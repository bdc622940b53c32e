// Section of modes: natural frequencies of a link or of a robot, and what moves or yields in each.
import { bars } from "../bars.js";
import { choice, element, plain, table } from "../dom.js";
import { axis, layout, scene } from "../look.js";
import { headingOf, norm, section } from "../section.js";
import { extentOf, magnified, skeletonTraces } from "../skeleton.js";
import { number, unitFor } from "../units.js";
import { View } from "../view.js";

export const isModes = ({ result }) =>
  result.command === "modes" && Array.isArray(result.modes) && result.modes[0]?.frequency !== undefined;

const shareInWords = (share) => `${number(100 * share, 2)} %`;
const yieldsOf = (mode) => (mode.yields ?? []).filter((one) => one.share >= 0.1);

/** What a mode is, in a few words. */
function modeInWords(mode) {
  if (mode.yields) return yieldsOf(mode).map((one) => `${shareInWords(one.share)} ${one.spring}`).join(", ");
  const motion = Array.isArray(mode.motion) ? mode.motion : [];
  return motion
    .map((share, k) => [share, "xyz"[k]])
    .filter(([share]) => share >= 0.01)
    .sort((a, b) => b[0] - a[0])
    .map(([share, letter]) => `${shareInWords(share)} along ${letter}`)
    .join(", ");
}

/** Half width of the interval of a frequency [Hz]: of its mesh, or of what is known of the robot. */
const errorOf = (result, k) => result.modes[k].error ?? result.uncertainty?.frequencies?.[k]?.expanded_uncertainty;
const spread = (result, k) => number((100 * errorOf(result, k)) / result.modes[k].frequency, 2);

function frequencies(result, source) {
  const { modes } = result;
  const isRobot = modes.some((mode) => mode.yields);
  return {
    id: "frequencies",
    title: "Natural frequencies",
    n: modes.length,
    source,
    height: 110 + 36 * modes.length,
    wide: true,
    say: isRobot
      ? `Drives hold their commands, ${result.loaded ? "about the equilibrium under load" : "no load"}. Beside each: the joints and links that yield in it.`
      : "Of the link as it is held. Beside each: along which axes of the mesh it moves, by energy.",
    numbers: () => ({
      columns: ["mode", "frequency [Hz]", "error bar [Hz]", isRobot ? "what yields" : "motion"],
      rows: modes.map((mode, k) => [k + 1, mode.frequency, errorOf(result, k) ?? "", modeInWords(mode)]),
    }),
    draw: (look, narrow) =>
      bars(look, {
        names: modes.map((mode, k) => (narrow ? `${k + 1}` : `${k + 1}  ${plain(modeInWords(mode))}`)),
        values: modes.map((mode) => mode.frequency),
        colours: look.fitted,
        text: modes.map((mode, k) => `${number(mode.frequency)} Hz${errorOf(result, k) ? ` ± ${spread(result, k)} %` : ""}`),
        hover: modes.map((mode, k) => `mode ${k + 1}: ${number(mode.frequency, 4)} Hz<br>${plain(modeInWords(mode))}`),
        x: { title: "frequency [Hz]", rangemode: "tozero" },
        small: true,
      }),
  };
}

/** Size of a receptance from force to motion along one axis, at every frequency [m/N]. */
const sizes = (response, k) =>
  response.receptance.map(({ real, imaginary }) => Math.hypot(real[k][k], imaginary[k][k]));

function responseFigure(response, source) {
  const axes = ["x", "y", "z"];
  const { kind, value } = response.damping;
  const stated = kind === "modal" ? `damping ratio ${number(value)} of every mode` : `loss factor ${number(value)} of all springs`;
  const most = Math.max(...axes.flatMap((_, k) => sizes(response, k)));
  const { factor, unit } = unitFor("length", most);
  return {
    id: "frequency-response",
    title: "Response of the platform",
    n: response.frequencies.length,
    source,
    height: 420,
    wide: true,
    say: `How far the platform moves per newton that oscillates along the same axis, at its reference point, base axes; ${stated}, drives hold their commands.`,
    numbers: () => ({
      columns: ["frequency [Hz]", ...axes.map((a) => `${a} [m/N]`)],
      rows: response.frequencies.map((f, i) => [f, ...axes.map((_, k) => sizes(response, k)[i])]),
    }),
    draw: (look) => ({
      data: axes.map((name, k) => ({
        type: "scatter",
        mode: "lines",
        name,
        x: response.frequencies,
        y: sizes(response, k).map((v) => v / factor || null),
        line: { color: [look.fitted, look.held, look.final][k], width: 2, dash: ["solid", "dash", "dot"][k] },
        hovertemplate: `%{x:.4g} Hz: %{y:.3g} ${unit}/N<extra>along ${name}</extra>`,
      })),
      layout: layout(look, {
        xaxis: axis(look, "frequency [Hz]", { type: "log" }),
        yaxis: axis(look, `displacement over force [${unit}/N]`, { type: "log" }),
      }),
    }),
  };
}

/** The robot in one of its modes, far magnified; it moves while "Play" is pressed. */
function shapeFigure(result, { at_rest: rest, shapes }, source) {
  const view = new View({ mode: 0, phase: 1 });
  const size = extentOf([rest]);
  const farthest = (shape) =>
    Math.max(...shape.chains.flatMap((c, i) => c.points.map((p, k) => norm(p.map((x, j) => x - rest.chains[i].points[k][j])))));
  let playing = null;
  const stop = () => {
    clearInterval(playing);
    playing = null;
    play.textContent = "Play";
  };
  const play = element("button", {
    type: "button",
    onclick: () => {
      if (playing) return stop();
      let step = 0;
      play.textContent = "Stop";
      playing = setInterval(() => (play.isConnected ? view.set({ phase: Math.cos((++step * Math.PI) / 12) }) : stop()), 80);
    },
  }, "Play");
  const modeChoice = choice(
    "Mode",
    result.modes.map((mode, k) => [k, `${k + 1}: ${number(mode.frequency)} Hz`]),
    0,
    (k) => view.set({ mode: Number(k) }),
  );
  const figure = {
    id: "mode-shape",
    title: "How it moves",
    n: shapes.length,
    source,
    height: 520,
    wide: true,
    heavy: true,
    follows: ["mode", "phase"],
    say: "The robot in one of its modes, so far magnified that it is seen; grey: at rest. The right and left arrow keys take the next mode.",
    controls: [element("div", { class: "choices" }, modeChoice, " ", play)],
    step: (by) => {
      const mode = (view.get("mode") + by + shapes.length) % shapes.length;
      modeChoice.querySelector("select").value = String(mode);
      view.set({ mode });
    },
    numbers: () => ({
      columns: ["mode", "frequency [Hz]", ...["dx", "dy", "dz"].map((d) => `${d} [m]`), ...["rx", "ry", "rz"].map((r) => `${r} [rad]`)],
      rows: result.modes.map((mode, k) => [k + 1, mode.frequency, ...mode.platform]),
    }),
    draw(look) {
      const { factor, unit } = unitFor("length", size);
      const shape = shapes[view.get("mode")];
      const shown = magnified(rest, shape, (view.get("phase") * 0.08 * size) / (farthest(shape) || 1));
      return {
        data: [...skeletonTraces(shown, look, factor), ...skeletonTraces(rest, look, factor, { faint: true, name: "at rest" })],
        layout: layout(look, {
          uirevision: "mode",
          margin: { l: 0, r: 0, t: 0, b: 0 },
          legend: { orientation: "h", y: 0, yanchor: "top", x: 0, font: { size: 12 } },
          scene: { ...scene(look, unit), uirevision: "mode" },
        }),
      };
    },
  };
  return [figure, view];
}

export function modesSection({ result, picture }) {
  const { node, add } = section(headingOf(result));
  const source = `Source: ${result.inputs?.robot?.file ?? result.inputs?.mesh_file ?? result.link ?? "result"}.`;
  add(frequencies(result, source), new View({}));
  if (result.response) add(responseFigure(result.response, source), new View({}));
  if (picture?.shapes?.length) add(...shapeFigure(result, picture, source));
  const withError = result.modes.some((_, k) => errorOf(result, k));
  node.append(
    table(
      ["mode", "Hz", ...(withError ? ["± %"] : []), "what moves or yields"],
      result.modes.map((mode, k) => [
        k + 1,
        number(mode.frequency, 4),
        ...(withError ? [spread(result, k)] : []),
        modeInWords(mode),
      ]),
      "Modes",
    ),
  );
  return node;
}
