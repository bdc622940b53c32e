// kinetostat-cgal: repairs one surface with CGAL, in a process of its own, because CGAL's licence
// (GPL-3+) is its own affair and because its algorithms may run out of time or memory on a surface
// that is broken enough. What is read and written is described in fea/surface/cgal_protocol.h.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/detect_features.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_mesh_to_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>
#include <CGAL/boost/graph/copy_face_graph.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <unistd.h>

#include "kinetostat/fea/surface/cgal_protocol.h"

#include "body_split.h"
#include "child.h"

namespace {

using namespace kinetostat;
using namespace kinetostat::fea::cgal;
namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Halfedge = Mesh::Halfedge_index;

struct Soup {
  std::vector<Point> points;
  std::vector<std::vector<std::size_t>> facets;
};

Soup soup_of(const Request& request) {
  Soup soup;
  for (std::size_t i = 0; i + 2 < request.points.size(); i += 3)
    soup.points.emplace_back(request.points[i], request.points[i + 1], request.points[i + 2]);
  for (std::size_t i = 0; i + 2 < request.triangles.size(); i += 3)
    soup.facets.push_back({static_cast<std::size_t>(request.triangles[i]),
                           static_cast<std::size_t>(request.triangles[i + 1]),
                           static_cast<std::size_t>(request.triangles[i + 2])});
  return soup;
}

// Whether to give bodies that share edges corners of their own, or to cut them there.
enum class SharedEdges { cut, split };

void split_bodies(Soup& soup) {
  helpers::Triangles mesh;
  for (const Point& p : soup.points) mesh.points.emplace_back(p.x(), p.y(), p.z());
  for (const auto& facet : soup.facets) mesh.corners.push_back({facet[0], facet[1], facet[2]});
  helpers::split_bodies(mesh);
  soup.points.clear();
  for (const auto& p : mesh.points) soup.points.emplace_back(p.x(), p.y(), p.z());
  for (std::size_t f = 0; f < soup.facets.size(); ++f)
    soup.facets[f].assign(mesh.corners[f].begin(), mesh.corners[f].end());
}

Mesh mesh_of(Soup soup, SharedEdges shared = SharedEdges::cut) {
  pmp::repair_polygon_soup(soup.points, soup.facets);
  if (shared == SharedEdges::split) split_bodies(soup);
  pmp::orient_polygon_soup(soup.points, soup.facets);  // splits what is not manifold
  Mesh mesh;
  pmp::polygon_soup_to_polygon_mesh(soup.points, soup.facets, mesh);
  pmp::stitch_borders(mesh);
  return mesh;
}

Answer answer_of(const Mesh& mesh) {
  Soup soup;
  pmp::polygon_mesh_to_polygon_soup(mesh, soup.points, soup.facets);
  Answer answer;
  for (const Point& p : soup.points)
    answer.points.insert(answer.points.end(), {p.x(), p.y(), p.z()});
  for (const auto& facet : soup.facets)
    for (const std::size_t corner : facet)
      answer.triangles.push_back(static_cast<std::int32_t>(corner));
  return answer;
}

// A sticker or a fin that was closed by its own back: thinner than 3e-5 of its width, which is the
// rounding of a file.
bool is_flat(const Mesh& piece) {
  return std::abs(pmp::volume(piece)) < 1e-5 * std::pow(pmp::area(piece), 1.5);
}

// Leaves out closed pieces without volume, unless nothing else is there. Returns how many.
std::int64_t remove_flat_pieces(Mesh& mesh) {
  std::vector<Mesh> pieces;
  pmp::split_connected_components(mesh, pieces);
  const auto flat = static_cast<std::int64_t>(std::erase_if(
      pieces, [](const Mesh& piece) { return CGAL::is_closed(piece) && is_flat(piece); }));
  if (flat == 0 || pieces.empty()) return 0;
  mesh.clear();
  for (const Mesh& piece : pieces) CGAL::copy_face_graph(piece, mesh);
  return flat;
}

// Every loop of open edges gets a patch of the least area that its own corners allow.
Answer fill(const Request& request) {
  Mesh mesh = mesh_of(soup_of(request));
  std::vector<Halfedge> holes;
  pmp::extract_boundary_cycles(mesh, std::back_inserter(holes));
  std::int64_t closed = 0;
  for (const Halfedge hole : holes) {
    std::vector<Mesh::Face_index> patch;
    pmp::triangulate_hole(mesh, hole, std::back_inserter(patch),
                          CGAL::parameters::use_delaunay_triangulation(true));
    if (!patch.empty()) ++closed;
  }
  const std::int64_t flat = remove_flat_pieces(mesh);
  Answer answer = answer_of(mesh);
  answer.counts = {closed, static_cast<std::int64_t>(holes.size()) - closed, flat};
  return answer;
}

// Facets that cross are taken away and the holes closed, a little farther around each time.
void uncross(Mesh& piece) {
  if (!pmp::does_self_intersect(piece)) return;
  pmp::experimental::remove_self_intersections(piece, CGAL::parameters::preserve_genus(false));
  piece.collect_garbage();
  if (CGAL::is_empty(piece) || !CGAL::is_closed(piece) || pmp::does_self_intersect(piece))
    throw Impossible("a piece of the surface crosses itself");
}

// Closed pieces of the surface that have a volume, those that bound material before cavities, each
// in the order of the input. `flat` counts those without one.
std::vector<Mesh> pieces_of(const Mesh& mesh, std::int64_t& flat) {
  std::vector<Mesh> pieces;
  pmp::split_connected_components(mesh, pieces);
  for (const Mesh& piece : pieces)
    if (!CGAL::is_closed(piece)) throw Impossible("a piece of the surface is open");
  flat = static_cast<std::int64_t>(std::erase_if(pieces, is_flat));
  if (pieces.empty()) throw Impossible("no piece of the surface has a volume");
  for (Mesh& piece : pieces) uncross(piece);
  std::stable_partition(pieces.begin(), pieces.end(),
                        [](const Mesh& piece) { return pmp::volume(piece) > 0; });
  return pieces;
}

// Bodies whose boxes are apart.
struct Batch {
  Mesh mesh;
  std::vector<CGAL::Bbox_3> boxes;
  bool is_cavity;

  bool takes(const CGAL::Bbox_3& box, bool cavity) const {
    return cavity == is_cavity &&
           std::none_of(boxes.begin(), boxes.end(),
                        [&box](const CGAL::Bbox_3& other) { return CGAL::do_overlap(box, other); });
  }
};

// Each piece in the first batch that takes it: hundreds of screws are a few operations then,
// instead of one on the whole for each.
std::vector<Batch> batches_of(const std::vector<Mesh>& pieces) {
  std::vector<Batch> batches;
  for (const Mesh& piece : pieces) {
    const CGAL::Bbox_3 box = pmp::bbox(piece);
    const bool is_cavity = pmp::volume(piece) < 0;
    auto batch = std::find_if(batches.begin(), batches.end(),
                              [&](const Batch& some) { return some.takes(box, is_cavity); });
    if (batch == batches.end())
      batch = batches.insert(batch, {.mesh = {}, .boxes = {}, .is_cavity = is_cavity});
    CGAL::copy_face_graph(piece, batch->mesh);
    batch->boxes.push_back(box);
  }
  return batches;
}

// The union of all bodies, less the cavities: shells that face inwards.
Answer unite(const Request& request) {
  std::int64_t flat = 0;
  std::vector<Batch> batches =
      batches_of(pieces_of(mesh_of(soup_of(request), SharedEdges::split), flat));
  Mesh whole = std::move(batches.front().mesh);
  for (std::size_t i = 1; i < batches.size(); ++i) {
    Batch& batch = batches[i];
    if (batch.is_cavity) pmp::reverse_face_orientations(batch.mesh);
    const auto checked = CGAL::parameters::throw_on_self_intersection(true);
    Mesh result;
    const bool manifold =
        batch.is_cavity ? pmp::corefine_and_compute_difference(whole, batch.mesh, result, checked)
                        : pmp::corefine_and_compute_union(whole, batch.mesh, result, checked);
    if (!manifold) throw Impossible("the united bodies touch along an edge or at a point only");
    whole = std::move(result);
  }
  Answer answer = answer_of(whole);
  answer.counts = {flat};
  return answer;
}

Answer wrap(const Request& request) {
  if (request.numbers.size() != 2 || !(request.numbers[0] > 0) || !(request.numbers[1] > 0))
    throw std::invalid_argument("wrap: alpha and offset");
  const Soup soup = soup_of(request);
  Mesh mesh;
  CGAL::alpha_wrap_3(soup.points, soup.facets, request.numbers[0], request.numbers[1], mesh);
  return answer_of(mesh);
}

// -- Remeshing ------------------------------------------------------------------------------------

using Markers = Mesh::Property_map<Mesh::Face_index, int>;
using EdgeFlags = Mesh::Property_map<Mesh::Edge_index, bool>;
using VertexFlags = Mesh::Property_map<Mesh::Vertex_index, bool>;

// The facets in their order, each with its marker.
Mesh marked_mesh(const Request& request, Markers& markers) {
  Soup soup = soup_of(request);
  if (!pmp::is_polygon_soup_a_polygon_mesh(soup.facets) &&
      !pmp::orient_polygon_soup(soup.points, soup.facets))
    throw Impossible("the surface is not manifold");
  Mesh mesh;
  pmp::polygon_soup_to_polygon_mesh(soup.points, soup.facets, mesh);
  markers = mesh.add_property_map<Mesh::Face_index, int>("f:marker", 0).first;
  std::size_t i = 0;
  for (const Mesh::Face_index f : mesh.faces()) markers[f] = request.markers[i++];
  return mesh;
}

EdgeFlags marker_borders(Mesh& mesh, const Markers& markers) {
  EdgeFlags kept = mesh.add_property_map<Mesh::Edge_index, bool>("e:kept", false).first;
  for (const Mesh::Edge_index e : mesh.edges()) {
    const Halfedge h = mesh.halfedge(e);
    if (markers[mesh.face(h)] != markers[mesh.face(mesh.opposite(h))]) kept[e] = true;
  }
  return kept;
}

// Where kept edges end, branch or turn a corner.
VertexFlags kept_corners(Mesh& mesh, const EdgeFlags& kept, double sharp_angle) {
  VertexFlags corners = mesh.add_property_map<Mesh::Vertex_index, bool>("v:kept", false).first;
  const double straight = -std::cos(sharp_angle * CGAL_PI / 180);
  for (const Mesh::Vertex_index v : mesh.vertices()) {
    std::vector<Kernel::Vector_3> arms;
    for (const Halfedge h : CGAL::halfedges_around_target(v, mesh))
      if (kept[mesh.edge(h)]) arms.push_back(mesh.point(mesh.source(h)) - mesh.point(v));
    if (arms.empty()) continue;
    const double lengths =
        arms.size() == 2 ? std::sqrt(arms[0].squared_length() * arms[1].squared_length()) : 0;
    corners[v] = arms.size() != 2 || arms[0] * arms[1] > straight * lengths;
  }
  return corners;
}

Answer remesh(const Request& request) {
  if (request.numbers.size() != 2 || !(request.numbers[0] > 0) || !(request.numbers[1] > 0) ||
      3 * request.markers.size() != request.triangles.size())
    throw std::invalid_argument("remesh: length of edges, angle and a marker for each triangle");
  Markers markers;
  Mesh mesh = marked_mesh(request, markers);
  const double length = request.numbers[0], sharp_angle = request.numbers[1];
  const EdgeFlags kept = marker_borders(mesh, markers);
  // Normals of needles and caps mean nothing.
  pmp::experimental::remove_almost_degenerate_faces(
      mesh, std::cos(178.5 * CGAL_PI / 180), 30, 0.2 * length,
      CGAL::parameters::edge_is_constrained_map(kept));
  pmp::detect_sharp_edges(mesh, sharp_angle, kept);
  const VertexFlags corners = kept_corners(mesh, kept, sharp_angle);
  pmp::isotropic_remeshing(mesh.faces(), length, mesh,
                           CGAL::parameters::number_of_iterations(4)
                               .face_patch_map(markers)
                               .edge_is_constrained_map(kept)
                               .vertex_is_constrained_map(corners));
  mesh.collect_garbage();
  Answer answer;
  std::vector<std::int32_t> number(mesh.number_of_vertices());
  for (const Mesh::Vertex_index v : mesh.vertices()) {
    number[v] = static_cast<std::int32_t>(answer.points.size() / 3);
    const Point& p = mesh.point(v);
    answer.points.insert(answer.points.end(), {p.x(), p.y(), p.z()});
  }
  for (const Mesh::Face_index f : mesh.faces()) {
    for (const Mesh::Vertex_index v : CGAL::vertices_around_face(mesh.halfedge(f), mesh))
      answer.triangles.push_back(number[v]);
    answer.markers.push_back(markers[f]);
  }
  return answer;
}

bool is_consistent(const Request& request) {
  const auto points = static_cast<std::int64_t>(request.points.size() / 3);
  return request.points.size() % 3 == 0 && request.triangles.size() % 3 == 0 &&
         !request.triangles.empty() &&
         std::all_of(request.triangles.begin(), request.triangles.end(),
                     [points](std::int32_t corner) { return corner >= 0 && corner < points; }) &&
         std::all_of(request.points.begin(), request.points.end(),
                     [](double x) { return std::isfinite(x); });
}

int run() {
  Request request;
  if (!decode(read_all(STDIN_FILENO), request) || !is_consistent(request)) return exit_bad_request;
  Answer answer;
  if (request.operation == "fill")
    answer = fill(request);
  else if (request.operation == "unite")
    answer = unite(request);
  else if (request.operation == "wrap")
    answer = wrap(request);
  else if (request.operation == "remesh")
    answer = remesh(request);
  else
    return exit_bad_request;
  return write_all(answer_descriptor, encode(answer)) ? exit_done : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string(argv[1]) == "--version") {
    std::printf("kinetostat-cgal %s with CGAL %s, GPL-3.0+\n", KINETOSTAT_VERSION,
                CGAL_VERSION_STR);
    return 0;
  }
  limit_process(argc, argv);
  const auto work = [] {
    try {
      return run();
    } catch (const pmp::Corefinement::Self_intersection_exception&) {
      throw Impossible("a piece of the surface crosses itself");
    }
  };
  end_with(work, exit_out_of_memory, exit_impossible);
}
