#include "kinetostat/calibration/campaign/column_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <stdexcept>

#include <fmt/format.h>

namespace kinetostat::calibration {
namespace {

using spatial::Dimension;
namespace dimension = spatial::dimension;

struct Reserved {
  std::string_view name = {};
  Dimension dimension = {};
};

constexpr std::array reserved = {Reserved{"id"},
                                 Reserved{"session"},
                                 Reserved{"cycle"},
                                 Reserved{"step"},
                                 Reserved{"time", dimension::time},
                                 Reserved{"temperature", dimension::temperature},
                                 Reserved{"setting"},
                                 Reserved{"replicate"},
                                 Reserved{"x", dimension::length},
                                 Reserved{"y", dimension::length},
                                 Reserved{"z", dimension::length},
                                 Reserved{"roll", dimension::angle},
                                 Reserved{"pitch", dimension::angle},
                                 Reserved{"yaw", dimension::angle},
                                 Reserved{"fx", dimension::force},
                                 Reserved{"fy", dimension::force},
                                 Reserved{"fz", dimension::force},
                                 Reserved{"mx", dimension::moment},
                                 Reserved{"my", dimension::moment},
                                 Reserved{"mz", dimension::moment},
                                 Reserved{"px", dimension::length},
                                 Reserved{"py", dimension::length},
                                 Reserved{"pz", dimension::length},
                                 Reserved{"direction"},
                                 Reserved{"dx", dimension::length},
                                 Reserved{"dy", dimension::length},
                                 Reserved{"dz", dimension::length},
                                 Reserved{"rx", dimension::angle},
                                 Reserved{"ry", dimension::angle},
                                 Reserved{"rz", dimension::angle},
                                 Reserved{"sigma", dimension::length},
                                 Reserved{"sigma_dx", dimension::length},
                                 Reserved{"sigma_dy", dimension::length},
                                 Reserved{"sigma_dz", dimension::length},
                                 Reserved{"sigma_rx", dimension::angle},
                                 Reserved{"sigma_ry", dimension::angle},
                                 Reserved{"sigma_rz", dimension::angle},
                                 Reserved{"mask"},
                                 Reserved{"mask_reason"},
                                 Reserved{"role"},
                                 Reserved{"instrument"}};

std::string trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return std::string(text);
}

std::optional<spatial::Unit> unit_of(const std::string& text) {
  try {
    return spatial::parse_unit(text);
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

// Without case, blanks, hyphens, dots, underscores and accents; Greek letters by their names.
std::string plain(const std::string& name) {
  std::string result;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const std::string_view rest = std::string_view(name).substr(i);
    if (rest.starts_with("\xce\x94") || rest.starts_with("\xce\xb4")) {
      result += "delta";
      ++i;
    } else if (rest.starts_with("\xce\xb8") || rest.starts_with("\xcf\x86")) {
      result += "theta";
      ++i;
    } else if (rest.starts_with("\xc3\xa9") || rest.starts_with("\xc3\xb3")) {
      result += rest[1] == '\xa9' ? 'e' : 'o';
      ++i;
    } else if (std::string_view(" _-.").find(name[i]) == std::string_view::npos) {
      result += static_cast<char>(std::tolower(static_cast<unsigned char>(name[i])));
    }
  }
  return result;
}

// Words for a quantity along or about an axis, as they stand before or after its letter.
struct Quantity {
  const char* component;  // with the letter of the axis: "f" of "fx"
  Dimension dimension;
  std::string words;  // each between blanks
  bool has(const std::string& word) const {
    return !word.empty() && words.find(' ' + word + ' ') != std::string::npos;
  }
};

const std::vector<Quantity>& quantities() {
  static const std::vector<Quantity> all = {
      {"f", dimension::force, " f force kraft load last pull push effort fuerza forza "},
      {"m", dimension::moment, " m moment torque drehmoment couple momento coppia "},
      {"d", dimension::length,
       " d u delta disp displacement deflection defl deformation translation gauge dial dialgauge "
       "verschiebung verlagerung absenkung auslenkung durchbiegung verformung weg messuhr "
       "deplacement desplazamiento spostamento "},
      {"r", dimension::angle,
       " r rot rotation tilt twist inclination deltar drehung verdrehung neigung verkippung "
       "rotacion rotazione "}};
  return all;
}

// "kraftx" or "xkraft" -> "fx".
std::string component_of(const std::string& name, Dimension& dimension) {
  for (const Quantity& quantity : quantities())
    for (const char axis : {'x', 'y', 'z'})
      if ((name.ends_with(axis) && quantity.has(name.substr(0, name.size() - 1))) ||
          (name.starts_with(axis) && quantity.has(name.substr(1)))) {
        dimension = quantity.dimension;
        return std::string(quantity.component) + axis;
      }
  return {};
}

// "a1", "joint 2", "achse3": the actuated joint of this number in a serial robot.
const Joint* numbered_joint(const std::string& name, const std::vector<Joint>& joints) {
  const std::size_t digits = name.find_first_of("0123456789");
  if (digits == std::string::npos || digits == 0) return nullptr;
  constexpr std::array<std::string_view, 9> words = {"a",     "j",      "q",     "joint", "axis",
                                                     "achse", "gelenk", "theta", "axe"};
  const std::string_view word = std::string_view(name).substr(0, digits);
  if (std::find(words.begin(), words.end(), word) == words.end()) return nullptr;
  std::size_t number = 0;
  const char* const last = name.data() + name.size();
  if (std::from_chars(name.data() + digits, last, number).ptr != last) return nullptr;
  std::vector<const Joint*> actuated;
  std::string chain;
  for (const Joint& joint : joints) {
    if (!joint.actuated) continue;
    const std::string own = joint.name.substr(0, joint.name.find('.'));
    if (!chain.empty() && own != chain) return nullptr;
    chain = own;
    actuated.push_back(&joint);
  }
  return number >= 1 && number <= actuated.size() ? actuated[number - 1] : nullptr;
}

bool is_of(const Dimension& given, const Dimension& wanted) {
  const bool weight = (wanted == dimension::force && given == dimension::mass) ||
                      (wanted == dimension::moment && given == dimension::mass * dimension::length);
  return given == wanted || weight;
}

}  // namespace

const std::string& Joint::column() const { return is_reserved(alone) ? name : alone; }

std::vector<Joint> joints_of(const vjm::Manipulator& manipulator) {
  std::vector<Joint> joints;
  std::map<std::string, int> uses;
  for (const vjm::Chain& chain : manipulator.chains())
    for (const Eigen::Index k : chain.posture_coordinates()) {
      const vjm::Coordinate& joint = chain.coordinates()[static_cast<std::size_t>(k)];
      ++uses[joint.name];
      joints.push_back({chain.name() + "." + joint.name, joint.name,
                        joint.role == vjm::Role::actuated,
                        vjm::is_rotation(joint.motion) ? dimension::angle : dimension::length});
    }
  for (Joint& joint : joints)
    if (uses[joint.alone] > 1) joint.alone = joint.name;
  return joints;
}

std::string correlation_name(Eigen::Index i, Eigen::Index j) {
  return fmt::format("{}_{}", component_names[static_cast<std::size_t>(i)],
                     component_names[static_cast<std::size_t>(j)]);
}

const std::vector<std::string>& reserved_names() {
  static const std::vector<std::string> all = [] {
    std::vector<std::string> result;
    result.reserve(reserved.size() + 15);  // and pairs of six components
    for (const Reserved& one : reserved) result.emplace_back(one.name);
    for (Eigen::Index i = 0; i < 6; ++i)
      for (Eigen::Index j = i + 1; j < 6; ++j) result.push_back("corr_" + correlation_name(i, j));
    return result;
  }();
  return all;
}

bool is_reserved(const std::string& name) {
  const auto& names = reserved_names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

Dimension dimension_of(const std::string& reserved_name) {
  for (const Reserved& one : reserved)
    if (reserved_name == one.name) return one.dimension;
  return dimension::none;
}

std::string bare_name(const std::string& column) {
  std::string bare;
  for (const char c : column.substr(0, column.find_first_of("[(")))
    if (c != ' ') bare += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return bare;
}

HeaderParts split_header(const std::string& header) {
  for (const auto& [open, close] : {std::pair('[', ']'), std::pair('(', ')')}) {
    const std::size_t at = header.rfind(open);
    if (at == std::string::npos || at == 0 || header.back() != close) continue;
    const std::string unit = trimmed(header.substr(at + 1, header.size() - at - 2));
    // A round bracket may hold any remark.
    if (open == '(' && !unit_of(unit)) continue;
    return {trimmed(header.substr(0, at)), unit};
  }
  for (const std::string_view between : {"/", " in ", ","}) {
    const std::size_t at = header.find(between);
    if (at == std::string::npos || at == 0) continue;
    const std::string unit = trimmed(header.substr(at + between.size()));
    if (!unit.empty() && unit_of(unit)) return {trimmed(header.substr(0, at)), unit};
  }
  return {header, std::nullopt};
}

StatedColumn read_stated_column(std::string_view text) {
  StatedColumn stated;
  std::string rest = trimmed(text);
  stated.negative = rest.starts_with('-');
  if (rest.starts_with('-') || rest.starts_with('+')) rest = trimmed(rest.substr(1));
  const HeaderParts parts = split_header(rest);
  stated.meaning = parts.name == "covariate" || parts.name == "ignore" ? "" : parts.name;
  stated.unit = parts.unit;
  return stated;
}

NamedColumn understood(const std::string& header, const std::vector<Joint>& joints) {
  const HeaderParts parts = split_header(header);
  NamedColumn column{.meaning = "", .unit = parts.unit, .as_written = false};
  const std::string bare = bare_name(parts.name);
  for (const std::string& name : reserved_names())
    if (bare == name) column.meaning = name;
  for (const Joint& joint : joints)
    if (bare == bare_name(joint.name) || (bare == bare_name(joint.alone) && column.meaning.empty()))
      column.meaning = joint.name;
  // "X-Axis" of a joint xaxis.
  for (const Joint& joint : joints)
    if (column.meaning.empty() && plain(parts.name) == plain(joint.alone))
      column.meaning = joint.name;
  if (!column.meaning.empty() || !parts.unit) return column;
  const std::optional<spatial::Unit> unit = unit_of(*parts.unit);
  if (!unit) return column;
  const std::string name = plain(parts.name);
  Dimension wanted;
  const std::string component = component_of(name, wanted);
  if (!component.empty() && is_of(unit->dimension, wanted)) column.meaning = component;
  const Joint* const joint = numbered_joint(name, joints);
  if (joint != nullptr && unit->dimension == joint->dimension) column.meaning = joint->name;
  if ((name == "t" || name == "zeit" || name == "timestamp" || name == "elapsed") &&
      unit->dimension == dimension::time)
    column.meaning = "time";
  if ((name == "t" || name == "temp" || name == "temperatur") &&
      unit->dimension == dimension::temperature)
    column.meaning = "temperature";
  return column;
}

const Joint* joint_like(const std::string& header, const std::vector<Joint>& joints) {
  const HeaderParts parts = split_header(header);
  return parts.unit ? nullptr : numbered_joint(plain(parts.name), joints);
}

std::string name_for_column(const std::string& header) {
  std::string name;
  for (const char c : split_header(header).name)
    name += std::string_view("[]()/,; \t").find(c) == std::string_view::npos ? c : '_';
  return name;
}

bool is_mass(const std::string& header) {
  const HeaderParts parts = split_header(header);
  const std::optional<spatial::Unit> unit = parts.unit ? unit_of(*parts.unit) : std::nullopt;
  return unit && unit->dimension == dimension::mass;
}

bool is_force(const std::string& header) {
  const HeaderParts parts = split_header(header);
  const std::optional<spatial::Unit> unit = parts.unit ? unit_of(*parts.unit) : std::nullopt;
  return unit && unit->dimension == dimension::force;
}

std::string looks_like(const std::string& header, const std::vector<Joint>& joints) {
  const HeaderParts parts = split_header(header);
  Dimension wanted;
  if (const std::string component = component_of(plain(parts.name), wanted); !component.empty())
    return parts.unit ? fmt::format("{} [{}]", component, *parts.unit) : component;
  // "rz_deg": a unit after an underscore.
  const std::size_t under = header.rfind('_');
  if (under == std::string::npos || under == 0) return {};
  const std::string unit = header.substr(under + 1);
  if (!unit_of(unit)) return {};
  const NamedColumn named =
      understood(fmt::format("{} [{}]", header.substr(0, under), unit), joints);
  const bool quantity =
      is_reserved(named.meaning) && dimension_of(named.meaning) != dimension::none;
  if (!quantity || !is_of(unit_of(unit)->dimension, dimension_of(named.meaning))) return {};
  return fmt::format("{} [{}]", named.meaning, unit);
}

}  // namespace kinetostat::calibration
