// What can act at a place: each effect with its law in words and as a formula, and its usual size.
import { element } from "../dom.js";
import { number, stated, unitOf } from "../units.js";
import { probabilityInWords } from "../words.js";
import { sketch } from "./sketches.js";

/** Places that are no joints of the picture: {place: title}. */
export function otherPlaces(effects, joints) {
  const found = new Map();
  for (const effect of effects)
    if (!effect.places.some((place) => joints.has(place)))
      found.set(`at ${effect.at}`, effect.where || effect.at);
  return found;
}

/** Those that act at a joint (of it alone first), or at another place as otherPlaces() names it. */
export const effectsAt = (effects, place) =>
  effects
    .filter((e) => e.places.includes(place) || `at ${e.at}` === place)
    .sort((a, b) => a.places.length - b.places.length);

/** "usually 0.2 mm". */
export function usualSize(effect) {
  const [leading] = effect.parameters;
  const { usual, none, unit } = leading;
  return `usually ${leading.name} ${none ? "within " : ""}${stated(none ? Math.abs(usual - none) : usual, unit, 2)}${none ? ` of ${stated(none, unit, 2)}` : ""}`;
}

/** on: names of effects in the model; probabilities: by name, from the verdict; toggle(effect). */
export function effectList(effects, on, probabilities, toggle) {
  return element(
    "ul",
    { class: "effects" },
    ...effects.map((effect) => {
      const active = on.includes(effect.name);
      const p = probabilities?.[effect.name];
      return element(
        "li",
        {},
        element(
          "button",
          {
            type: "button",
            class: "effect",
            "data-effect": effect.name,
            "aria-pressed": String(active),
            onclick: () => toggle(effect),
          },
          element(
            "span",
            { class: "effect-head" },
            element("b", {}, effect.kind.replaceAll("_", " ")),
            effect.places.length > 1 ? element("span", {}, "the same at each") : null,
            p === undefined ? null : element("i", {}, probabilityInWords(p).replace(/ \(.*/, "")),
            element("i", {}, active ? "in the model" : "+ add"),
          ),
          element("span", { class: "effect-looks" }, element("span", {}, effect.summary), sketch(effect.kind)),
          element("code", {}, effect.law),
          element("span", { class: "say" }, `${usualSize(effect)}. Shows as: ${effect.signature}`),
        ),
      );
    }),
  );
}

/** Range of a slider: from where there is no effect to thrice the usual or the fitted value, within what is possible. */
export function sliderRange(parameter, value) {
  const { usual, none, lower, upper } = parameter;
  const reach = 3 * Math.max(Math.abs(usual - none), Math.abs(value - none)) || 1;
  return [Math.max(lower ?? -Infinity, none - reach), Math.min(upper ?? Infinity, none + reach)];
}

/** Sliders for the values of the effects of a model. change(values) with a list for each effect. */
export function sliders(card, effects, change) {
  const values = card.effects.map((e) => e.parameters.map((p) => p.value));
  const one = (fitted, e, k) => {
    const parameter = effects.find((x) => x.name === fitted.name).parameters[k];
    const start = values[e][k];
    const [from, to] = sliderRange(parameter, start);
    const { factor, unit } = unitOf(Math.max(Math.abs(from), Math.abs(to)), parameter.unit);
    const show = (v) => `${number(v / factor)} ${unit}`.trim();
    const shown = element("output", {}, show(start));
    return element(
      "label",
      { class: "value" },
      element("span", {}, `${parameter.name} `, shown),
      element("input", {
        type: "range",
        min: 0,
        max: 1,
        step: 0.002,
        value: (start - from) / (to - from),
        "aria-label": `${parameter.name} of ${fitted.name}`,
        "aria-valuetext": show(start),
        oninput: (event) => {
          const v = from + Number(event.target.value) * (to - from);
          values[e][k] = v;
          shown.textContent = show(v);
          event.target.setAttribute("aria-valuetext", show(v));
          change(values.map((list) => [...list]));
        },
      }),
    );
  };
  return element(
    "div",
    { class: "sliders" },
    ...card.effects.flatMap((fitted, e) => [
      element("h3", {}, fitted.name.replaceAll("_", " ")),
      ...fitted.parameters.map((_, k) => one(fitted, e, k)),
    ]),
  );
}
