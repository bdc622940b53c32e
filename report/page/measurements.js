// The section of one campaign: findings of a comparison and a diagnosis, most important first.
import { againstLoad, extraDeflection, jointCurve } from "./against_load.js";
import { certificateTable, errorShares, worstReadings } from "./certificate.js";
import { choice, element, list } from "./dom.js";
import { confusion, ranking } from "./effects.js";
import { Figure } from "./figure.js";
import { fourPlot } from "./four_plot.js";
import { dependences, identifiability } from "./knowledge.js";
import { oddEven, oddEvenPanel } from "./odd_even.js";
import { parity } from "./parity.js";
import { likelihoodProfile } from "./profiles.js";
import { Readings, columnsFromResult } from "./readings.js";
import { number, stated, statedWithError } from "./units.js";
import { View } from "./view.js";
import { stagesOfDiagnosis, stagesOfReadings, waterfall } from "./waterfall.js";
import { occasionInWords, probabilityInWords, verdictInWords } from "./words.js";
import { arrows, poseMap } from "./workspace.js";

const isBeforeAfter = (result) => Boolean(result.before?.as_designed && result.after?.as_designed);
const campaignOf = ({ campaign, before }) =>
  typeof campaign === "string" ? campaign : (campaign?.name ?? before?.campaign?.name);
export const isMeasurement = ({ result }) =>
  campaignOf(result) !== undefined &&
  Boolean(result.as_designed || result.verdict || isBeforeAfter(result));

/** Two models with the same readings: the last state of each. */
function columnsOfBoth({ before, after, configurations }) {
  const last = (columns, name) => ({ ...columns.models.at(-1), name });
  const [old, corrected] = [before, after].map((result) => columnsFromResult(result, configurations));
  return { ...corrected, models: [last(old, "before"), last(corrected, "after")] };
}

/** Entries about one campaign belong together: {name, diagnosis, comparison, both, columns}. */
export function campaigns(entries) {
  const found = new Map();
  for (const { result, picture } of entries.filter(isMeasurement)) {
    const name = campaignOf(result);
    if (!found.has(name)) found.set(name, { name });
    const one = found.get(name);
    if (result.verdict) one.diagnosis = result;
    if (result.as_designed) one.comparison = result;
    if (isBeforeAfter(result)) {
      Object.assign(one, { both: result, comparison: result.after });
      one.columns = picture?.readings ?? columnsOfBoth(result);
    }
    one.curve = one.curve ?? picture?.joint_curve;
    if (
      picture?.readings &&
      (!one.columns || picture.readings.models.length > one.columns.models.length)
    )
      one.columns = picture.readings;
  }
  return [...found.values()];
}

const withErrors = (found) =>
  found.parameters
    .map(
      (p, k) =>
        `${p.name} = ${found.deviations[k] === null ? `${stated(found.values[k], p.unit)} (at a bound)` : statedWithError(found.values[k], found.deviations[k], p.unit)}`,
    )
    .join(", ");

function diagnosisVerdict(diagnosis) {
  const names = diagnosis.found.map((f) => `${f.effect} at ${f.at}`);
  const kind = diagnosis.verdict;
  const lines = diagnosis.found.map((f) =>
    element(
      "p",
      {},
      element("strong", {}, f.sentence ?? `${f.effect} at ${f.at}`),
      `. ${f.effect} at ${f.at}: ${withErrors(f)}.`,
      f.which_law ? ` Which law: ${f.which_law}.` : "",
      f.inseparable ? ` Note: ${f.inseparable}.` : "",
    ),
  );
  if (diagnosis.doubted)
    lines.push(element("p", {}, `Perhaps ${diagnosis.doubted.sentence}.`));
  if (diagnosis.ambiguous.length > 1)
    lines.push(
      element(
        "p",
        {},
        `These readings do not distinguish ${diagnosis.ambiguous[0]} from: ${diagnosis.ambiguous.slice(1).join("; ")}.`,
      ),
    );
  lines.push(...(diagnosis.remarks ?? []).map((text) => element("p", {}, text)));
  lines.push(...diagnosis.missing.map((text) => element("p", {}, `Missing: ${text}.`)));
  // Files written before 2027 have other words.
  const good = [
    "none needed",
    "identified",
    "no effect needed",
    "named effect",
  ].includes(kind);
  const lead =
    kind === "unexplained" || kind === "none of the above"
      ? "The nearest effect:"
      : "Missing from the model:";
  return element(
    "div",
    { class: `verdict ${good ? "good" : "bad"}` },
    element(
      "p",
      {},
      "Verdict: ",
      element("strong", {}, verdictInWords(kind)),
      names.length ? `. ${lead}` : ".",
    ),
    ...lines,
  );
}

function comparisonVerdict(comparison, switched) {
  const words = {
    adequate: "The model is adequate: no test finds more than noise.",
    inadequate: "The model fails: its error is more than noise.",
    not_evaluated:
      "The noise is known from nothing but the residual itself, so that the model cannot be judged.",
  };
  return element(
    "div",
    { class: `verdict ${comparison.adequacy === "adequate" ? "good" : "bad"}` },
    switched ? element("p", {}, `Without ${switched}:`) : null,
    element("p", {}, element("strong", {}, words[comparison.adequacy])),
    element(
      "p",
      {},
      (comparison.refitted &&
        comparison.findings.find((text) => /^The (re)?fitted model/.test(text))) ||
        comparison.findings[0] ||
        "",
    ),
  );
}

function bothVerdict({ waterfall: stages }) {
  const last = (name) => stages.filter((s) => s.name.startsWith(name)).at(-1)?.whitened;
  const [before, after] = [last("before"), last("after")];
  if (before === undefined || after === undefined)
    return element("div", { class: "verdict" }, "The noise is known from nothing but the residual.");
  const falls = after < before;
  const words = `The held-out error ${falls ? "falls" : "rises"} from ${number(before)} to ${number(after)} times the noise.`;
  return element(
    "div",
    { class: `verdict ${falls ? "good" : "bad"}` },
    element("strong", {}, words),
  );
}

function tools(readings, view) {
  const poses = [
    ["", "all"],
    ...readings.poses.map((pose, p) => [p, pose.label || "the only one"]),
  ];
  const node = element("div", {
    class: "tools",
    role: "toolbar",
    "aria-label": "What the charts show",
  });
  const fill = () =>
    node.replaceChildren(
      choice(
        "Model",
        readings.models.map((m, k) => [k, m.name]),
        view.get("model"),
        (v) => view.set({ model: Number(v) }),
      ),
      choice(
        "Component",
        readings.components.map((c) => [c, c]),
        view.get("component"),
        (v) => view.set({ component: v }),
      ),
      choice("Pose", poses, view.get("pose") ?? "", (v) =>
        view.set({ pose: v === "" ? null : Number(v) }),
      ),
    );
  fill();
  // The choices are not on paper, but what was chosen is.
  const said = element("p", { class: "say paper" });
  const say = () => {
    const pose = view.get("pose");
    said.textContent = `Shown below: model ${readings.models[view.get("model")].name}, component ${view.get("component")}, ${pose === null ? "all poses" : `pose ${readings.poseText(pose)}`}.`;
  };
  say();
  view.listen((keys) => {
    if (keys.includes("pose")) node.querySelectorAll("select")[2].value = view.get("pose") ?? "";
    say();
  });
  return [node, said];
}

// The component with the largest error in units of its noise is looked at first.
export function worstComponent(readings) {
  const size = (c) => {
    const used = readings.used(c);
    return used.reduce((s, i) => s + readings.whitened(0, c, i) ** 2, 0) / Math.max(1, used.length);
  };
  return [...readings.components].sort((a, b) => size(b) - size(a))[0];
}

/** Five sentences; the rest behind a line. */
function findings(comparison) {
  if (!comparison) return null;
  const [first, rest] = [comparison.findings.slice(0, 5), comparison.findings.slice(5)];
  return element(
    "div",
    {},
    element("h3", {}, "Findings, worst first"),
    list(first),
    rest.length
      ? element("details", {}, element("summary", {}, `${rest.length} more`), list(rest))
      : null,
  );
}

/** The note on data that JSON of a diagnosis leaves out, and where to get them. */
const withoutReadings = () =>
  element(
    "p",
    { class: "say" },
    "The charts of the readings are not here, because this result does not hold them. To have them, give 'kinetostat report' the page that 'diagnose --html' wrote, or what 'compare --json' wrote of the same campaign, too.",
  );

export function measurementSection({ name, diagnosis, comparison, both, columns, curve, switched }) {
  const source = `Source: ${name}.`;
  const stated = occasionInWords((diagnosis ?? both?.before ?? comparison)?.campaign);
  const about = stated ? element("p", { class: "say occasion" }, stated) : "";
  const section = element("section", { class: "measurements" }, element("h2", {}, name), about);
  const add = (parent, spec, view) => parent.append(new Figure(spec, view).node);
  const charts = () => {
    const node = element("div", { class: "charts" });
    section.append(node);
    return node;
  };
  const readings =
    columns || comparison?.readings ? new Readings(columns ?? columnsFromResult(comparison)) : null;
  if (!readings && comparison) section.append(findings(comparison));
  if (!readings) section.append(withoutReadings());
  const view = new View({
    model: readings ? readings.models.length - 1 : 0,
    component: readings ? worstComponent(readings) : "",
    pose: null,
  });
  section.append(
    diagnosis
      ? diagnosisVerdict(diagnosis)
      : both
        ? bothVerdict(both)
        : comparisonVerdict(comparison, switched),
  );
  const first = charts();
  const known = [diagnosis, both].find((result) => result?.waterfall?.length);
  const stages = known ? stagesOfDiagnosis(known) : readings ? stagesOfReadings(readings) : null;
  if (stages) add(first, waterfall(stages, source, readings?.count ?? stages.stages.length), view);
  if (curve) for (const spec of [jointCurve, extraDeflection]) add(first, spec(curve, source), view);
  if (readings) {
    add(first, errorShares(readings, view, source), view);
    first.append(
      element(
        "div",
        { class: "table-wide" },
        certificateTable(readings),
        worstReadings(readings, readings.models.length - 1) ?? "",
      ),
      findings(comparison) ?? "",
    );
    section.append(...tools(readings, view));
    const all = charts();
    if (readings.loads.length) add(all, againstLoad(readings, view, source), view);
    if (
      readings.loads.length &&
      oddEven(readings, readings.components[0], 0, readings.loads[0]).length
    )
      add(all, oddEvenPanel(readings, view, source), view);
    add(all, parity(readings, view, source), view);
    if (readings.poses.length > 1 && readings.loads.length)
      add(all, poseMap(readings, view, source), view);
    if (readings.poses.length > 1 && readings.components.some((c) => c.startsWith("d")))
      add(all, arrows(readings, view, source), view);
    add(all, fourPlot(readings, view, source), view);
  }
  const last = charts();
  const assessment = comparison?.refitted ?? comparison?.as_designed;
  diagnosis?.steps.forEach((step, k) => {
    if (step.ranking.some((r) => r.observable)) add(last, ranking(step, k + 1, source, diagnosis.found?.[k]?.decision), view);
    if (step.confusion?.candidates.length > 1)
      add(last, confusion(step.confusion, k + 1, source), view);
  });
  if (assessment?.patterns.factors.length) add(last, dependences(assessment, source), view);
  if (assessment?.parameters.length) add(last, identifiability(assessment, source), view);
  diagnosis?.profiles
    ?.filter((profile) => profile.points.length > 1)
    .forEach((profile, k) => add(last, likelihoodProfile(profile, k + 1, source), view));
  return section;
}
