// kinetostat-tetgen: runs TetGen on one request, in a process of its own, because TetGen ends the
// process it runs in when it meets bad input, and because its licence (AGPL) is its own affair.
// What is read and written is described in fea/tetgen_protocol.h.
#include <cstdlib>
#include <memory>
#include <new>
#include <sys/resource.h>
#include <unistd.h>

#define TETLIBRARY
#include <tetgen.h>

#include "kinetostat/fea/tetgen_protocol.h"

namespace {

using namespace kinetostat::fea::tetgen;

std::string read_all(int descriptor) {
  std::string bytes;
  std::vector<char> buffer(1 << 20);
  for (ssize_t got; (got = read(descriptor, buffer.data(), buffer.size())) > 0;)
    bytes.append(buffer.data(), static_cast<std::size_t>(got));
  return bytes;
}

bool write_all(int descriptor, const std::string& bytes) {
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t put = write(descriptor, bytes.data() + at, bytes.size() - at);
    if (put <= 0) return false;
    at += static_cast<std::size_t>(put);
  }
  return true;
}

bool is_consistent(const Request& request) {
  const auto points = static_cast<std::int64_t>(request.points.size() / 3);
  for (const std::int32_t corner : request.triangles)
    if (corner < 0 || corner >= points) return false;
  return request.points.size() % 3 == 0 && request.holes.size() % 3 == 0 &&
         request.triangles.size() == 3 * request.markers.size();
}

double* copied(const std::vector<double>& values) {
  auto* copy = new double[values.size()];
  std::copy(values.begin(), values.end(), copy);
  return copy;  // tetgenio deletes it
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
    tetgenio::facet& facet = in.facetlist[f];
    tetgenio::init(&facet);
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    tetgenio::polygon& polygon = facet.polygonlist[0];
    tetgenio::init(&polygon);
    polygon.numberofvertices = 3;
    polygon.vertexlist = new int[3];
    for (std::size_t k = 0; k < 3; ++k) polygon.vertexlist[k] = request.triangles[3 * f + k];
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

// The address sanitizer reserves terabytes of address space: no limit then.
void limit_memory(int argc, char** argv) {
#ifndef __SANITIZE_ADDRESS__
  if (argc != 3 || std::string(argv[1]) != "--memory") return;
  const rlimit limit{std::strtoull(argv[2], nullptr, 10), RLIM_INFINITY};
  if (limit.rlim_cur > 0) setrlimit(RLIMIT_AS, &limit);
#else
  (void)argc, (void)argv;
#endif
}

int run() {
  Request request;
  if (!decode(read_all(STDIN_FILENO), request) || !is_consistent(request)) return exit_bad_request;
  // Not destroyed: after a failure TetGen's structures are not fit for it, and the process ends.
  auto* in = new tetgenio;
  auto* out = new tetgenio;
  fill(*in, request);
  tetrahedralize(request.switches.data(), in, out);
  return write_all(answer_descriptor, encode(taken_from(*out))) ? exit_done : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  setvbuf(stdout, nullptr, _IOLBF, 0);  // its words must be out before it crashes
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  limit_memory(argc, argv);
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
