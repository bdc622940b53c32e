// An identified link, for people and for programs; the link result file.
#pragma once

#include <string>

#include "kinetostat/fea/link/identify.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// Mesh and material of the link file, in one line.
std::string text(const fea::LinkSpec& link);
/// Mesh, solver, interfaces, mass, compliance with its error bars, bracket, preload and warnings,
/// lengths in the unit of the mesh.
std::string text(const fea::LinkResult& result);

/// The link result file (docs/reference/link-file.md), in SI units. Its bytes depend on the input
/// alone, `timings` apart. io::read_identified_link() reads it.
io::Json to_json(const fea::LinkResult& result);
/// A result that was computed from another link file of the same meaning.
io::Json with_link_file(io::Json result, const std::string& link_sha256);

}  // namespace kinetostat::report
