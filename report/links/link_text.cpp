// An identified link for people.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/report/links/accuracy.h"
#include "kinetostat/report/links/link_result.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using fea::LinkResult;
using spatial::Vector3;

// Components that are rounding beside the largest, or below a nanometre, are shown as 0.
std::string coordinates(const Vector3& v, double unit) {
  const double noise = std::max(1e-9 * v.cwiseAbs().maxCoeff(), 1e-12);
  const auto shown = [&](double x) { return number(std::abs(x) < noise ? 0 : x / unit); };
  return fmt::format("[{}, {}, {}]", shown(v.x()), shown(v.y()), shown(v.z()));
}

std::string mesh_line(const LinkResult& result) {
  const std::string size =
      result.element_size > 0
          ? fmt::format(" (size {} {})",
                        number(result.element_size / spatial::parse_unit(result.unit).factor),
                        result.unit)
          : "";
  return fmt::format("mesh: {} tetrahedra of {} nodes{}, {} nodes, {} unknowns\n",
                     result.mesh.element_count(), result.mesh.nodes_per_element(), size,
                     result.mesh.nodes.size(), result.response.solver.unknowns);
}

std::string solver_line(const fea::SolverStats& solver) {
  std::vector<std::string> costs;
  const auto add_forecast = [&costs](fea::SolverMethod method, const fea::SolverForecast& cost) {
    if (cost.bytes > 0)
      costs.push_back(fmt::format("{} about {:.2g} GB and {:.2g} s", name(method), cost.bytes / 1e9,
                                  cost.seconds));
  };
  add_forecast(fea::SolverMethod::multigrid, solver.multigrid);
  add_forecast(fea::SolverMethod::petsc, solver.petsc);
  add_forecast(fea::SolverMethod::direct, solver.direct);
  std::string line = fmt::format("solver: {} ({}), {} unknowns, {} iterations", name(solver.method),
                                 solver.reason, fmt::join(solver.levels, " > "), solver.iterations);
  if (solver.residual > 0) line += fmt::format(", energy of the residual {:.1e}", solver.residual);
  return fmt::format("{}; forecast: {}\n", line, fmt::join(costs, ", "));
}

std::string interface_line(const fea::CoupledInterface& coupled, const std::string& unit) {
  const double length = spatial::parse_unit(unit).factor;
  const fea::Interface& interface = coupled.geometry;
  return fmt::format(
      "  {:<7} {}, area {} {}^2, centroid {} {}, {} nodes, radii of gyration {} {}\n", coupled.name,
      name(coupled.coupling), number(interface.area / (length * length)), unit,
      coordinates(interface.centroid, length), unit, interface.nodes.size(),
      coordinates(interface.gyration, length), unit);
}

std::string compliance_text(const LinkResult& result, const spatial::UnitSystem& units) {
  std::string out;
  for (std::size_t i = 1; i < result.interfaces.size(); ++i) {
    const spatial::Compliance6 compliance =
        compliance_of(result.response.flexibility, result.interfaces, i);
    if (result.interfaces.size() > 2) out += "\nat " + result.interfaces[i].name + ":";
    out += "\n" + text(compliance, units);
    const spatial::EigenStiffness eigen = spatial::eigen_stiffness(compliance);
    out += fmt::format("eigen-stiffness: {} N/m, {} N m/rad\n", coordinates(eigen.translation, 1),
                       coordinates(eigen.rotation, 1));
  }
  out += fmt::format("symmetry defect {:.1e}\n", result.symmetry_defect);
  for (std::size_t i = 0; i < result.interfaces.size(); ++i)
    if (result.interfaces[i].coupling != fea::Coupling::rigid)
      out += fmt::format("fit residual of {}: {:.2g}\n", result.interfaces[i].name,
                         result.response.fit_residuals[i]);
  return out;
}

// How much softer the distributing couplings make each coordinate [%].
std::string spread(const spatial::Compliance6& rigid, const spatial::Compliance6& distributing) {
  static constexpr const char* names[] = {"tx", "ty", "tz", "rx", "ry", "rz"};
  std::string text;
  for (int j = 0; j < 6; ++j)
    text += fmt::format("{}{} {:.2g} %", j == 0 ? "" : ", ", names[j],
                        100 * (distributing.matrix()(j, j) / rigid.matrix()(j, j) - 1));
  return text;
}

std::string bracket_text(const LinkResult& result, const spatial::UnitSystem& units) {
  if (!result.bracket)
    return "\nbracket between rigid and distributing couplings: not computed (--bracket)\n";
  std::string out;
  for (std::size_t i = 1; i < result.interfaces.size(); ++i) {
    const std::string& name = result.interfaces[i].name;
    const auto rigid = compliance_of(result.bracket->rigid, result.interfaces, i);
    const auto distributing = compliance_of(result.bracket->distributing, result.interfaces, i);
    out += fmt::format("\n{} with all interfaces rigid, the lower bound:\n{}\n", name,
                       text(rigid, units));
    out += fmt::format("{} with all interfaces distributing, the upper bound:\n{}", name,
                       text(distributing, units));
    out += fmt::format("bracket of {}: softer by {}\n", name, spread(rigid, distributing));
  }
  return out;
}

std::string preload_text(const LinkResult& result, const spatial::UnitSystem& units) {
  if (!result.geometric_stiffness) return "";
  const fea::GeometricStiffness& geometric = *result.geometric_stiffness;
  const spatial::Vector6& wrench = *result.preload;
  const auto factor = [](double value) {
    return std::isfinite(value) ? number(value) + " times the preload" : "never";
  };
  return fmt::format(
             "\nunder the preload {} N, {} N m:\n{}", coordinates(wrench.head<3>(), 1),
             coordinates(wrench.tail<3>(), 1),
             text(spatial::Stiffness6(geometric.stiffness, result.compliance.frame()), units)) +
         fmt::format("buckles, loaded interface free: {}; held: {}\n",
                     factor(geometric.buckling_free), factor(geometric.buckling_held));
}

}  // namespace

namespace {

std::string material_text(const fea::LinkSpec& of) {
  const std::string known = of.young_deviation > 0
                                ? fmt::format(" +- {:.2g} % (1 sd, not in the error bars)",
                                              100 * of.young_deviation / of.material.young())
                                : "";
  return fmt::format("{} in {}{}, E = {} Pa{}, nu = {}\n", of.mesh_name, of.unit,
                     of.material_name.empty() ? "" : ", " + of.material_name,
                     number(of.material.young()), known, number(of.material.poisson()));
}

std::string joint_line(const fea::JointResult& joint, const std::string& unit) {
  const double length = spatial::parse_unit(unit).factor;
  const std::string kind =
      joint.layer ? fmt::format("a layer of {} N/m^3, {} N/m^3 tangentially,",
                                number(joint.layer->normal), number(joint.layer->tangential))
                  : "bonded";
  return fmt::format("  {} and {}: {} over {} {}^2, faces at most {} {} apart\n", joint.bodies[0],
                     joint.bodies[1], kind, number(joint.area / (length * length)), unit,
                     number(joint.gap < 1e-9 ? 0 : joint.gap / length), unit);
}

std::string joints_text(const LinkResult& result) {
  std::string out = result.joints.empty() ? "" : "joints:\n";
  for (const fea::JointResult& joint : result.joints) out += joint_line(joint, result.unit);
  return out;
}

}  // namespace

std::string text(const fea::LinkSpec& link) {
  if (link.bodies.empty()) return fmt::format("link {}: {}", link.name, material_text(link));
  std::string out = fmt::format("link {}, {} bodies:\n", link.name, link.bodies.size());
  for (const fea::LinkSpec& body : link.bodies)
    out += fmt::format("  {:<7} {}", body.name, material_text(body));
  return out;
}

std::string text(const LinkResult& result) {
  const spatial::UnitSystem units{.length = result.unit, .force = "N"};
  std::string out = mesh_line(result) + solver_line(result.response.solver);
  if (const std::string warning = result.blas.warning(); !warning.empty())
    out += fmt::format("warning: {} ({})\n", warning, result.blas.name);
  out += "interfaces:\n";
  for (const fea::CoupledInterface& interface : result.interfaces)
    out += interface_line(interface, result.unit);
  out += joints_text(result);
  if (result.mass)
    out += fmt::format("mass {} kg, centre of mass {} {}\n", number(*result.mass),
                       coordinates(result.center_of_mass, spatial::parse_unit(result.unit).factor),
                       result.unit);
  out += compliance_text(result, units) + "\n" + accuracy_text(result) +
         bracket_text(result, units) + preload_text(result, units);
  for (const std::string& warning : result.warnings) out += fmt::format("warning: {}\n", warning);
  return out;
}

}  // namespace kinetostat::report
