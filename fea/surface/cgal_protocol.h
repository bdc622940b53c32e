// Protocol between kinetostat and its helper program kinetostat-cgal. Nothing but the standard
// library, so that the helper shares no code with the rest.
//
// The helper reads one request from standard input and writes one answer to file descriptor
// answer_descriptor, both as byte_blocks.h has it:
//   request: operation ("fill", "unite", "wrap" or "remesh"), numbers (wrap: alpha and offset [m];
//            remesh: length of edges [m] and the angle [deg] at which edges stay), points (3
//            doubles each), triangles (3 int32 each), markers (int32 per triangle; remesh only,
//            else none)
//   answer:  points, triangles, counts (int64; fill: holes closed, holes left open, pieces
//            without volume that were left out; unite: the last of these), markers (of remesh)
// Words for the user go to standard output. The memory limit is an argument: --memory BYTES.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kinetostat/common/byte_blocks.h"

namespace kinetostat::fea::cgal {

inline constexpr int answer_descriptor = 3;

/// Exit codes of the helper.
inline constexpr int exit_done = 0, exit_bad_request = 64, exit_out_of_memory = 65,
                     exit_impossible = 66;  // the surface is not fit for it, the words say why

struct Request {
  std::string operation;
  std::vector<double> numbers, points;
  std::vector<std::int32_t> triangles, markers;
};

struct Answer {
  std::vector<double> points;
  std::vector<std::int32_t> triangles;
  std::vector<std::int64_t> counts;
  std::vector<std::int32_t> markers;
};

inline std::string encode(const Request& request) {
  return common::encode_blocks(request.operation, request.numbers, request.points,
                               request.triangles, request.markers);
}
inline bool decode(const std::string& bytes, Request& request) {
  return common::decode_blocks(bytes, request.operation, request.numbers, request.points,
                               request.triangles, request.markers);
}

inline std::string encode(const Answer& answer) {
  return common::encode_blocks(answer.points, answer.triangles, answer.counts, answer.markers);
}
inline bool decode(const std::string& bytes, Answer& answer) {
  return common::decode_blocks(bytes, answer.points, answer.triangles, answer.counts,
                               answer.markers);
}

}  // namespace kinetostat::fea::cgal
