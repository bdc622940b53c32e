#include "kinetostat/fea/surface/step_program.h"

#include <algorithm>
#include <numbers>
#include <system_error>

#include <fmt/format.h>

#include "kinetostat/common/child_process.h"
#include "kinetostat/common/index.h"
#include "kinetostat/fea/surface/step_protocol.h"

namespace kinetostat::fea::step_program {
namespace {

using common::at;
using common::ChildResult;

static_assert(step::exit_out_of_memory == common::exit_out_of_memory);

constexpr double millimetre = 1e-3;
constexpr const char* phase = "STEP";

[[noreturn]] void explain(const ChildResult& result, double time_limit) {
  using Cause = StepError::Cause;
  if (result.end == ChildResult::End::timed_out)
    throw StepError(Cause::timed_out,
                    fmt::format("Open CASCADE was stopped after {:.3g} s", time_limit));
  if (result.ran_out_of_memory())
    throw StepError(Cause::out_of_memory, "Open CASCADE needs more memory than there is");
  if (result.end == ChildResult::End::exited && result.code == step::exit_impossible)
    throw StepError(Cause::unreadable, result.words.substr(0, result.words.find('\n')));
  throw StepError(Cause::unreadable, "Open CASCADE crashed on it");
}

step::Answer ask(const step::Request& request, const StepLimits& limits,
                 common::Progress& progress) {
  const std::filesystem::path helper =
      limits.helper.empty() ? common::find_helper("kinetostat-step") : limits.helper;
  if (helper.empty())
    throw StepError(StepError::Cause::no_helper,
                    "the helper program kinetostat-step is not installed; it is built where Open "
                    "CASCADE is (Debian: libocct-data-exchange-dev)");
  ChildResult result;
  try {
    result = common::run_child({.program = helper,
                                .arguments = {"--memory", std::to_string(limits.memory)},
                                .input = step::encode(request),
                                .time_limit = limits.time},
                               phase, progress);
  } catch (const std::system_error& error) {
    throw StepError(StepError::Cause::no_helper,
                    fmt::format("the helper program cannot be run: {}", error.what()));
  }
  step::Answer answer;
  if (result.end != ChildResult::End::exited || result.code != step::exit_done)
    explain(result, limits.time);
  if (!step::decode(result.answer, answer))
    throw StepError(StepError::Cause::unreadable, "the helper kinetostat-step answers nonsense");
  return answer;
}

// Texts that end with a zero byte each.
std::vector<std::string> texts(const std::string& bytes) {
  std::vector<std::string> list;
  for (std::size_t begin = 0; begin < bytes.size(); begin += list.back().size() + 1)
    list.emplace_back(bytes.c_str() + begin);
  return list;
}

Vector3 point_of(const std::vector<double>& list, std::size_t first) {
  return {list[first], list[first + 1], list[first + 2]};
}

bool is_consistent(const step::Answer& answer) {
  const auto points = static_cast<std::int32_t>(answer.points.size() / 3);
  const auto faces = static_cast<std::int32_t>(answer.kinds.size());
  return answer.points.size() % 3 == 0 &&
         answer.triangles.size() == 3 * answer.face_of_triangle.size() &&
         answer.solid_of_face.size() == answer.kinds.size() &&
         answer.figures.size() == step::figures_per_face * answer.kinds.size() &&
         std::all_of(answer.triangles.begin(), answer.triangles.end(),
                     [points](std::int32_t p) { return p >= 0 && p < points; }) &&
         std::all_of(answer.face_of_triangle.begin(), answer.face_of_triangle.end(),
                     [faces](std::int32_t f) { return f >= 1 && f <= faces; }) &&
         std::all_of(answer.kinds.begin(), answer.kinds.end(),
                     [](std::int32_t kind) { return kind >= 0 && at(kind) < face_kinds.size(); });
}

std::vector<CadFace> faces_of(const step::Answer& answer) {
  const std::vector<std::string> names = texts(answer.face_names),
                                 colours = texts(answer.face_colours),
                                 solids = texts(answer.solid_names);
  std::vector<CadFace> faces(answer.kinds.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    CadFace& face = faces[f];
    const std::size_t first = step::figures_per_face * f;
    if (f < names.size()) face.name = names[f];
    if (f < colours.size()) face.colour = colours[f];
    face.kind = static_cast<FaceKind>(answer.kinds[f]);
    face.area = answer.figures[first] * millimetre * millimetre;
    face.centre = millimetre * point_of(answer.figures, first + 1);
    face.point = millimetre * point_of(answer.figures, first + 4);
    face.direction = point_of(answer.figures, first + 7);
    face.radius = millimetre * answer.figures[first + 10];
    face.solid = answer.solid_of_face[f];
    if (face.solid >= 1 && at(face.solid) <= solids.size())
      face.solid_name = solids[at(face.solid - 1)];
  }
  return faces;
}

SurfaceMesh mesh_of(const step::Answer& answer) {
  SurfaceMesh mesh;
  mesh.faces = faces_of(answer);
  for (std::size_t i = 0; i < answer.points.size(); i += 3)
    mesh.points.push_back(millimetre * point_of(answer.points, i));
  for (std::size_t f = 1; f <= mesh.faces.size(); ++f)
    mesh.groups.push_back({group_of_face(f), {}});
  for (std::size_t t = 0; t < answer.face_of_triangle.size(); ++t) {
    mesh.triangles.push_back(
        {answer.triangles[3 * t], answer.triangles[3 * t + 1], answer.triangles[3 * t + 2]});
    mesh.groups[at(answer.face_of_triangle[t] - 1)].facets.push_back(static_cast<int>(t));
  }
  return mesh;
}

}  // namespace
}  // namespace kinetostat::fea::step_program

namespace kinetostat::fea {

SurfaceMesh step_surface(const std::string& step, const StepFacets& facets,
                         const StepLimits& limits, common::Progress& progress) {
  using namespace step_program;
  step::Request request;
  request.operation = "facets";
  request.step = step;
  request.numbers = {2 * std::numbers::pi / facets.sides, facets.deviation};
  const step::Answer answer = ask(request, limits, progress);
  if (!is_consistent(answer) || answer.triangles.empty())
    throw StepError(StepError::Cause::unreadable, "it holds no surface");
  return mesh_of(answer);
}

std::vector<Vector3> nearest_on_faces(const std::string& step, const PointsOnFaces& points,
                                      const StepLimits& limits, common::Progress& progress) {
  using namespace step_program;
  step::Request request;
  request.operation = "project";
  request.step = step;
  request.face_start = {0};
  for (std::size_t i = 0; i < points.points.size(); ++i) {
    const Vector3 p = points.points[i] / millimetre;
    request.points.insert(request.points.end(), p.data(), p.data() + 3);
    request.faces.insert(request.faces.end(), points.faces[i].begin(), points.faces[i].end());
    request.face_start.push_back(static_cast<std::int32_t>(request.faces.size()));
  }
  const step::Answer answer = ask(request, limits, progress);
  if (answer.points.size() != request.points.size())
    throw StepError(StepError::Cause::unreadable, "the helper kinetostat-step answers nonsense");
  std::vector<Vector3> nearest;
  for (std::size_t i = 0; i < answer.points.size(); i += 3)
    nearest.push_back(millimetre * point_of(answer.points, i));
  return nearest;
}

}  // namespace kinetostat::fea
