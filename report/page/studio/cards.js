// The models that were tried, a card each: error, degrees of freedom, whether the last effect is worth having.
import { element, table } from "../dom.js";
import { number, stated, statedWithError } from "../units.js";
import { probabilityInWords } from "../words.js";

export const valueInWords = (p) =>
  p.deviation === null
    ? `${p.name} ${stated(p.value, p.unit)} (at a bound)`
    : `${p.name} ${statedWithError(p.value, p.deviation, p.unit)}`;

/** "likelier than without: 98 %", and when the last effect is of no use. */
export function worthInWords(card) {
  if (card.nothing) return "its best size is zero: no better than without";
  if (card.probability === null) return "";
  if (card.probability < 0.5) return "no better than without";
  return `better than without: ${probabilityInWords(card.probability)}`;
}

const stiffnessChanges = (card) =>
  card.stiffnesses
    .map(({ name, factor }) => ({ name, percent: 100 * (factor - 1) }))
    .sort((a, b) => Math.abs(b.percent) - Math.abs(a.percent))
    .slice(0, 3)
    .map(({ name, percent }) => `${name} ${percent < 0 ? "−" : "+"}${number(Math.abs(percent), 2)} %`)
    .join(", ");

function errorBar(error, largest) {
  const bar = element("div", { class: "error-bar", "aria-hidden": "true" });
  const part = (kind, share) => {
    const node = element("span", { class: kind });
    node.style[kind === "one" ? "left" : "width"] = `${(100 * share).toFixed(1)}%`;
    bar.append(node);
  };
  part("fill", error / largest);
  if (largest > 1) part("one", 1 / largest);
  return bar;
}

/**
 * models: [{card, title, fixed}]; chosen: the index of one; ticked: a set of titles to compare. act: {restore(model), remove(model),
 * tick(model, is)}.
 */
export function cardList(models, chosen, ticked, act) {
  const largest = 1.05 * Math.max(1, ...models.map((m) => m.card.error));
  return element(
    "ul",
    { class: "cards" },
    ...models.map((model, k) => {
      const { card, title } = model;
      const worth = worthInWords(card);
      const about =
        card.effects.flatMap((e) => e.parameters.map(valueInWords)).join(", ") ||
        (title === "nominal" ? "as the robot file has it" : stiffnessChanges(card));
      return element(
        "li",
        {
          class: `card${k === chosen ? " chosen" : ""}${/no better/.test(worth) ? " poor" : ""}`,
          "data-model": title,
        },
        element(
          "div",
          { class: "card-head" },
          element("strong", {}, title.replaceAll("_", " ")),
          element("span", { class: "error" }, number(card.error)),
        ),
        errorBar(card.error, largest),
        element("p", {}, `${card.degrees_of_freedom} degrees of freedom${worth ? "; " : ""}`, element("b", {}, worth)),
        element("p", { class: "say" }, about),
        element(
          "div",
          { class: "card-tools" },
          element(
            "label",
            {},
            element("input", {
              type: "checkbox",
              checked: ticked.has(title),
              "aria-label": `Compare ${title}`,
              onchange: (event) => act.tick(model, event.target.checked),
            }),
            " compare",
          ),
          k === chosen
            ? element("span", { class: "now" }, "shown")
            : element(
                "button",
                { type: "button", "aria-label": `Show ${title}`, onclick: () => act.restore(model) },
                "Show",
              ),
          model.fixed
            ? null
            : element(
                "button",
                { type: "button", "aria-label": `Remove ${title}`, onclick: () => act.remove(model) },
                "Remove",
              ),
        ),
      );
    }),
  );
}

/** Two models beside each other: error, degrees of freedom, every value and stiffness of either. */
export function comparisonTable(a, b) {
  const values = (card) =>
    new Map([
      ...card.effects.flatMap((e) =>
        e.parameters.map((p) => [`${e.name}, ${p.name}`, valueInWords(p).slice(p.name.length + 1)]),
      ),
      ...card.stiffnesses.map((s) => [`stiffness ${s.name}`, `${number(100 * s.factor)} %`]),
    ]);
  const [left, right] = [values(a.card), values(b.card)];
  const rows = [
    ["error, times the noise", number(a.card.error), number(b.card.error)],
    ["chi-square", number(a.card.squared_error, 4), number(b.card.squared_error, 4)],
    ["degrees of freedom", a.card.degrees_of_freedom, b.card.degrees_of_freedom],
    ...[...new Set([...left.keys(), ...right.keys()])].map((key) => [
      key,
      left.get(key) ?? "-",
      right.get(key) ?? "-",
    ]),
  ];
  return table(["what", a.title, b.title], rows, "Two models compared");
}
