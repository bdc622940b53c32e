// Cases of the suite: a robot, what is hidden in it, and how large.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "confuser.h"
#include "experiment.h"

namespace twin {

/// A hidden effect, and how detectable it is to be alone.
struct Target {
  HiddenEffect effect;
  double d_prime = 0;
};

struct Case {
  std::string name;  // identifies the case in the list of cases
  std::string kind;  // class of the suite: clean, off_base, noisy, single, pair, outside, blind
  std::string robot, plan;
  std::vector<Target> targets = {};
  std::uint64_t seed = 1;
  int round = 1;
  bool held_back = false;  // run once, when everything else is done
};

inline constexpr int rounds = 4;

/// The whole suite, round by round: each is a fair sample of the others, but that Orthoglides are
/// in the first one only, and the largest effects (d' 50) and many more without any in the last.
std::vector<Case> suite();

/// Cases of the trial robots, measured as people do and with laws of other forms. Half of them, of
/// every robot and kind of effect, are held back.
std::vector<Case> trial_suite();

/// The shipped campaigns of `kinetostat demo` that are simulated.
std::vector<Case> stories();

/// Writes robot.yaml, campaign.yaml and readings.csv into `folder`, and what is hidden to `truth`,
/// which the product never sees. Throws std::runtime_error.
void write_case(const Case& spec, const std::filesystem::path& folder,
                const std::filesystem::path& truth);

/// What the product asked to measure next in a case, measured: `table` is what `kinetostat plan -o`
/// wrote after the campaign in `from`.
struct FollowUp {
  std::filesystem::path from, table;
  int number = 1;            // of the plans in this case
  bool absolute = false;     // it asks for poses
  bool known_loads = false;  // it asks for known weights
};

/// Writes the campaign with the new readings into `folder`, or the one that they are by themselves.
/// `sizes`: of the hidden effects, as in the truth. Throws std::runtime_error.
void write_follow_up(const Case& spec, const std::vector<double>& sizes, const FollowUp& next,
                     const std::filesystem::path& folder);

/// Nearest confounder of the first effect that is hidden in a case, which has that size there; or
/// the first whose cosine is above `enough`. Throws std::invalid_argument where nothing is hidden.
Confuser confuser_in(const Case& spec, double size, double enough = 1);

/// A campaign without noise on a robot whose file says the truth: the product must agree with it.
void write_agreement(const std::string& robot, const std::string& plan, int elements,
                     const std::filesystem::path& folder);

}  // namespace twin
