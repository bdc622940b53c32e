// Protocol between kinetostat and its helper program kinetostat-tetgen. Nothing but the standard
// library, so that the helper shares no code with the rest.
//
// The helper reads one request from standard input and writes one answer to file descriptor
// answer_descriptor, both as byte_blocks.h has it:
//   request: switches (char), points (3 doubles each), triangles (3 int32 each), markers (int32 per
//            triangle), hole points (3 doubles each), sizes (4 doubles each: a point and the
//            largest volume of the elements whose centroid is nearer to it than to the others; may
//            be none)
//   answer:  points (3 doubles each), tetrahedra (4 int32 each), boundary triangles (3 int32 each),
//            their markers (int32 each)
// TetGen's own words go to standard output. Limits are arguments: --memory BYTES.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kinetostat/common/byte_blocks.h"

namespace kinetostat::fea::tetgen {

inline constexpr int answer_descriptor = 3;

/// Exit codes of the helper; other TetGen codes are passed on as refused_base + code.
inline constexpr int exit_done = 0, exit_bad_request = 64, exit_out_of_memory = 65,
                     refused_base = 70;

struct Request {
  std::string switches;
  std::vector<double> points;
  std::vector<std::int32_t> triangles, markers;
  std::vector<double> holes;
  std::vector<double> sizes;
};

struct Answer {
  std::vector<double> points;
  std::vector<std::int32_t> tetrahedra, triangles, markers;
};

inline std::string encode(const Request& request) {
  return common::encode_blocks(request.switches, request.points, request.triangles, request.markers,
                               request.holes, request.sizes);
}
inline bool decode(const std::string& bytes, Request& request) {
  return common::decode_blocks(bytes, request.switches, request.points, request.triangles,
                               request.markers, request.holes, request.sizes);
}

inline std::string encode(const Answer& answer) {
  return common::encode_blocks(answer.points, answer.tetrahedra, answer.triangles, answer.markers);
}
inline bool decode(const std::string& bytes, Answer& answer) {
  return common::decode_blocks(bytes, answer.points, answer.tetrahedra, answer.triangles,
                               answer.markers);
}

}  // namespace kinetostat::fea::tetgen
