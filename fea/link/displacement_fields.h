// How an identified link deforms and where it is strained, for ParaView.
#pragma once

#include "kinetostat/fea/link/identify.h"
#include "kinetostat/fea/link/modal_study.h"

namespace kinetostat::fea {

/// The mesh with, per unit wrench, the displacements as point data "Fx" .. "Mz" (with several
/// loaded interfaces "<interface> Fx" ..), the recovered stresses "stress Fx" .. (xx yy zz xy yz
/// zx) and von Mises' equivalent of them; the interfaces (1 fixed, 2 and up loaded); and as cell
/// data the share of each element in the error.
io::VtuGrid displacement_fields(const LinkResult& result);

/// The mesh with the shape of every mode as point data "mode 1" .., scaled so that its largest
/// displacement is a tenth of the diagonal of the link's bounding box, and the interfaces and the
/// share in the error as above.
io::VtuGrid mode_shapes(const ModalResult& result);

}  // namespace kinetostat::fea
