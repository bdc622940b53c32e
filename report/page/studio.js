// Effects switched on and off: the studio fits, the page shows.
import { element } from "./dom.js";
import { stated, statedWithError } from "./units.js";

/** What the server of this page says to a request; throws what was wrong in words. */
async function ask(action, body) {
  const response = await fetch(action, {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(body),
  });
  const answer = await response.json();
  if (!response.ok) throw new Error(answer.error);
  return answer;
}

const valueText = (p) =>
  p.deviation === null
    ? `${p.name} = ${stated(p.value, p.unit)} (at a bound)`
    : `${p.name} = ${statedWithError(p.value, p.deviation, p.unit)}`;

/** Switches above the charts. `show(model)` puts a model (or none) beside those of the comparison. */
export function studioPanel(names, show) {
  const on = [];
  const kinds = [...new Set(names.map((name) => name.split(" at ")[0]))];
  const status = element(
    "p",
    { role: "status", class: "say", id: "studio-status" },
    "No effect is switched on.",
  );
  const switches = element("ul", { id: "studio-effects" });
  const kind = element(
    "select",
    { id: "studio-kind", onchange: () => fillPlaces() },
    ...kinds.map((name) => element("option", { value: name }, name)),
  );
  const place = element("select", { id: "studio-place" });
  const fillPlaces = () =>
    place.replaceChildren(
      ...names
        .filter((name) => name.split(" at ")[0] === kind.value)
        .map((name) => element("option", { value: name }, name.split(" at ")[1])),
    );
  const file = element("input", {
    type: "text",
    id: "studio-file",
    value: "better.yaml",
    size: "20",
  });
  const controls = () => panel.querySelectorAll("button, select, input");
  fillPlaces();

  async function during(words, work) {
    status.textContent = words;
    controls().forEach((node) => {
      node.disabled = true;
    });
    try {
      await work();
    } catch (error) {
      status.textContent = `Not done: ${error.message}`;
    }
    controls().forEach((node) => {
      node.disabled = false;
    });
  }

  function fillSwitches(fitted) {
    switches.replaceChildren(
      ...on.map((name, k) =>
        element(
          "li",
          {},
          `${name}${fitted[k] ? `: ${fitted[k].parameters.map(valueText).join(", ")}` : ""} `,
          element(
            "button",
            {
              type: "button",
              "aria-label": `Switch ${name} off`,
              onclick: () => refit(on.filter((other) => other !== name)),
            },
            "Switch off",
          ),
        ),
      ),
    );
  }

  const refit = (wanted) =>
    during("Fitting ...", async () => {
      const answer = wanted.length ? await ask("fit", { effects: wanted }) : null;
      on.splice(0, on.length, ...wanted);
      fillSwitches(answer?.effects ?? []);
      status.textContent = answer
        ? `Chi-square per degree of freedom ${(answer.squared_error / answer.degrees_of_freedom).toPrecision(4)}.`
        : "No effect is switched on.";
      show(answer?.model ?? null);
    });
  const add = () => (on.includes(place.value) ? undefined : refit([...on, place.value]));
  const save = () =>
    during("Saving ...", async () => {
      status.textContent = `Saved as ${(await ask("save", { file: file.value })).file}.`;
    });
  const panel = element(
    "div",
    { class: "verdict", id: "studio" },
    element("h2", {}, "Effects in the model"),
    element(
      "p",
      {},
      element("label", {}, "Effect ", kind),
      " ",
      element("label", {}, "at ", place),
      " ",
      element("button", { type: "button", id: "studio-add", onclick: add }, "Switch on"),
    ),
    switches,
    status,
    element(
      "p",
      {},
      element("label", {}, "Robot file ", file),
      " ",
      element("button", { type: "button", id: "studio-save", onclick: save }, "Save"),
    ),
  );
  return panel;
}
