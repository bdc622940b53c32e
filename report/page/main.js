// Opens the results of this page and shows the sections that they have something for.
import { beamSection, isBeam } from "./beams.js";
import { compensationSection, isCompensation } from "./compensation.js";
import { element } from "./dom.js";
import { redrawAll } from "./figure.js";
import { isLink, linkSection } from "./links.js";
import { isMap, mapSection } from "./maps.js";
import { campaigns, isMeasurement, measurementSection } from "./measurements.js";
import { isPath, pathSection } from "./paths.js";
import { isPlan, planSection } from "./plans.js";
import { isPosture, postureSection } from "./postures.js";
import { startStudio } from "./studio/app.js";
import { isStudy, studySection } from "./study.js";

const kinds = [
  [isLink, linkSection],
  [isBeam, beamSection],
  [isPosture, postureSection],
  [isPath, pathSection],
  [isMap, mapSection],
  [isCompensation, compensationSection],
  [isPlan, planSection],
];

// One result that is not as expected does not take the others with it.
function guarded(show, entry) {
  try {
    return show(entry);
  } catch (error) {
    console.error(error);
    return element(
      "section",
      {},
      element("p", { role: "alert" }, `A result could not be drawn: ${error.message}`),
    );
  }
}

/** A result that there is no picture of. */
function textSection({ result, text }) {
  return element(
    "section",
    {},
    element("h2", {}, result.command ?? "Result"),
    element("pre", { tabindex: "0" }, text || JSON.stringify(result, null, 1)),
  );
}

/** What is about campaigns first, then the rest as it came. */
function sections(given) {
  const study = given.find(isStudy);
  if (study) {
    const rest = sections(given.filter((entry) => entry !== study && !isStudy(entry)));
    return [guarded((entry) => studySection(entry, rest), study)];
  }
  const others = given
    .filter((entry) => !isMeasurement(entry))
    .flatMap((entry) => {
      const known = kinds.filter(([is]) => is(entry));
      return known.length ? known.map(([, show]) => guarded(show, entry)) : [textSection(entry)];
    });
  const diagnosedFirst = (a, b) => Boolean(b.diagnosis) - Boolean(a.diagnosis);
  return [
    ...campaigns(given).sort(diagnosedFirst).map((one) => guarded(measurementSection, one)),
    ...others,
  ];
}

async function inflated(id) {
  const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (letter) =>
    letter.charCodeAt(0),
  );
  return new Response(
    new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate")),
  ).text();
}

function runInPage(text) {
  document.head.append(element("script", {}, text));
}

function about({ result }) {
  const options = Object.entries(result.options ?? {})
    .map(([name, value]) => `${name} ${value}`)
    .join(", ");
  const files = [
    result.inputs?.robot,
    ...(result.inputs?.links ?? []),
    result.campaign?.campaign,
    result.campaign?.readings,
  ].filter((f) => f?.sha256);
  return element(
    "li",
    {},
    `${result.tool ?? "kinetostat"} ${result.command ?? ""} (${options})`,
    element("ul", {}, ...files.map((f) => element("li", {}, `${f.file}, sha256 ${f.sha256}`))),
  );
}

function origins(entries) {
  const texts = entries
    .filter((entry) => entry.text)
    .map((entry) =>
      element(
        "details",
        {},
        element("summary", {}, `The report of ${entry.result.command} as text`),
        element("pre", { tabindex: "0" }, entry.text),
      ),
    );
  return element(
    "section",
    {},
    element("h2", {}, "Where this comes from"),
    ...texts,
    element("ul", { class: "source" }, ...entries.filter((e) => e.result.command).map(about)),
  );
}

function buttons() {
  const dark = () =>
    document.documentElement.dataset.theme
      ? document.documentElement.dataset.theme === "dark"
      : matchMedia("(prefers-color-scheme: dark)").matches;
  const turn = () => {
    document.documentElement.dataset.theme = dark() ? "light" : "dark";
    redrawAll();
  };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redrawAll);
  return element(
    "div",
    {},
    element("button", { type: "button", onclick: turn }, "Light or dark"),
    " ",
    element("button", { type: "button", onclick: () => print() }, "Print"),
  );
}

async function start() {
  const entries = JSON.parse(await inflated("results"));
  const page = document.getElementById("page");
  document.getElementById("top").append(buttons());
  if (entries[0]?.result.command === "studio") {
    document.body.classList.add("studio");
    let charts = null;
    await startStudio(page, () => (charts ??= inflated("plotly").then(runInPage)));
    page.dataset.ready = "yes";
    return;
  }
  await inflated("plotly").then(runInPage);
  page.replaceChildren(...sections(entries), origins(entries));
  page.dataset.ready = "yes";
}

start().catch((error) => {
  document
    .getElementById("page")
    .replaceChildren(
      element(
        "p",
        { role: "alert" },
        `This page could not be drawn: ${error.message}. It needs a browser of 2023 or later.`,
      ),
    );
  throw error;
});
