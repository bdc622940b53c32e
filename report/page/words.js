// Words for people, where JSON has kept older ones.
import { sentenceAsChosen } from "./units.js";

/** Signs of a terminal as a page has them, in the units that were chosen. */
export const inPrint = (text) =>
  sentenceAsChosen(String(text ?? ""))
    .replaceAll(" +- ", " ± ")
    .replace(/(\d) u(m|rad)\b/g, "$1 µ$2")
    .replace(/\b([mu]?m)\^([23])/g, (_, unit, power) => unit + { 2: "²", 3: "³" }[power]);

/** "Measured on 2026-03-01 by A. Berger with a dial gauge, machine 4711."; empty where nothing is stated. */
export function occasionInWords(campaign) {
  const { date, operator, instrument, serial } = campaign ?? {};
  const parts = [
    date && `on ${date.replace("T", " ")}`,
    operator && `by ${operator}`,
    instrument && `with ${instrument}`,
  ].filter(Boolean);
  const measured = parts.length ? `Measured ${parts.join(" ")}` : "";
  const machine = serial ? (measured ? `, machine ${serial}` : `Machine ${serial}`) : "";
  return measured || machine ? `${measured}${machine}.` : "";
}

/** A verdict as `diagnose` writes it. */
export const verdictInWords = (kind) =>
  kind === "these data cannot tell" ? "inconclusive" : kind;

/** The name of a model, or of a stage of the falling error. */
export const modelInWords = (name) =>
  name
    .replace(/\bas designed$/, "nominal")
    .replace(/\brefitted$/, "fitted")
    .replace(/^\+ \w+/, (kind) => kind.replaceAll("_", " "));

/** "over 99.9 %", "56.3 %", "0.11 % (odds 1 : 876)". */
export function probabilityInWords(p) {
  if (p > 0.999) return "over 99.9 %";
  const percent = (digits) => `${Number((100 * p).toPrecision(digits))} %`;
  return p >= 0.01 || p <= 0 ? percent(3) : `${percent(2)} (odds 1 : ${Math.round(1 / p - 1)})`;
}
