// A formula that a user writes, with its exact derivatives.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace kinetostat::vjm {

/// Error in a formula, and its place: the column counts from 1.
struct ExpressionError : std::runtime_error {
  ExpressionError(const std::string& what, int at) : std::runtime_error(what), column(at) {}
  int column;
};

/// A smooth function of some variables, with exact derivatives. Several threads may evaluate it at
/// once.
class SmoothFunction {
 public:
  /// A value with its derivative in one direction.
  struct Dual {
    double value = 0, slope = 0;
  };

  virtual ~SmoothFunction() = default;
  virtual bool uses(Eigen::Index variable) const = 0;
  virtual double value(const Eigen::VectorXd& variables) const = 0;
  /// Value and derivative with respect to one variable.
  virtual Dual derivative(const Eigen::VectorXd& variables, Eigen::Index variable) const = 0;
};

/// A smooth function of named variables, in muParser's notation: + - * / ^, parentheses,
/// numbers, _pi, _e, and sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp ln log
/// log2 log10 sqrt. Functions that jump or have a kink (abs, sign, min, max, comparisons, a ? b :
/// c) are refused: equilibrium needs derivatives. Immutable. Derivatives are those of dual numbers.
class Expression : public SmoothFunction {
 public:
  /// Throws ExpressionError when the text does not parse or names something else, and when a
  /// variable has the name of a function.
  Expression(const std::string& text, const std::vector<std::string>& variables);

  const std::string& text() const { return text_; }
  bool uses(Eigen::Index variable) const override;
  double value(const Eigen::VectorXd& variables) const override;
  Dual derivative(const Eigen::VectorXd& variables, Eigen::Index variable) const override;
  /// Column of the first operation whose value, or derivative with respect to a variable in use, is
  /// not finite there; 0: none.
  int first_not_finite(const Eigen::VectorXd& variables) const;

 private:
  friend class ExpressionParser;
  enum class Op { number, variable, add, subtract, multiply, divide, power, negate, function };
  struct Instruction {
    Op op = Op::number;
    double number = 0;
    std::size_t index = 0;  // of the variable, or of the function
    int column = 0;         // in the text
  };
  static Dual apply(const Instruction& instruction, std::vector<Dual>& stack,
                    const Eigen::VectorXd& variables, Eigen::Index variable);

  std::string text_;
  std::vector<Instruction> program_;  // in postfix order
};

}  // namespace kinetostat::vjm
