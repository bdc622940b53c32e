// Protocol between kinetostat and its helper program kinetostat-step, which reads STEP files with
// Open CASCADE. Nothing but the standard library, so that the helper shares no code with the rest.
//
// The helper reads one request from standard input and writes one answer to file descriptor
// answer_descriptor, both as byte_blocks.h has it. Lengths are in mm, whatever the file is in;
// faces are numbered from 1 in the order of the file's solids, or of its faces when it has none.
//   request: operation; step, the bytes of the file;
//            "facets": numbers are the angle [rad] that neighbouring facets may turn by and their
//            largest distance from a face, in parts of the diagonal of the bounding box;
//            "project": points (3 doubles each), each with the faces that it shall lie on, the
//            items faces[face_start[i]] to faces[face_start[i + 1] - 1]
//   answer:  points (of "project": the nearest ones on the face, on an edge common to two faces, on
//            a corner common to more; unchanged where there is none), triangles (3 int32 each, seen
//            counterclockwise from outside), their faces;
//            of every face: its kind (FaceKind), figures_per_face figures (area, centre, a point of
//            the axis or plane, direction of the axis or outward normal, radius), its solid (from
//            1; 0: none), names and colours ("#rrggbb" or nothing); of every solid: its name. Texts
//            end with a zero byte each
// Words for the user go to standard output. The memory limit is an argument: --memory BYTES.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kinetostat/common/byte_blocks.h"

namespace kinetostat::fea::step {

inline constexpr int answer_descriptor = 3;

/// Exit codes of the helper.
inline constexpr int exit_done = 0, exit_bad_request = 64, exit_out_of_memory = 65,
                     exit_impossible = 66;  // the file cannot be read, the words say why

inline constexpr int figures_per_face = 11;

struct Request {
  std::string operation, step;
  std::vector<double> numbers, points;
  std::vector<std::int32_t> face_start, faces;
};

struct Answer {
  std::vector<double> points;
  std::vector<std::int32_t> triangles, face_of_triangle;
  std::vector<std::int32_t> kinds, solid_of_face;
  std::vector<double> figures;
  std::string face_names, face_colours, solid_names;
};

inline std::string encode(const Request& request) {
  return common::encode_blocks(request.operation, request.step, request.numbers, request.points,
                               request.face_start, request.faces);
}
inline bool decode(const std::string& bytes, Request& request) {
  return common::decode_blocks(bytes, request.operation, request.step, request.numbers,
                               request.points, request.face_start, request.faces);
}

inline std::string encode(const Answer& a) {
  return common::encode_blocks(a.points, a.triangles, a.face_of_triangle, a.kinds, a.solid_of_face,
                               a.figures, a.face_names, a.face_colours, a.solid_names);
}
inline bool decode(const std::string& bytes, Answer& a) {
  return common::decode_blocks(bytes, a.points, a.triangles, a.face_of_triangle, a.kinds,
                               a.solid_of_face, a.figures, a.face_names, a.face_colours,
                               a.solid_names);
}

}  // namespace kinetostat::fea::step
