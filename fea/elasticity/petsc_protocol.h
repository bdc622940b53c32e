// Protocol between kinetostat and its helper program kinetostat-petsc: a model and its loads, and
// the displacements.
//
// The first process of the helper reads a request from the file that its first argument names and
// writes an answer to the second; a relative tolerance of the energy is the third. Both as
// byte_blocks.h has it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kinetostat/common/byte_blocks.h"
#include "kinetostat/fea/elasticity/assembly.h"

namespace kinetostat::fea::petsc {

/// Exit codes of the helper.
inline constexpr int exit_done = 0, exit_bad_request = 64, exit_out_of_memory = 65,
                     exit_not_converged = 66;

/// TetMesh, materials, Unknowns and loads as plain arrays; sizes that follow from others are left
/// out.
struct Request {
  std::vector<std::int32_t> shape;  // order, curved
  std::vector<double> nodes;        // 3 each [m]
  std::vector<std::int32_t> connectivity, element_materials, fixed;
  std::vector<double> materials;                     // modulus [Pa], Poisson's ratio
  std::vector<double> body_points;                   // 3 each [m]
  std::vector<std::int32_t> body_sizes, body_nodes;  // nodes of all bodies in turn
  std::vector<std::int32_t> spring_nodes;            //
  std::vector<double> springs;                       // 9 each [N/m]
  std::vector<double> loads;                         // column by column
};

struct Answer {
  std::vector<double> x;        // column by column
  std::vector<double> numbers;  // iterations, residual, coarse unknowns, setup [s], solution [s],
                                // peak memory of all processes [bytes]
};

inline std::string encode(const Request& r) {
  return common::encode_blocks(r.shape, r.nodes, r.connectivity, r.element_materials, r.fixed,
                               r.materials, r.body_points, r.body_sizes, r.body_nodes,
                               r.spring_nodes, r.springs, r.loads);
}
inline bool decode(const std::string& bytes, Request& r) {
  return common::decode_blocks(bytes, r.shape, r.nodes, r.connectivity, r.element_materials,
                               r.fixed, r.materials, r.body_points, r.body_sizes, r.body_nodes,
                               r.spring_nodes, r.springs, r.loads);
}
inline std::string encode(const Answer& answer) {
  return common::encode_blocks(answer.x, answer.numbers);
}
inline bool decode(const std::string& bytes, Answer& answer) {
  return common::decode_blocks(bytes, answer.x, answer.numbers);
}

}  // namespace kinetostat::fea::petsc
