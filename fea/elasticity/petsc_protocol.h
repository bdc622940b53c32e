// Protocol between kinetostat and its helper program kinetostat-petsc: a model and its loads, and
// the displacements.
//
// The first process of the helper reads a request from the file that its first argument names and
// writes an answer to the second; a relative tolerance of the energy is the third. Both as
// byte_blocks.h has it.
#pragma once

#include <cstdint>
#include <istream>
#include <string>
#include <vector>

#include "kinetostat/common/byte_blocks.h"
#include "kinetostat/fea/elasticity/assembly.h"

namespace kinetostat::fea::petsc {

/// Exit codes of the helper.
inline constexpr int exit_done = 0, exit_bad_request = 64, exit_out_of_memory = 65,
                     exit_not_converged = 66;

/// TetMesh, materials and DofMap as plain arrays; sizes that follow from others are left out. In
/// the file one block more follows, the loads column by column: large, so that neither side holds
/// it whole.
struct Request {
  std::vector<std::int32_t> shape;  // order, curved
  std::vector<double> nodes;        // 3 each [m]
  std::vector<std::int32_t> connectivity, element_materials, fixed;
  std::vector<double> materials;                     // modulus [Pa], Poisson's ratio
  std::vector<double> body_points;                   // 3 each [m]
  std::vector<std::int32_t> body_sizes, body_nodes;  // nodes of all bodies in turn
  std::vector<std::int32_t> spring_nodes;            //
  std::vector<double> springs;                       // 9 each [N/m]
};

/// What the helper reports beside the displacements.
struct Figures {
  double iterations, residual;          // the most, the worst
  double coarse_unknowns;               // of all processes
  double setup_seconds, solve_seconds;  // wall clock
  double bytes, largest_bytes;          // peak memory of all processes together, of the largest
  double most_elements;                 // that one process has
};

struct Answer {
  std::vector<double> x;         // column by column
  std::vector<Figures> figures;  // one
};

inline std::string encode(const Request& r) {
  return common::encode_blocks(r.shape, r.nodes, r.connectivity, r.element_materials, r.fixed,
                               r.materials, r.body_points, r.body_sizes, r.body_nodes,
                               r.spring_nodes, r.springs);
}
inline bool read(std::istream& file, Request& r) {
  return common::read_blocks(file, r.shape, r.nodes, r.connectivity, r.element_materials, r.fixed,
                             r.materials, r.body_points, r.body_sizes, r.body_nodes, r.spring_nodes,
                             r.springs);
}
inline bool decode(const std::string& bytes, Answer& answer) {
  return common::decode_blocks(bytes, answer.x, answer.figures);
}

}  // namespace kinetostat::fea::petsc
