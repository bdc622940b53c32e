// Section of modes: natural frequencies of a link or of a robot, and what moves or yields in each.
import { bars } from "../bars.js";
import { plain, table } from "../dom.js";
import { headingOf, section } from "../section.js";
import { number } from "../units.js";
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
    .map(([share, axis]) => `${shareInWords(share)} along ${axis}`)
    .join(", ");
}

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
      ? "Drives hold their commands, no load. Beside each: the joints and links that yield in it."
      : "Of the link as it is held. Beside each: along which axes of the mesh it moves, by energy.",
    numbers: () => ({
      columns: ["mode", "frequency [Hz]", "error bar [Hz]", isRobot ? "what yields" : "motion"],
      rows: modes.map((mode, k) => [k + 1, mode.frequency, mode.error ?? "", modeInWords(mode)]),
    }),
    draw: (look, narrow) =>
      bars(look, {
        names: modes.map((mode, k) => (narrow ? `${k + 1}` : `${k + 1}  ${plain(modeInWords(mode))}`)),
        values: modes.map((mode) => mode.frequency),
        colours: look.fitted,
        text: modes.map((mode) => `${number(mode.frequency)} Hz`),
        hover: modes.map((mode, k) => `mode ${k + 1}: ${number(mode.frequency, 4)} Hz<br>${plain(modeInWords(mode))}`),
        x: { title: "frequency [Hz]", rangemode: "tozero" },
        small: true,
      }),
  };
}

export function modesSection({ result }) {
  const { node, add } = section(headingOf(result));
  const source = `Source: ${result.inputs?.robot?.file ?? result.inputs?.mesh_file ?? result.link ?? "result"}.`;
  add(frequencies(result, source), new View({}));
  const withError = result.modes.some((mode) => mode.error);
  node.append(
    table(
      ["mode", "Hz", ...(withError ? ["± %"] : []), "what moves or yields"],
      result.modes.map((mode, k) => [
        k + 1,
        number(mode.frequency, 4),
        ...(withError ? [number((100 * mode.error) / mode.frequency, 2)] : []),
        modeInWords(mode),
      ]),
      "Modes",
    ),
  );
  return node;
}
