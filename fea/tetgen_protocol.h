// What kinetostat and its helper program kinetostat-tetgen say to one another. Nothing but the
// standard library, so that the helper shares no code with the rest.
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

#include "kinetostat/fea/byte_blocks.h"

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
  std::string bytes;
  append_block(bytes, request.switches);
  append_block(bytes, request.points);
  append_block(bytes, request.triangles);
  append_block(bytes, request.markers);
  append_block(bytes, request.holes);
  append_block(bytes, request.sizes);
  return bytes;
}

inline bool decode(const std::string& bytes, Request& request) {
  std::size_t at = 0;
  return take_block(bytes, at, request.switches) && take_block(bytes, at, request.points) &&
         take_block(bytes, at, request.triangles) && take_block(bytes, at, request.markers) &&
         take_block(bytes, at, request.holes) && take_block(bytes, at, request.sizes) &&
         at == bytes.size();
}

inline std::string encode(const Answer& answer) {
  std::string bytes;
  append_block(bytes, answer.points);
  append_block(bytes, answer.tetrahedra);
  append_block(bytes, answer.triangles);
  append_block(bytes, answer.markers);
  return bytes;
}

inline bool decode(const std::string& bytes, Answer& answer) {
  std::size_t at = 0;
  return take_block(bytes, at, answer.points) && take_block(bytes, at, answer.tetrahedra) &&
         take_block(bytes, at, answer.triangles) && take_block(bytes, at, answer.markers) &&
         at == bytes.size();
}

}  // namespace kinetostat::fea::tetgen
