#include "robot.h"

#include <numbers>
#include <stdexcept>

#include <Eigen/QR>
#include <fmt/format.h>

namespace twin {
namespace {

// Of what counts as rigid [N/m], [N m/rad]: far above every spring, far below what rounding
// forbids.
constexpr double stiff_translation = 1e12, stiff_rotation = 1e11;

Pose joint_motion(int axis, double value) {
  Vector3 v = Vector3::Zero();
  v[axis % 3] = value;
  return axis < 3 ? Pose{v, Matrix3::Identity()} : Pose{Vector3::Zero(), rotation_of(v)};
}

Pose along(const ChainSpec& chain, const Eigen::VectorXd& q) {
  Pose at = chain.base;
  Eigen::Index k = 0;
  for (const Item& item : chain.items) {
    for (const int axis : item.axes) at = at * joint_motion(axis, q[k++]);
    if (item.kind == Item::link) at.x += at.R * item.beam.direction.normalized() * item.beam.length;
    at.x += at.R * item.reach;
  }
  return at;
}

Eigen::VectorXd home_of(const ChainSpec& chain) {
  std::vector<double> q;
  for (const Item& item : chain.items)
    for (std::size_t k = 0; k < item.axes.size(); ++k) q.push_back(item.home);
  return Eigen::Map<Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size()));
}

Vector6 difference(const Pose& a, const Pose& b) {
  Vector6 d;
  d << b.x - a.x, vector_of(b.R * a.R.transpose());
  return d;
}

Eigen::VectorXd coordinates_at(const ChainSpec& chain, const Pose& end) {
  Eigen::VectorXd q = home_of(chain);
  for (int i = 0; i < 100; ++i) {
    const Pose now = along(chain, q);
    const Vector6 miss = difference(now, end);
    if (miss.norm() < 1e-13) return q;
    Eigen::MatrixXd jacobian(6, q.size());
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      Eigen::VectorXd further = q;
      further[k] += 1e-6;
      jacobian.col(k) = difference(now, along(chain, further)) / 1e-6;
    }
    q += jacobian.colPivHouseholderQr().solve(miss);
  }
  if (difference(along(chain, q), end).norm() < 1e-11) return q;
  throw std::runtime_error(fmt::format("chain {} does not reach ({}, {}, {})", chain.name,
                                       end.x.x(), end.x.y(), end.x.z()));
}

Matrix6 rigid(const BuildOptions& options) {
  Vector6 k;
  k << Vector3::Constant(stiff_translation), Vector3::Constant(stiff_rotation);
  return options.rigid * k.asDiagonal().toDenseMatrix();
}

// One element of length h: bending by one point of integration becomes exact for a linear beam when
// the shear spring has the rest of the bending compliance, h^3/(12 E I) (MacNeal, Finite Elements:
// Their Design and Performance, 1994, ch. 5).
Matrix6 element_stiffness(const Beam& b, double h) {
  Vector6 k;
  k << b.E * b.area / h, 12 * b.E * b.Iz / (h * h * h), 12 * b.E * b.Iy / (h * h * h),
      b.G * b.J / h, b.E * b.Iy / h, b.E * b.Iz / h;
  return k.asDiagonal();
}

// Builds one chain, element by element.
class ChainBuilder {
 public:
  ChainBuilder(const RobotSpec& robot, const ChainSpec& chain, const BuildOptions& options,
               Built& built)
      : robot_(robot), chain_(chain), options_(options), built_(built), at_(chain.base) {}

  void run(const Eigen::VectorXd& q, int platform) {
    built_.mounts.push_back(connect(rigid(options_)));
    Eigen::Index k = 0;
    for (const Item& item : chain_.items) {
      if (item.kind == Item::link) add_link(item);
      for (const int axis : item.axes) add_joint(item, axis, q[k++]);
      at_.x += at_.R * item.reach;
    }
    Coupling end{.a = built_.structure.mark(body_, at_), .b = built_.structure.mark(platform, at_)};
    end.stiffness = rigid(options_);
    built_.ends.push_back(built_.structure.add(end));
  }

 private:
  // A further body here, held to the one before.
  int connect(const Matrix6& stiffness) {
    Structure& s = built_.structure;
    const int next = s.add_body(at_);
    Coupling coupling{.a = s.mark(body_, at_), .b = s.mark(next, at_)};
    coupling.stiffness = stiffness;
    body_ = next;
    return s.add(coupling);
  }

  // -1: its stiffness is known.
  int group_of(const Item& item) const {
    if (!robot_.scatters(item)) return -1;
    const std::vector<std::string> springs = robot_.springs();
    const auto found = std::find(springs.begin(), springs.end(), robot_.place(chain_, item));
    return static_cast<int>(found - springs.begin());
  }
  double factor(int group) const {
    if (group < 0 || options_.factors.empty()) return 1;
    return options_.factors[static_cast<std::size_t>(group)];
  }

  void add_joint(const Item& item, int axis, double q) {
    at_ = at_ * joint_motion(axis, q);
    Matrix6 stiffness = rigid(options_);
    stiffness(axis, axis) = 0;
    const int number = connect(stiffness);
    if (item.kind != Item::actuator) return;
    Coupling& coupling = built_.structure.coupling(number);
    coupling.axis = axis;
    coupling.group = group_of(item);
    coupling.law = linear_law(item.stiffness * factor(coupling.group));
    built_.joints[robot_.place(chain_, item)] = number;
  }

  void add_link(const Item& item) {
    const std::string place = robot_.place(chain_, item);
    const double h = item.beam.length / options_.elements;
    const Matrix3 axes = at_.R * item.beam.axes();
    const int group = group_of(item);
    Structure& s = built_.structure;
    built_.link_starts[place] = s.mark(body_, at_);
    const double half = item.beam.mass() / options_.elements / 2;
    built_.beams_bodies[place].push_back(body_);
    for (int i = 0; i < options_.elements; ++i) {
      const Pose start{at_.x, axes};
      at_.x += axes.col(0) * h;
      const int next = s.add_body(at_);
      if (body_ != ground) s.add_mass(body_, half);
      s.add_mass(next, half);
      Coupling coupling{.a = s.mark(body_, start), .b = s.mark(next, {at_.x, axes})};
      coupling.rest[0] = h;
      coupling.stiffness = factor(group) * element_stiffness(item.beam, h);
      coupling.group = group;
      built_.links[place].push_back(s.add(coupling));
      built_.beams_bodies[place].push_back(next);
      body_ = next;
    }
  }

  const RobotSpec& robot_;
  const ChainSpec& chain_;
  const BuildOptions& options_;
  Built& built_;
  Pose at_;
  int body_ = ground;
};

}  // namespace

Matrix3 Beam::axes() const {
  const Vector3 x = direction.normalized();
  const Vector3 near = std::abs(x.z()) < 0.999 ? Vector3::UnitZ() : Vector3::UnitX();
  const Vector3 y = near.cross(x).normalized();
  return (Matrix3() << x, y, x.cross(y)).finished();
}

std::string RobotSpec::place(const ChainSpec& chain, const Item& item) const {
  return serial ? item.name : chain.name + "." + item.name;
}

std::vector<std::string> RobotSpec::springs() const {
  std::vector<std::string> names;
  for (const ChainSpec& chain : chains)
    for (const Item& item : chain.items)
      if (scatters(item)) names.push_back(place(chain, item));
  return names;
}

int RobotSpec::coordinates(const ChainSpec& chain) {
  int n = 0;
  for (const Item& item : chain.items) n += static_cast<int>(item.axes.size());
  return n;
}

Posture posture_of(const RobotSpec& robot, const Eigen::VectorXd& q) {
  return {{q}, along(robot.chains.at(0), q)};
}

Posture posture_at(const RobotSpec& robot, const Vector3& point) {
  Posture posture{{}, {point, Matrix3::Identity()}};
  for (const ChainSpec& chain : robot.chains)
    posture.q.push_back(coordinates_at(chain, posture.platform * chain.on_platform));
  return posture;
}

Built build(const RobotSpec& robot, const Posture& posture, const BuildOptions& options) {
  Built built;
  built.structure.gravity({0, 0, -9.80665});
  const int platform = built.structure.add_body(posture.platform);
  built.platform = built.structure.mark(platform, posture.platform);
  for (std::size_t c = 0; c < robot.chains.size(); ++c)
    ChainBuilder(robot, robot.chains[c], options, built).run(posture.q[c], platform);
  return built;
}

namespace {

Item actuator(std::string name, int axis, double stiffness, double home) {
  return {.kind = Item::actuator,
          .name = std::move(name),
          .axes = {axis},
          .stiffness = stiffness,
          .home = home};
}
Item passive(std::string name, std::vector<int> axes) {
  return {.kind = Item::passive, .name = std::move(name), .axes = std::move(axes)};
}
Item link(std::string name, const Beam& beam) {
  return {.kind = Item::link, .name = std::move(name), .beam = beam};
}
Item reach(const Vector3& by) { return {.kind = Item::offset, .name = "", .reach = by}; }

// A tube, by its formulas.
Beam tube(double length, double outer, double inner, const Vector3& direction, double E, double G,
          double density) {
  const double I = std::numbers::pi / 64 * (std::pow(outer, 4) - std::pow(inner, 4));
  return {.length = length,
          .area = std::numbers::pi / 4 * (outer * outer - inner * inner),
          .Iy = I,
          .Iz = I,
          .J = 2 * I,
          .E = E,
          .G = G,
          .density = density,
          .direction = direction};
}
Beam steel_tube(double length, double outer, double inner, const Vector3& direction) {
  return tube(length, outer, inner, direction, 210e9, 80e9, 7850);
}
Beam aluminium_tube(double length, double outer, double inner, const Vector3& direction) {
  return tube(length, outer, inner, direction, 70e9, 26e9, 2700);
}

Matrix3 columns(const Vector3& x, const Vector3& y) {
  return (Matrix3() << x, y, x.cross(y)).finished();
}

}  // namespace

RobotSpec bench() {
  return {"joint on a bench",
          {{"chain",
            {},
            {},
            {actuator("q1", 4, 2.0e4, 0),
             link("lever", steel_tube(0.5, 0.05, 0.036, Vector3::UnitX()))}}},
          true,
          60};
}

RobotSpec frame() {
  return {"plate on a tube",
          {{"chain",
            {},
            {},
            {actuator("bolts", 3, 8.0e4, 0),
             link("tube", steel_tube(0.9, 0.12, 0.10, Vector3::UnitX()))}}},
          true,
          600};
}

RobotSpec arm_3r() {
  return {
      "three-joint arm",
      {{"chain",
        {},
        {},
        {actuator("q1", 5, 6.0e4, 0),
         link("column", aluminium_tube(0.35, 0.12, 0.10, Vector3::UnitZ())),
         actuator("q2", 4, 5.0e4, -40 * degree),
         link("upper", aluminium_tube(0.5, 0.08, 0.068, Vector3::UnitX())),
         actuator("q3", 4, 2.5e4, 70 * degree),
         link("fore", aluminium_tube(0.42, 0.06, 0.050, Vector3::UnitX())), reach({0.05, 0, 0})}}},
      true,
      35};
}

RobotSpec arm_6r() {
  return {
      "six-axis arm with a balancer",
      {{"chain",
        {},
        {},
        {actuator("q1", 5, 3.0e6, 0), reach({0.35, 0, 0.675}),
         actuator("q2", 4, 2.2e6, -20 * degree),
         link("upper", steel_tube(1.15, 0.22, 0.20, Vector3::UnitZ())),
         actuator("q3", 4, 1.6e6, 30 * degree), reach({0.25, 0, -0.041}),
         actuator("q4", 3, 3.3e5, 0), link("fore", steel_tube(0.95, 0.16, 0.145, Vector3::UnitX())),
         actuator("q5", 4, 2.6e5, 40 * degree), actuator("q6", 3, 2.4e5, 0),
         reach({0.24, 0, -0.12})}}},
      true,
      500};
}

RobotSpec orthoglide() {
  // Lengths, stiffness and effective sections of the published 3-PUU Orthoglide (see
  // data/robots/orthoglide.yaml), the density ours.
  const Beam foot{.length = 0.1549,
                  .area = 29.4e-3 * 16.4e-3,
                  .Iy = 29.4e-3 * std::pow(16.4e-3, 3) / 12,
                  .Iz = 16.4e-3 * std::pow(29.4e-3, 3) / 12,
                  .J = 2.8e-8,
                  .E = 70e9,
                  .G = 25.5e9,
                  .density = 2700,
                  .direction = {1, 1, 0}};
  const Beam leg{.length = 0.310,
                 .area = 288e-6,
                 .Iy = 3300e-12,
                 .Iz = 3300e-12,
                 .J = 6600e-12,
                 .E = 70e9,
                 .G = 25.5e9,
                 .density = 2700};
  const double b = 0.1549 / std::numbers::sqrt2;
  const std::vector<Item> puu{actuator("rho", 0, 1.0e8, -0.310 - 0.030 - b),
                              link("foot", foot),
                              passive("u1", {5, 4}),
                              link("leg", leg),
                              passive("u2", {4, 5}),
                              reach({0.03, 0, 0})};
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ();
  RobotSpec robot{"Orthoglide", {}, false, 250};
  const auto add = [&](const char* name, const Vector3& point, const Matrix3& axes) {
    robot.chains.push_back({name, {point, axes}, {Vector3::Zero(), axes}, puu});
  };
  add("x", -b * y, columns(x, y));
  add("y", -b * z, columns(y, z));
  add("z", -b * x, columns(z, x));
  return robot;
}

RobotSpec scara() {
  return {"four-axis SCARA",
          {{"chain",
            {},
            {},
            {reach({0, 0, 0.4}), actuator("q1", 5, 4.0e4, 20 * degree),
             link("upper", aluminium_tube(0.35, 0.11, 0.095, Vector3::UnitX())),
             actuator("q2", 5, 2.2e4, -50 * degree),
             link("fore", aluminium_tube(0.3, 0.09, 0.078, Vector3::UnitX())),
             actuator("slide", 2, 6.0e6, -0.15), reach({0.04, 0, -0.1})}}},
          true,
          60};
}

RobotSpec arm_7r() {
  return {"seven-axis arm",
          {{"chain",
            {},
            {},
            {reach({0, 0, 0.15}), actuator("a1", 5, 2.0e4, 0), reach({0, 0, 0.19}),
             actuator("a2", 4, 2.0e4, 30 * degree),
             link("upper", aluminium_tube(0.4, 0.13, 0.12, Vector3::UnitZ())),
             actuator("a3", 5, 1.5e4, 15 * degree), actuator("a4", 4, 1.5e4, 75 * degree),
             link("fore", aluminium_tube(0.39, 0.11, 0.1, Vector3::UnitZ())),
             actuator("a5", 5, 9.0e3, 0), actuator("a6", 4, 8.0e3, 55 * degree),
             reach({0.03, 0, 0.08}), actuator("a7", 5, 7.0e3, 0), reach({0, 0.02, 0.08})}}},
          true,
          40};
}

RobotSpec gantry() {
  return {"gantry",
          {{"chain",
            {},
            {},
            {actuator("gx", 0, 4.0e7, 0.4),
             link("bridge", steel_tube(0.9, 0.16, 0.145, Vector3::UnitY())),
             actuator("gy", 1, 3.0e7, -0.3), reach({0.08, 0, 0}), actuator("gz", 2, 2.5e7, 0.1),
             link("ram", steel_tube(0.5, 0.1, 0.085, -Vector3::UnitZ())), reach({0, 0, -0.05})}}},
          true,
          600};
}

namespace {

Pose turned_about_z(double angle) { return {Vector3::Zero(), rotation_of(Vector3(0, 0, angle))}; }

Item passive_at(std::string name, int axis, double home) {
  Item item = passive(std::move(name), {axis});
  item.home = home;
  return item;
}

}  // namespace

RobotSpec planar_3rrr() {
  RobotSpec robot{"planar 3-RRR", {}, false, 80};
  robot.reach = {0.05, 0.05, 0};
  robot.planar = robot.links_known = true;
  const char* names[] = {"a", "b", "c"};
  for (int i = 0; i < 3; ++i) {
    const Pose turn = turned_about_z(i * 120 * degree);
    // From 0.32 m out, a dog leg to 0.07 m from the middle.
    ChainSpec chain{names[i],
                    turn * Pose{{0.32, 0, 0}, Matrix3::Identity()},
                    turn * Pose{{0.07, 0, 0}, Matrix3::Identity()},
                    {}};
    chain.items = {actuator("q", 5, 1.5e4, 128 * degree),
                   link("crank", aluminium_tube(0.2, 0.05, 0.042, Vector3::UnitX())),
                   passive_at("u", 5, 103 * degree),
                   link("rod", aluminium_tube(0.2, 0.04, 0.034, Vector3::UnitX())),
                   passive_at("v", 5, -231 * degree)};
    robot.chains.push_back(chain);
  }
  return robot;
}

RobotSpec hexapod() {
  RobotSpec robot{"hexapod", {}, false, 900};
  robot.links_known = true;
  robot.centre = {0, 0, 0.6};
  robot.reach = {0.08, 0.08, 0.06};
  const char* names[] = {"a", "b", "c", "d", "e", "f"};
  for (int i = 0; i < 6; ++i) {
    const double side = i % 2 == 0 ? 1 : -1, third = (i / 2) * 120 * degree;
    const Vector3 foot = turned_about_z(third + side * 15 * degree) * Vector3(0.4, 0, 0);
    const Vector3 head = turned_about_z(third + side * 42 * degree) * Vector3(0.18, 0, 0);
    const double length = (head + robot.centre - foot).norm();
    // z of the foot points along the leg at home.
    const Vector3 z = (head + robot.centre - foot) / length;
    const Vector3 x = Vector3::UnitY().cross(z).normalized();
    const Matrix3 axes = columns(x, z.cross(x));
    ChainSpec chain{names[i], {foot, axes}, {head, axes}, {}};
    chain.items = {passive("u", {3, 4}), actuator("rho", 2, 3.0e7, length - 0.3),
                   link("strut", steel_tube(0.3, 0.03, 0.02, Vector3::UnitZ())),
                   passive("s", {3, 4, 5})};
    robot.chains.push_back(chain);
  }
  return robot;
}

RobotSpec delta() {
  RobotSpec robot{"delta", {}, false, 60};
  robot.centre = {0, 0, -0.52};
  robot.reach = {0.12, 0.12, 0.06};
  const char* names[] = {"a", "b", "c"};
  for (int i = 0; i < 3; ++i) {
    const Pose turn = turned_about_z(i * 120 * degree);
    ChainSpec chain{names[i],
                    turn * Pose{{0.18, 0, 0}, Matrix3::Identity()},
                    turn * Pose{{0.05, 0, 0}, Matrix3::Identity()},
                    {}};
    // The rod turns in the plane of the arm, then out of it, and back again.
    chain.items = {actuator("q", 4, 1.2e4, 10 * degree),
                   link("arm", aluminium_tube(0.25, 0.045, 0.037, Vector3::UnitX())),
                   passive_at("u", 4, 120 * degree),
                   passive("v", {5}),
                   link("rod", steel_tube(0.6, 0.016, 0.012, Vector3::UnitX())),
                   passive("w", {5}),
                   passive_at("t", 4, -130 * degree)};
    robot.chains.push_back(chain);
  }
  return robot;
}

namespace {

std::string numbers(const Vector3& v, double unit) {
  return fmt::format("[{:.10g}, {:.10g}, {:.10g}]", v.x() / unit, v.y() / unit, v.z() / unit);
}

constexpr const char* axis_names[] = {"Tx", "Ty", "Tz", "Rx", "Ry", "Rz"};

std::string item_lines(const Item& item, const std::string& link_name, double factor) {
  const bool turns = !item.axes.empty() && item.axes[0] >= 3;
  switch (item.kind) {
    case Item::actuator:
      return fmt::format(
          "    - actuator: {{name: {}, axis: {}, stiffness: {:.10g} {}, home: {:.10g}}}\n",
          item.name, axis_names[item.axes[0]], item.stiffness * factor, turns ? "N m/rad" : "N/m",
          turns ? item.home / degree : item.home * 1e3);
    case Item::passive: {
      std::string axes, home;
      for (const int axis : item.axes)
        axes += (axes.empty() ? "" : ", ") + std::string(axis_names[axis]);
      if (item.home != 0) home = fmt::format(", home: [{:.10g}]", item.home / degree);
      return fmt::format("    - passive: {{name: {}, axes: [{}]{}}}\n", item.name, axes, home);
    }
    case Item::link:
      return fmt::format("    - link: {}\n", link_name);
    case Item::offset:
      return fmt::format("    - offset: {}\n", numbers(item.reach, 1e-3));
  }
  return {};
}

std::string beam_lines(const std::string& name, const Beam& b, double factor) {
  return fmt::format(
      "  {}:\n    beam:\n      length: {:.10g}\n      direction: {}\n      section: {{general: "
      "{{A: {:.10g}, "
      "Iy: {:.10g}, Iz: {:.10g}, J: {:.10g}}}}}\n      material: {{E: {:.10g} GPa, G: {:.10g} GPa, "
      "density: {:.10g} kg/m^3}}\n      theory: euler-bernoulli\n",
      name, b.length * 1e3, numbers(b.direction, 1), b.area * 1e6, b.Iy * 1e12, b.Iz * 1e12,
      b.J * 1e12, factor * b.E / 1e9, factor * b.G / 1e9, b.density);
}

}  // namespace

namespace {

std::string frame_text(const Pose& pose) {
  return fmt::format("{{point: {}, x: {}, y: {}}}", numbers(pose.x, 1e-3),
                     numbers(pose.R.col(0), 1), numbers(pose.R.col(1), 1));
}

// The platform's reference point, in the axes of the chain's base, needs no words.
std::string platform_text(const ChainSpec& chain) {
  if (chain.on_platform.x.isZero() && chain.on_platform.R.isApprox(chain.base.R)) return {};
  return ", platform: " + frame_text(chain.on_platform);
}

}  // namespace

std::string robot_file(const RobotSpec& robot, const std::vector<double>& believed) {
  std::string links, types, chains, uncertain;
  std::size_t spring = 0;
  for (const ChainSpec& chain : robot.chains) {
    types += fmt::format("  {}:\n", robot.serial ? "arm" : "puu_" + chain.name);
    for (const Item& item : chain.items) {
      const bool scatters = robot.scatters(item);
      const double factor = scatters && !believed.empty() ? believed[spring] : 1;
      const std::string link_name = robot.serial ? item.name : item.name + "_" + chain.name;
      types += item_lines(item, link_name, factor);
      if (item.kind == Item::link) links += beam_lines(link_name, item.beam, factor);
      if (!scatters) continue;
      uncertain += fmt::format("  - {{stiffness: {}, between: [0.3, 3]}}\n",
                               item.kind == Item::link ? link_name : robot.place(chain, item));
      ++spring;
    }
    if (!robot.serial)
      chains += fmt::format("    - {{name: {}, type: puu_{}, base: {}{}}}\n", chain.name,
                            chain.name, frame_text(chain.base), platform_text(chain));
  }
  return fmt::format(
      "kinetostat: 1\nname: {}\nunits: {{length: mm, force: N, angle: deg, mass: kg, temperature: "
      "K}}\n"
      "gravity: {{direction: [0, 0, "
      "-1]}}\nlinks:\n{}chain_types:\n{}manipulator:{}\nuncertain:\n{}",
      robot.name, links, types, robot.serial ? " {chain: arm}" : "\n  chains:\n" + chains,
      uncertain);
}

RobotSpec robot_named(const std::string& name) {
  if (name == "bench") return bench();
  if (name == "arm_3r") return arm_3r();
  if (name == "arm_6r") return arm_6r();
  if (name == "orthoglide") return orthoglide();
  if (name == "scara") return scara();
  if (name == "arm_7r") return arm_7r();
  if (name == "gantry") return gantry();
  if (name == "planar_3rrr") return planar_3rrr();
  if (name == "hexapod") return hexapod();
  if (name == "delta") return delta();
  throw std::invalid_argument("no robot " + name);
}

}  // namespace twin
