// What is not known of the compliance of an identified link: the error of its mesh, how it is
// clamped, and the modulus of its material.
#pragma once

#include "kinetostat/io/link_result_file.h"
#include "kinetostat/vjm/io/uncertainty_source.h"

namespace kinetostat::vjm {

/// The compliance of the link in its own frame for values of its sources, which go into
/// `sources`: that of the file while they are listed.
///
///     C(m, t) = C(t) + m D,   m in [-1, 1],   t in [0, 1]
///
/// m is the error of the mesh, rectangular: with B the error bars and E the error estimated from
/// recovered stresses, D_ij = sqrt(B_ii B_jj) E_ij / sqrt(E_ii E_jj), positive semidefinite as that
/// error is and as large as the bars on the diagonal; all entries are in error together. t is the
/// clamping, rectangular too: C(t) = (1 - t) C_rigid + t C_distributing, or C where there is no
/// bracket. Bounds are all that is known, so that the estimate is the middle of the bracket. Where
/// the file states how well the modulus of the material is known, a third source divides all of C
/// by it, log-normal about 1.
spatial::Compliance6 uncertain_compliance(const io::IdentifiedLink& link,
                                          const std::filesystem::path& file, SourceList& sources);

/// The same of a link between any number of interfaces, of its flexibility: then the stiffness
/// between all of them.
Eigen::MatrixXd uncertain_stiffness(const io::ReducedLink& link, const std::filesystem::path& file,
                                    SourceList& sources);

}  // namespace kinetostat::vjm
