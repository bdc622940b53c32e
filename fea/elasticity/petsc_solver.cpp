#include "kinetostat/fea/elasticity/petsc_solver.h"

#include <filesystem>
#include <sstream>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/common/child_process.h"
#include "kinetostat/common/index.h"
#include "kinetostat/common/out_of_memory.h"
#include "kinetostat/fea/elasticity/petsc_protocol.h"

namespace kinetostat::fea {
namespace {

using common::at;

static_assert(petsc::exit_out_of_memory == common::exit_out_of_memory);

constexpr const char* helper = "kinetostat-petsc";

petsc::Request request_of(const TetMesh& mesh, const std::vector<Material>& materials,
                          const DofMap& unknowns) {
  petsc::Request request{.shape = {mesh.order, mesh.curved ? 1 : 0},
                         .nodes = {},
                         .connectivity = {mesh.connectivity.begin(), mesh.connectivity.end()},
                         .element_materials = {mesh.materials.begin(), mesh.materials.end()},
                         .fixed = {},
                         .materials = {},
                         .body_points = {},
                         .body_sizes = {},
                         .body_nodes = {},
                         .spring_nodes = {},
                         .springs = {}};
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const Vector3& p = mesh.nodes[n];
    request.nodes.insert(request.nodes.end(), p.begin(), p.end());
    if (unknowns.is_fixed(static_cast<int>(n))) request.fixed.push_back(static_cast<int>(n));
  }
  for (const Material& material : materials)
    request.materials.insert(request.materials.end(), {material.young(), material.poisson()});
  for (const ReferenceBody& body : unknowns.bodies()) {
    request.body_points.insert(request.body_points.end(), body.point.begin(), body.point.end());
    request.body_sizes.push_back(static_cast<int>(body.nodes.size()));
    request.body_nodes.insert(request.body_nodes.end(), body.nodes.begin(), body.nodes.end());
  }
  for (const GroundSpring& spring : unknowns.springs()) {
    request.spring_nodes.push_back(spring.node);
    request.springs.insert(request.springs.end(), spring.stiffness.data(),
                           spring.stiffness.data() + 9);
  }
  return request;
}

// The program to start and its arguments.
common::ChildCall call_for(const PetscOptions& options) {
  const std::filesystem::path program = common::find_helper(helper);
  const std::vector<std::string> own{common::ChildCall::input_path, common::ChildCall::answer_path,
                                     fmt::format("{:g}", options.tolerance)};
  if (options.processes == 1) return {.program = program, .arguments = own, .input = {}};
  std::istringstream words(options.launcher);
  common::ChildCall call{.program = {}, .arguments = {}, .input = {}};
  for (std::string word; words >> word;) {
    if (call.program.empty())
      call.program = common::find_program(word);
    else
      call.arguments.push_back(word);
  }
  if (call.program.empty())
    throw PetscFailure(
        fmt::format("the program '{}' that starts several processes is not installed (Debian: "
                    "openmpi-bin)",
                    options.launcher.substr(0, options.launcher.find(' '))));
  call.arguments.insert(call.arguments.end(),
                        {"-n", std::to_string(options.processes), program.string()});
  call.arguments.insert(call.arguments.end(), own.begin(), own.end());
  return call;
}

std::string reason(const common::ChildResult& result) {
  if (result.end == common::ChildResult::End::killed_by_signal) return "it crashed";
  if (result.code == petsc::exit_not_converged) return "it did not converge";
  std::string words = result.words.substr(0, 600);
  while (!words.empty() && words.back() == '\n') words.pop_back();
  return words.empty() ? fmt::format("it ended with code {}", result.code) : words;
}

}  // namespace

bool has_petsc() { return !common::find_helper(helper).empty(); }

double petsc_bytes(std::size_t unknowns, std::size_t columns, int processes) {
  constexpr double per_process = 65e6;
  // Per unknown; borders between several processes, and loads and displacements in memory files.
  constexpr double matrices = 1200, borders = 150, per_load = 16;
  const double per_unknown =
      matrices + (processes > 1 ? borders : 0.0) + per_load * static_cast<double>(columns);
  return processes * per_process + per_unknown * static_cast<double>(unknowns);
}

PetscSolution solve_with_petsc(const TetMesh& mesh, const std::vector<Material>& materials,
                               const DofMap& unknowns, const Eigen::MatrixXd& loads,
                               const PetscOptions& options, common::Progress& progress) {
  common::ChildCall call = call_for(options);
  call.input = encode(request_of(mesh, materials, unknowns));
  common::append_count(call.input, at(loads.size()));
  call.more_input = {
      {reinterpret_cast<const char*>(loads.data()), sizeof(double) * at(loads.size())}};
  common::ChildResult result;
  try {
    result = common::run_child(call, "PETSc", progress);
  } catch (const std::system_error& error) {
    throw PetscFailure(fmt::format("PETSc cannot be started: {}", error.what()));
  }
  if (result.ran_out_of_memory())
    throw common::OutOfMemory("PETSc needs more memory than there is",
                              "Use a larger element size, or more machines (--launcher)");
  petsc::Answer answer;
  if (result.end != common::ChildResult::End::exited || result.code != petsc::exit_done ||
      !decode(std::exchange(result.answer, {}), answer) || answer.x.size() != at(loads.size()) ||
      answer.figures.size() != 1)
    throw PetscFailure(fmt::format("PETSc failed: {}", reason(result)));
  const petsc::Figures& figures = answer.figures.front();
  return {.x = Eigen::Map<const Eigen::MatrixXd>(answer.x.data(), loads.rows(), loads.cols()),
          .iterations = static_cast<int>(figures.iterations),
          .residual = figures.residual,
          .coarse_unknowns = static_cast<std::size_t>(figures.coarse_unknowns),
          .setup_seconds = figures.setup_seconds,
          .solve_seconds = figures.solve_seconds,
          .bytes = figures.bytes,
          .largest_bytes = figures.largest_bytes,
          .most_elements = static_cast<std::size_t>(figures.most_elements)};
}

}  // namespace kinetostat::fea
