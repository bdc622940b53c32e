// The surface of a link and how it deforms, or where it is broken: what pictures of them need.
#pragma once

#include "kinetostat/fea/link/identify.h"
#include "kinetostat/fea/surface/surface_check.h"
#include "kinetostat/io/json.h"
#include "kinetostat/report/links/mesh_check.h"

namespace kinetostat::report {

/// Boundary triangles (corners only) with the interface that each belongs to (0: none, 1: fixed, 2
/// and up: loaded), and the displacements of their corners under each unit wrench, as whole numbers
/// of `point_unit` [m] and of the load case's `unit` [m/N or m/(N m)]. `faces` are the selectors of
/// its flat and round faces for a link file, `of_face` says which each triangle has (-1: none). A
/// surface of more than `most_points` corners is made coarser by joining near ones.
io::Json link_picture(const fea::LinkResult& result, std::size_t most_points = 15000);

/// The triangles of a surface that is checked, likewise, with their faces (selectors in `units`);
/// `of_defect` says which of the `defects` each triangle has (-1: none). Empty for an empty
/// surface.
io::Json surface_picture(const fea::SurfaceMesh& surface, const fea::SurfaceReport& report,
                         const MeshCheckUnits& units, std::size_t most_points = 15000);

}  // namespace kinetostat::report
