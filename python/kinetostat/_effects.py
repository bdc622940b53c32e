"""Laws of one's own, written in Python.

A law of elementary functions becomes a formula of the robot file, with exact derivatives, that every command knows. Any
other smooth function is called as it is; its derivatives are those given, else by complex step."""

import inspect
import json
import math
import re
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Union

from ._core import ArgumentError, ArgumentTypeError, FunctionKind, Robot, law_variables, usual_values
from ._frames import _plain

_FUNCTIONS = {"sin": "sin", "cos": "cos", "tan": "tan", "arcsin": "asin", "arccos": "acos", "arctan": "atan", "sinh": "sinh",
              "cosh": "cosh", "tanh": "tanh", "arcsinh": "asinh", "arccosh": "acosh", "arctanh": "atanh", "exp": "exp", "log": "ln",
              "log2": "log2", "log10": "log10", "sqrt": "sqrt"}
_OPERATORS = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/", "power": "^"}


class _NoFormula(TypeError):
    pass


class _Term:
    """A formula that grows as a function computes with it."""

    def __init__(self, text: str) -> None:
        self.text = text

    @staticmethod
    def of(value: Any) -> "_Term":
        if isinstance(value, _Term):
            return value
        number = float(value)
        if not math.isfinite(number):
            raise _NoFormula(f"{number} is no number of a formula")
        return _Term(repr(number) if number >= 0 else f"({number!r})")

    def _with(self, operator: str, other: Any, swapped: bool = False) -> "_Term":
        one, two = (_Term.of(other), self) if swapped else (self, _Term.of(other))
        return _Term(f"({one.text} {operator} {two.text})")

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **keys: Any) -> "_Term":
        name = ufunc.__name__
        if method == "__call__" and not keys and name in _FUNCTIONS:
            return _Term(f"{_FUNCTIONS[name]}({_Term.of(inputs[0]).text})")
        if method == "__call__" and not keys and name in _OPERATORS:
            return _Term.of(inputs[0])._with(_OPERATORS[name], inputs[1])
        if name == "negative":
            return -_Term.of(inputs[0])
        if name == "square":
            return _Term.of(inputs[0]) ** 2
        raise _NoFormula(f"numpy.{name} is in no formula")

    def __neg__(self) -> "_Term":
        return _Term(f"(-{self.text})")

    def __pos__(self) -> "_Term":
        return self

    def __bool__(self) -> bool:
        raise _NoFormula("a formula has no cases")


for _name, _sign in (("add", "+"), ("sub", "-"), ("mul", "*"), ("truediv", "/"), ("pow", "^")):
    setattr(_Term, f"__{_name}__", lambda self, other, sign=_sign: self._with(sign, other))
    setattr(_Term, f"__r{_name}__", lambda self, other, sign=_sign: self._with(sign, other, True))


class EffectKind:
    """A law about one joint. `formula`: what it was translated to; None where Python computes it."""

    def __init__(self, name: str, law: str, formula: Optional[str], function: Optional[FunctionKind], entry: Dict[str, Any]) -> None:
        self.name, self.law, self.formula, self.function, self._entry = name, law, formula, function, entry

    @property
    def parameters(self) -> List[str]:
        return list(self._entry["parameters"])

    def __repr__(self) -> str:
        return f"EffectKind '{self.name}': {self.law} {self.formula or 'by a function of Python'}"


def effect_kind(function: Optional[Callable[..., Any]] = None, *, parameters: Mapping[str, Mapping[str, Any]], law: str = "force",
                covariates: Sequence[str] = (), derivatives: Optional[Mapping[str, Callable[..., Any]]] = None,
                name: str = "", summary: str = "", formula: bool = True) -> Any:
    """A kind of effect from a function; to be used as a decorator, too.

    Its arguments are variables of the law by name, as the robot file has them (`d`, `x`, `u`, `t`, `T`, `fx` ... `mz`), covariates and
    `parameters`, e.g. {"a": {"unit": "N", "between": [0, 200], "prior": 20}}; SI inside. `law` says what it returns: "force",
    "offset" or "compliance". `derivatives`: partial derivatives by argument; those that are missing are computed by complex step.
    `formula=False` calls the function even where it could be a formula."""
    if function is None:
        return lambda given: effect_kind(given, parameters=parameters, law=law, covariates=covariates, derivatives=derivatives,
                                         name=name, summary=summary, formula=formula)
    arguments = list(inspect.signature(function).parameters)
    described = {key: dict(value) for key, value in parameters.items()}
    variables = law_variables(law, list(covariates), json.dumps(described))
    for argument in arguments:
        if argument not in variables:
            raise ArgumentError(f"'{argument}' is no variable of a law of {law}: " + ", ".join(variables))
    for parameter in described:
        if parameter not in arguments:
            raise ArgumentError(f"the function does not take its parameter '{parameter}'")
    entry: Dict[str, Any] = {"summary": summary or (inspect.getdoc(function) or "a law of one's own").split("\n")[0],
                             "parameters": described}
    if covariates:
        entry["covariates"] = list(covariates)
    name = name or function.__name__
    text = _formula_of(function, arguments) if formula and not derivatives else None
    if text is not None:
        return EffectKind(name, law, text, None, {law: text, **entry})
    call = _checked(name, function, arguments, variables, dict(derivatives or {}), usual_values(json.dumps(described)))
    core = FunctionKind(name, law, call, [v in arguments for v in variables], json.dumps(described), list(covariates), entry["summary"])
    return EffectKind(name, law, None, core, entry)


def _formula_of(function: Callable[..., Any], arguments: List[str]) -> Optional[str]:
    try:
        return _Term.of(function(*(_Term(argument) for argument in arguments))).text
    except (TypeError, AttributeError):  # what a formula cannot hold
        return None


def _checked(name: str, function: Callable[..., Any], arguments: List[str], variables: List[str],
             derivatives: Dict[str, Callable[..., Any]], usual: Any) -> Callable[[List[float], int], Any]:
    """What the law calls: value, and slope by one of the variables. Its derivatives are compared with differences first."""
    for argument in derivatives:
        if argument not in arguments:
            raise ArgumentError(f"derivatives: the function takes no '{argument}'")
    places = [variables.index(argument) for argument in arguments]
    step = 1e-100  # its square is nothing beside any number

    def found_at(values: List[float], by: int) -> Any:
        if by < 0:
            return float(function(*values)), 0.0
        at = places.index(by)
        if arguments[at] in derivatives:
            return float(function(*values)), float(derivatives[arguments[at]](*values))
        shifted = [complex(value, step if k == at else 0) for k, value in enumerate(values)]
        found = complex(function(*shifted))
        return found.real, found.imag / step

    def call(numbers: List[float], by: int) -> Any:
        values = [numbers[place] for place in places]
        value, slope = found_at(values, by)
        if not (math.isfinite(value) and math.isfinite(slope)):
            at = ", ".join(f"{argument}={number:.6g}" for argument, number in zip(arguments, values))
            raise ArgumentError(f"the law '{name}' is {value} with a slope of {slope} at {at}: a law must be finite wherever a joint "
                                "may stand, for all values of its parameters")
        return value, slope

    for argument, derivative in derivatives.items():
        _check_arguments(derivative, argument, arguments)
    for share in (0.3, -0.7):
        at = [share * 1e-4] * (len(variables) - len(usual)) + [float(value) * (1 + 0.1 * share) for value in usual]
        values = [at[place] for place in places]
        _number(function(*values), "the function")
        for argument, derivative in derivatives.items():
            _number(derivative(*values), f"derivatives['{argument}']")
        for argument, place in zip(arguments, places):
            _check_slope(call, at, place, argument)
    return call


def _number(found: Any, what: str) -> None:
    try:
        float(found)
    except (TypeError, ValueError) as error:
        raise ArgumentTypeError(f"{what} returns {found!r} ({type(found).__name__}), and a law is one number") from error


def _check_arguments(derivative: Any, argument: str, arguments: List[str]) -> None:
    if not callable(derivative):
        raise ArgumentTypeError(f"derivatives['{argument}'] is {derivative!r}, and not a function of ({', '.join(arguments)})")
    try:
        inspect.signature(derivative).bind(*arguments)
    except TypeError as error:
        raise ArgumentTypeError(f"derivatives['{argument}'] does not take the arguments of the function, "
                                f"({', '.join(arguments)}): {error}") from error


def _check_slope(call: Callable[[List[float], int], Any], at: List[float], place: int, argument: str) -> None:
    try:
        slope = call(at, place)[1]
    except TypeError as error:
        raise ArgumentError(f"the function does not take complex numbers ({error}): compute with numpy's functions in the place of math's, "
                         f"or give derivatives={{'{argument}': ...}}") from error
    width = 1e-5 * abs(at[place])

    def difference(h: float) -> float:
        above, below = list(at), list(at)
        above[place] += h
        below[place] -= h
        return float(call(above, -1)[0] - call(below, -1)[0]) / (2 * h)
    wide, narrow = difference(2 * width), difference(width)
    size = max(abs(slope), abs(narrow), abs(call(at, -1)[0] / at[place]) if at[place] else 0)
    if abs(slope - narrow) > 1e-4 * size + 2 * abs(wide - narrow):
        raise ArgumentError(f"the derivative by '{argument}' is {slope:.6g} at {at[place]:.3g}, and differences give {narrow:.6g}: "
                         "the function is not smooth, or not one of complex numbers")


def with_effects(robot: Robot, *kinds: EffectKind, effects: Sequence[Mapping[str, Any]] = (),
                 uncertain: Sequence[Mapping[str, Any]] = ()) -> Robot:
    """The robot with kinds of effects that diagnose() tries beside the catalogue, with `effects` that act, and with values that
    are `uncertain` and so fitted; items as the robot file has them, plain numbers in its units: {"effect": "drag", "at": "x.rho",
    "a": "15 N"}.

    In memory: write() keeps all but functions, which Robot.read(file, kinds=robot.kinds) takes again."""
    text = robot.text
    for kind in kinds:
        item = f"{kind.name}: {json.dumps(kind._entry)}"
        if kind.formula is not None and item not in text:
            text = _with_item(text, "effect_kinds", item, "")
    for key, items in (("effects", effects), ("uncertain", uncertain)):
        for item in items:
            text = _with_item(text, key, json.dumps(dict(item), default=_plain), "- ")
    functions = [*robot.kinds, *(kind.function for kind in kinds if kind.function is not None)]
    return Robot.parse(text, robot.file, functions)


def _with_item(text: str, key: str, item: str, dash: str) -> str:
    """The text of a YAML file with one item more under a key of its top."""
    lines = text.split("\n")
    at = next((i for i, line in enumerate(lines) if re.match(rf"{key}\s*:", line)), None)
    if at is None:
        return text + ("" if text.endswith("\n") else "\n") + f"{key}:\n  {dash}{item}\n"
    flow = re.fullmatch(rf"({key}\s*:\s*)([\[{{])(.*)([\]}}])(\s*(#.*)?)", lines[at])
    if flow:
        rest = flow[3].strip()
        lines[at] = f"{flow[1]}{flow[2]}{item}{', ' + rest if rest else ''}{flow[4]}{flow[5]}"
        return "\n".join(lines)
    if not re.fullmatch(rf"{key}\s*:\s*(#.*)?", lines[at]):
        raise ArgumentError(f"line {at + 1}: '{key}' is written in a way that nothing can be added to")
    below = next((line for line in lines[at + 1:] if line.strip() and not line.lstrip().startswith("#")), "  ")
    indent = below[:len(below) - len(below.lstrip())] if below[:1] in " -" else "  "
    lines.insert(at + 1, f"{indent}{dash}{item}")
    return "\n".join(lines)
