#include "kinetostat/vjm/effects/kinds/expression.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>
#include <string_view>

#include <fmt/format.h>

#include "kinetostat/common/printable.h"
#include "kinetostat/common/spelling.h"

namespace kinetostat::vjm {
namespace {

using Dual = Expression::Dual;

// A function of one argument with its derivative.
struct Function {
  const char* name;
  double (*value)(double);
  double (*slope)(double);
};

constexpr double ln2 = std::numbers::ln2, ln10 = std::numbers::ln10;

const std::array<Function, 18> functions = {{
    {"sin", std::sin, std::cos},
    {"cos", std::cos, [](double x) { return -std::sin(x); }},
    {"tan", std::tan, [](double x) { return 1 + std::tan(x) * std::tan(x); }},
    {"asin", std::asin, [](double x) { return 1 / std::sqrt(1 - x * x); }},
    {"acos", std::acos, [](double x) { return -1 / std::sqrt(1 - x * x); }},
    {"atan", std::atan, [](double x) { return 1 / (1 + x * x); }},
    {"sinh", std::sinh, std::cosh},
    {"cosh", std::cosh, std::sinh},
    {"tanh", std::tanh, [](double x) { return 1 - std::tanh(x) * std::tanh(x); }},
    {"asinh", std::asinh, [](double x) { return 1 / std::sqrt(x * x + 1); }},
    {"acosh", std::acosh, [](double x) { return 1 / std::sqrt(x * x - 1); }},
    {"atanh", std::atanh, [](double x) { return 1 / (1 - x * x); }},
    {"exp", std::exp, std::exp},
    {"ln", std::log, [](double x) { return 1 / x; }},
    {"log", std::log, [](double x) { return 1 / x; }},
    {"log2", std::log2, [](double x) { return 1 / (x * ln2); }},
    {"log10", std::log10, [](double x) { return 1 / (x * ln10); }},
    {"sqrt", std::sqrt, [](double x) { return 0.5 / std::sqrt(x); }},
}};

Dual power(const Dual& base, const Dual& exponent) {
  const double value = std::pow(base.value, exponent.value);
  double slope = 0;
  if (base.slope != 0)
    slope += exponent.value * std::pow(base.value, exponent.value - 1) * base.slope;
  if (exponent.slope != 0) slope += value * std::log(base.value) * exponent.slope;
  return {value, slope};
}

// Functions of other notations, muParser's among them, that have no derivative somewhere.
constexpr std::array with_kinks = {"abs",   "sign",  "sgn",  "min",  "max", "rint",
                                   "round", "floor", "ceil", "fmod", "sum", "avg"};

const Function* function_named(const std::string& name) {
  const auto f = std::find_if(functions.begin(), functions.end(),
                              [&name](const Function& known) { return name == known.name; });
  return f == functions.end() ? nullptr : &*f;
}

std::string unknown_word(const std::string& name, const std::vector<std::string>& variables) {
  if (std::find(with_kinks.begin(), with_kinks.end(), name) != with_kinks.end())
    return fmt::format(
        "'{}' has jumps or kinks, and an equilibrium needs derivatives (write tanh(u/w) for a "
        "sign, sqrt(u^2 + w^2) for a magnitude)",
        name);
  std::vector<std::string> known = variables;
  for (const Function& function : functions) known.emplace_back(function.name);
  const std::string near = common::nearest_spelling(name, known);
  return fmt::format("'{}' is neither a variable nor a function here{}", name,
                     near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near));
}

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '_'; }
bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

}  // namespace

// Recursive descent; precedence, as of muParser: sums, products, signs, powers (from the
// right).
class ExpressionParser {
 public:
  ExpressionParser(const std::string& text, const std::vector<std::string>& variables,
                   std::vector<Expression::Instruction>& program)
      : text_(text), variables_(variables), program_(program) {}

  void parse() {
    sum();
    if (at_ < text_.size()) fail_at_character();
  }

 private:
  using Op = Expression::Op;

  [[noreturn]] void fail(const std::string& what) const {
    throw ExpressionError(what, static_cast<int>(at_) + 1);
  }
  [[noreturn]] void fail_at_character() const {
    const char c = text_[at_];
    const bool jumps = std::string_view("<>=!?:&|").find(c) != std::string_view::npos;
    fail(fmt::format(
        "'{}' cannot stand here{}", common::printable(std::string(1, c)),
        jumps ? ": comparisons and choices jump, and an equilibrium needs derivatives" : ""));
  }
  char next() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool take(char c) {
    if (next() != c) return false;
    ++at_;
    return true;
  }
  void emit(Op op, double number = 0, std::size_t index = 0) {
    program_.push_back({op, number, index, static_cast<int>(at_)});
  }

  void sum() {
    product();
    while (next() == '+' || next() == '-') {
      const bool plus = text_[at_++] == '+';
      product();
      emit(plus ? Op::add : Op::subtract);
    }
  }

  void product() {
    sign();
    while (next() == '*' || next() == '/') {
      const bool times = text_[at_++] == '*';
      sign();
      emit(times ? Op::multiply : Op::divide);
    }
  }

  void sign() {
    if (++depth_ > 100) fail("the formula is nested too deeply");
    if (take('-')) {
      sign();
      emit(Op::negate);
    } else if (take('+')) {
      sign();
    } else {
      atom();
      if (take('^')) {
        sign();
        emit(Op::power);
      }
    }
    --depth_;
  }

  void atom() {
    const char c = next();
    if (take('(')) {
      sum();
      if (!take(')')) fail("a ')' is missing");
    } else if (is_digit(c) || c == '.') {
      number();
    } else if (is_letter(c)) {
      word();
    } else if (at_ == text_.size()) {
      fail("the formula ends too early");
    } else {
      fail_at_character();
    }
  }

  void number() {
    double value = 0;
    const char* begin = text_.data() + at_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
    if (error != std::errc()) fail("this is no number");
    at_ += static_cast<std::size_t>(end - begin);
    emit(Op::number, value);
  }

  void word() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    const std::string name = text_.substr(begin, at_ - begin);
    if (const auto v = std::find(variables_.begin(), variables_.end(), name);
        v != variables_.end()) {
      emit(Op::variable, 0, static_cast<std::size_t>(v - variables_.begin()));
    } else if (name == "_pi") {
      emit(Op::number, std::numbers::pi);
    } else if (name == "_e") {
      emit(Op::number, std::numbers::e);
    } else {
      const Function* f = function_named(name);
      if (f == nullptr) {
        at_ = begin;
        fail(unknown_word(name, variables_));
      }
      if (!take('(')) fail("a '(' is missing");
      sum();
      if (!take(')')) fail("a ')' is missing");
      emit(Op::function, 0, static_cast<std::size_t>(f - functions.data()));
    }
  }

  const std::string& text_;
  const std::vector<std::string>& variables_;
  std::vector<Expression::Instruction>& program_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

Expression::Expression(const std::string& text, const std::vector<std::string>& variables)
    : text_(text) {
  if (text.size() > 2000) throw ExpressionError("a formula may have 2000 characters", 2001);
  for (const std::string& name : variables)
    if (function_named(name) != nullptr || name == "_pi" || name == "_e")
      throw ExpressionError(
          fmt::format("'{}' means something else in formulas: no variable may be named so", name),
          1);
  ExpressionParser(text, variables, program_).parse();
}

bool Expression::uses(Eigen::Index variable) const {
  return std::any_of(program_.begin(), program_.end(), [variable](const Instruction& i) {
    return i.op == Op::variable && static_cast<Eigen::Index>(i.index) == variable;
  });
}

double Expression::value(const Eigen::VectorXd& variables) const {
  return derivative(variables, -1).value;
}

// Takes its operands from the stack and leaves its value there.
Dual Expression::apply(const Instruction& i, std::vector<Dual>& stack,
                       const Eigen::VectorXd& variables, Eigen::Index variable) {
  if (i.op == Op::number) return stack.emplace_back(Dual{i.number, 0});
  if (i.op == Op::variable) {
    const auto index = static_cast<Eigen::Index>(i.index);
    return stack.emplace_back(Dual{variables[index], index == variable ? 1.0 : 0.0});
  }
  const Dual b = stack.back();
  if (i.op == Op::negate) return stack.back() = {-b.value, -b.slope};
  if (i.op == Op::function) {
    const Function& f = functions[i.index];
    return stack.back() = {f.value(b.value), b.slope == 0 ? 0 : f.slope(b.value) * b.slope};
  }
  stack.pop_back();
  Dual& a = stack.back();
  if (i.op == Op::add) a = {a.value + b.value, a.slope + b.slope};
  if (i.op == Op::subtract) a = {a.value - b.value, a.slope - b.slope};
  if (i.op == Op::multiply) a = {a.value * b.value, a.slope * b.value + a.value * b.slope};
  if (i.op == Op::divide)
    a = {a.value / b.value, (a.slope - a.value / b.value * b.slope) / b.value};
  if (i.op == Op::power) a = power(a, b);
  return a;
}

Dual Expression::derivative(const Eigen::VectorXd& variables, Eigen::Index variable) const {
  std::vector<Dual> stack;
  stack.reserve(program_.size());
  for (const Instruction& i : program_) apply(i, stack, variables, variable);
  return stack.back();
}

int Expression::first_not_finite(const Eigen::VectorXd& variables) const {
  for (Eigen::Index v = -1; v < variables.size(); ++v) {
    std::vector<Dual> stack;
    for (const Instruction& i : program_) {
      const Dual value = apply(i, stack, variables, v);
      if (!std::isfinite(value.value) || !std::isfinite(value.slope)) return std::max(1, i.column);
    }
  }
  return 0;
}

}  // namespace kinetostat::vjm
