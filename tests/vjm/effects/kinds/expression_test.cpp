#include "kinetostat/vjm/effects/kinds/expression.h"

#include <muParser.h>

#include <gtest/gtest.h>

#include "support/random.h"

namespace kinetostat::vjm::expression_test {
namespace {

using Eigen::VectorXd;

const std::vector<std::string> names = {"a", "b", "c"};

// As muParser has it, where every function below is finite.
double by_muparser(const std::string& text, VectorXd v) {
  mu::Parser parser;
  for (Eigen::Index i = 0; i < 3; ++i) parser.DefineVar(names[static_cast<std::size_t>(i)], &v[i]);
  parser.SetExpr(text);
  return parser.Eval();
}

class Formula : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(
    All, Formula,
    testing::Values("a + b * c", "-a^2 + (-a)^2 - 2^-b", "a - b - c / a / b", "2^a^b",
                    "sin(a) * cos(b) + tan(c)", "asin(a) + acos(b) - atan(c)",
                    "sinh(a) / cosh(b) + tanh(c * 3)", "asinh(a) + acosh(1 + b) + atanh(c)",
                    "exp(-a/b) * ln(c) + log(a) + log2(b) - log10(c)",
                    "sqrt(a^2 + b^2) * 1.5e-1 + _pi * _e", "a * tanh(b / 1e-1) * (1 + c * 2)",
                    "+a - -b", "a^b * c^(a * b)"));

TEST_P(Formula, IsWhatMuParserSaysAndExactlyDifferentiated) {
  const Expression formula(GetParam(), names);
  test::Random random(3);
  for (int i = 0; i < 100; ++i) {
    VectorXd v(3);
    v << random.uniform(0.1, 0.9), random.uniform(0.1, 0.9), random.uniform(0.1, 0.9);
    const double value = formula.value(v);
    EXPECT_NEAR(value, by_muparser(GetParam(), v), 1e-12 * (1 + std::abs(value)));
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto at = [&](double steps) {
        VectorXd w = v;
        w[k] += steps * 1e-4;
        return by_muparser(GetParam(), w);
      };
      const double numerical = (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / 12e-4;
      const double exact = formula.derivative(v, k).slope;
      EXPECT_NEAR(exact, numerical, 1e-8 * (1 + std::abs(exact)))
          << names[static_cast<std::size_t>(k)];
      if (!formula.uses(k)) {
        EXPECT_EQ(exact, 0);
      }
    }
  }
}

struct Refusal {
  const char* text;
  int column;
  const char* says;
};

class Refused : public testing::TestWithParam<Refusal> {};

INSTANTIATE_TEST_SUITE_P(
    All, Refused,
    testing::Values(Refusal{"a + ", 5, "too early"}, Refusal{"a + q", 5, "neither a variable"},
                    Refusal{"a + sim(b)", 5, "did you mean 'sin'"},
                    Refusal{"a * (b + c", 11, "')' is missing"},
                    Refusal{"a b", 3, "'b' cannot stand here"},
                    Refusal{"a + 1.5.2", 8, "'.' cannot stand here"},
                    Refusal{"sin a", 5, "'(' is missing"}, Refusal{"a = 2", 3, "jump"},
                    Refusal{"a $ b", 3, "'$' cannot stand here"}, Refusal{"a + abs(b)", 5, "abs"},
                    Refusal{"sign(a)", 1, "sign"}, Refusal{"a > 0 ? b : c", 3, "jump"},
                    Refusal{"min(a, b)", 1, "min"}, Refusal{"", 1, "too early"}));

TEST_P(Refused, NamesTheColumn) {
  try {
    const Expression formula(GetParam().text, names);
    FAIL() << GetParam().text;
  } catch (const ExpressionError& error) {
    EXPECT_EQ(error.column, GetParam().column) << error.what();
    EXPECT_NE(std::string(error.what()).find(GetParam().says), std::string::npos) << error.what();
  }
}

TEST(Expression, RefusesAVariableWithTheNameOfAFunction) {
  EXPECT_THROW(Expression("exp + 1", {"exp"}), ExpressionError);
  EXPECT_THROW(Expression("_pi", {"_pi"}), ExpressionError);
}

TEST(Expression, SaysWhereItIsNotFinite) {
  VectorXd zero = VectorXd::Zero(3);
  EXPECT_EQ(Expression("a + b", names).first_not_finite(zero), 0);
  EXPECT_GT(Expression("a + 1 / b", names).first_not_finite(zero), 4);
  EXPECT_GT(Expression("a + sqrt(b)", names).first_not_finite(zero), 4);  // its slope is not
}

TEST(Expression, NestsOnlySoDeep) {
  EXPECT_THROW(Expression(std::string(500, '(') + "a" + std::string(500, ')'), names),
               ExpressionError);
  EXPECT_THROW(Expression(std::string(3000, '-') + "a", names), ExpressionError);
}

}  // namespace
}  // namespace kinetostat::vjm::expression_test
