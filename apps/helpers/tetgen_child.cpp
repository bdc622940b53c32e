// kinetostat-tetgen: runs TetGen on one request, in a process of its own, because TetGen ends the
// process it runs in when it meets bad input, and because its licence (AGPL) is its own affair.
// What is read and written is described in fea/mesh/tetgen_protocol.h.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <new>
#include <unistd.h>

#define TETLIBRARY
#include <tetgen.h>

#include "kinetostat/fea/mesh/tetgen_protocol.h"

#include "child.h"

namespace {

using namespace kinetostat;
using namespace kinetostat::fea::tetgen;

bool is_consistent(const Request& request) {
  const auto points = static_cast<std::int64_t>(request.points.size() / 3);
  for (const std::int32_t corner : request.triangles)
    if (corner < 0 || corner >= points) return false;
  return request.points.size() % 3 == 0 && request.holes.size() % 3 == 0 &&
         request.sizes.size() % 4 == 0 && request.triangles.size() == 3 * request.markers.size();
}

// The largest volume allowed at a point: that of the nearest of the given ones, found in a k-d tree
// that lies in the order of the entries.
class VolumeLimits {
 public:
  explicit VolumeLimits(const std::vector<double>& sizes) : entries_(sizes.size() / 4) {
    for (std::size_t i = 0; i < entries_.size(); ++i)
      std::copy_n(sizes.begin() + static_cast<std::ptrdiff_t>(4 * i), 4, entries_[i].begin());
    arrange(0, entries_.size(), 0);
  }

  double at(const std::array<double, 3>& point) const {
    double distance = std::numeric_limits<double>::infinity(), limit = distance;
    search(point, 0, entries_.size(), 0, distance, limit);
    return limit;
  }

 private:
  using Entry = std::array<double, 4>;

  // The middle entry of a range divides it along the axis.
  void arrange(std::size_t first, std::size_t last, std::size_t axis) {
    if (last - first < 2) return;
    const std::size_t middle = first + (last - first) / 2;
    const auto at = [this](std::size_t i) {
      return entries_.begin() + static_cast<std::ptrdiff_t>(i);
    };
    std::nth_element(at(first), at(middle), at(last),
                     [axis](const Entry& a, const Entry& b) { return a[axis] < b[axis]; });
    arrange(first, middle, (axis + 1) % 3);
    arrange(middle + 1, last, (axis + 1) % 3);
  }

  void search(const std::array<double, 3>& point, std::size_t first, std::size_t last,
              std::size_t axis, double& distance, double& limit) const {
    if (first >= last) return;
    const std::size_t middle = first + (last - first) / 2;
    const Entry& entry = entries_[middle];
    double square = 0;
    for (std::size_t k = 0; k < 3; ++k) square += (entry[k] - point[k]) * (entry[k] - point[k]);
    if (square < distance) {
      distance = square;
      limit = entry[3];
    }
    const double side = point[axis] - entry[axis];
    const std::size_t next = (axis + 1) % 3;
    const auto below = [&] { search(point, first, middle, next, distance, limit); };
    const auto above = [&] { search(point, middle + 1, last, next, distance, limit); };
    if (side < 0) {
      below();
      if (side * side < distance) above();
    } else {
      above();
      if (side * side < distance) below();
    }
  }

  std::vector<Entry> entries_;
};

// TetGen asks a plain function, which can reach nothing but globals.
const VolumeLimits* volume_limits = nullptr;

bool is_too_large(double* a, double* b, double* c, double* d, double*, double) {
  std::array<double, 3> centroid{}, u{}, v{}, w{};
  for (std::size_t k = 0; k < 3; ++k) {
    centroid[k] = (a[k] + b[k] + c[k] + d[k]) / 4;
    u[k] = a[k] - d[k];
    v[k] = b[k] - d[k];
    w[k] = c[k] - d[k];
  }
  const double six_volumes = u[0] * (v[1] * w[2] - v[2] * w[1]) +
                             u[1] * (v[2] * w[0] - v[0] * w[2]) +
                             u[2] * (v[0] * w[1] - v[1] * w[0]);
  return std::abs(six_volumes) > 6 * volume_limits->at(centroid);
}

double* copied(const std::vector<double>& values) {
  auto* copy = new double[values.size()];
  std::copy(values.begin(), values.end(), copy);
  return copy;  // tetgenio deletes it
}

void set_triangle(tetgenio::facet& facet, const int* corners) {
  tetgenio::init(&facet);
  facet.numberofpolygons = 1;
  facet.polygonlist = new tetgenio::polygon[1];
  tetgenio::polygon& polygon = facet.polygonlist[0];
  tetgenio::init(&polygon);
  polygon.numberofvertices = 3;
  polygon.vertexlist = new int[3];
  std::copy(corners, corners + 3, polygon.vertexlist);
}

void fill(tetgenio& in, const Request& request) {
  in.numberofpoints = static_cast<int>(request.points.size() / 3);
  in.pointlist = copied(request.points);
  in.numberofholes = static_cast<int>(request.holes.size() / 3);
  if (in.numberofholes > 0) in.holelist = copied(request.holes);
  in.numberoffacets = static_cast<int>(request.markers.size());
  in.facetlist = new tetgenio::facet[request.markers.size()];
  in.facetmarkerlist = new int[request.markers.size()];
  for (std::size_t f = 0; f < request.markers.size(); ++f) {
    set_triangle(in.facetlist[f], &request.triangles[3 * f]);
    in.facetmarkerlist[f] = request.markers[f];
  }
}

Answer taken_from(const tetgenio& out) {
  Answer answer;
  answer.points.assign(out.pointlist, out.pointlist + 3 * std::ptrdiff_t{out.numberofpoints});
  if (out.tetrahedronlist != nullptr)
    answer.tetrahedra.assign(out.tetrahedronlist,
                             out.tetrahedronlist + 4 * std::ptrdiff_t{out.numberoftetrahedra});
  if (out.trifacelist != nullptr && out.trifacemarkerlist != nullptr) {
    answer.triangles.assign(out.trifacelist,
                            out.trifacelist + 3 * std::ptrdiff_t{out.numberoftrifaces});
    answer.markers.assign(out.trifacemarkerlist, out.trifacemarkerlist + out.numberoftrifaces);
  }
  return answer;
}

int run() {
  Request request;
  if (!decode(read_all(STDIN_FILENO), request) || !is_consistent(request)) return exit_bad_request;
  // Not destroyed: after a failure TetGen's structures are not fit for it, and the process ends.
  static auto* const in = new tetgenio;
  static auto* const out = new tetgenio;
  fill(*in, request);
  const VolumeLimits limits(request.sizes);
  if (!request.sizes.empty()) {
    volume_limits = &limits;
    in->tetunsuitable = is_too_large;
  }
  tetrahedralize(request.switches.data(), in, out);
  return write_all(answer_descriptor, encode(taken_from(*out))) ? exit_done : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  setvbuf(stdout, nullptr, _IOLBF, 0);  // its words must be out before it crashes
  limit_process(argc, argv);
  int code = EXIT_FAILURE;
  try {
    code = run();
  } catch (const std::bad_alloc&) {
    code = exit_out_of_memory;
  } catch (const int tetgen_code) {
    code = tetgen_code == 1 ? exit_out_of_memory : refused_base + tetgen_code;
  } catch (...) {
    code = EXIT_FAILURE;
  }
  std::fflush(stdout);
  _exit(code);
}
