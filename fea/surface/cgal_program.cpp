#include "kinetostat/fea/surface/cgal_program.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include "kinetostat/common/child_process.h"
#include "kinetostat/fea/surface/cgal_protocol.h"

namespace kinetostat::fea {
namespace {

static_assert(cgal::exit_out_of_memory == common::exit_out_of_memory);

cgal::Request request_for(const SurfaceMesh& mesh, const CgalCall& call) {
  cgal::Request request{.operation = call.operation,
                        .numbers = call.numbers,
                        .points = {},
                        .triangles = {},
                        .markers = {call.markers.begin(), call.markers.end()}};
  for (const Vector3& p : mesh.points)
    request.points.insert(request.points.end(), p.data(), p.data() + 3);
  for (const Triangle& t : mesh.triangles)
    request.triangles.insert(request.triangles.end(), t.begin(), t.end());
  return request;
}

bool take_mesh(const cgal::Answer& answer, SurfaceMesh& mesh) {
  const auto points = static_cast<std::int32_t>(answer.points.size() / 3);
  for (std::size_t i = 0; i + 2 < answer.points.size(); i += 3)
    mesh.points.emplace_back(answer.points[i], answer.points[i + 1], answer.points[i + 2]);
  for (std::size_t i = 0; i + 2 < answer.triangles.size(); i += 3) {
    const Triangle t{answer.triangles[i], answer.triangles[i + 1], answer.triangles[i + 2]};
    if (!std::all_of(t.begin(), t.end(), [points](int p) { return p >= 0 && p < points; }))
      return false;
    mesh.triangles.push_back(t);
  }
  return !mesh.triangles.empty();
}

std::string why(const common::ChildResult& result, double time_limit) {
  if (result.end == common::ChildResult::End::timed_out)
    return fmt::format("stopped after {:.3g} s", time_limit);
  if (result.ran_out_of_memory()) return "not enough memory";
  if (result.end == common::ChildResult::End::exited && result.code == cgal::exit_impossible)
    return result.words.substr(0, result.words.find('\n'));
  return "CGAL cannot work on this surface";
}

}  // namespace

CgalResult ask_cgal(const SurfaceMesh& surface, const CgalCall& call, const std::string& phase,
                    common::Progress& progress) {
  const std::filesystem::path helper =
      call.helper.empty() ? common::find_helper("kinetostat-cgal") : call.helper;
  if (helper.empty())
    return {.fault =
                "the helper program kinetostat-cgal is not installed; it is built where CGAL "
                "is (Debian: libcgal-dev)"};
  common::ChildResult result;
  try {
    result = common::run_child({.program = helper,
                                .arguments = {"--memory", std::to_string(call.memory_limit)},
                                .input = cgal::encode(request_for(surface, call)),
                                .time_limit = call.time_limit},
                               phase, progress);
  } catch (const std::system_error& error) {
    return {.fault = fmt::format("the helper program cannot be run: {}", error.what())};
  }
  cgal::Answer answer;
  CgalResult found;
  const bool done =
      result.end == common::ChildResult::End::exited && result.code == cgal::exit_done &&
      cgal::decode(result.answer, answer) && take_mesh(answer, found.mesh) &&
      (answer.markers.empty() || answer.markers.size() == found.mesh.triangles.size());
  if (!done)
    return {.fault = why(result, call.time_limit), .out_of_memory = result.ran_out_of_memory()};
  found.counts = std::move(answer.counts);
  found.markers.assign(answer.markers.begin(), answer.markers.end());
  const WeldReport welded = weld(found.mesh, 0);
  for (auto f = welded.collapsed.rbegin(); f != welded.collapsed.rend(); ++f)
    if (!found.markers.empty()) found.markers.erase(found.markers.begin() + *f);
  return found;
}

}  // namespace kinetostat::fea
