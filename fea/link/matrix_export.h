// The reduced matrices of a link for other programs.
#pragma once

#include <string>

#include "kinetostat/fea/link/identify.h"
#include "kinetostat/fea/link/modal_study.h"

namespace kinetostat::fea {

/// The flexibility between the loaded interfaces, made symmetric, SI units. One column a load
/// ("tip.Fx"), one row a motion, named in the first cell ("tip.tx").
std::string flexibility_csv(const LinkResult& result);

/// The same as a MATLAB (or GNU Octave) script that defines `flexibility`, `stiffness`, `motions`,
/// `loads` and `points`.
std::string flexibility_matlab(const LinkResult& result);

/// `model` of the link as such a script, SI units: `name`, `freedoms` ("fixed.tx" .. "mode 1" ..),
/// `origins` of the interfaces, `K`, `M`.
std::string reduced_matlab(const ModalResult& result, const ReducedModel& model);

// The same in other formats.

/// A MAT-file (level 4: MATLAB and GNU Octave load it, scipy reads it) with K, M and `origins` of
/// the interfaces, a row each, as Simscape's Reduced Order Flexible Solid takes them.
std::string reduced_mat(const ModalResult& result, const ReducedModel& model);

/// A Python script with these as NumPy arrays, and a function that adds the link to a system of
/// EXUDYN as a generic body (ObjectGenericODE2): small motions about where it stands.
std::string reduced_exudyn(const ModalResult& result, const ReducedModel& model);

/// A part of a deck for CalculiX and Abaqus, to be included: a node for the translation and one for
/// the rotation (as displacements) of each interface, one for three modes. Neither program but
/// Abaqus reads matrices of elements, so that they are given as springs and masses of the modes of
/// the free link, whose displacements equations tie to those of the nodes: exact in linear steps.
/// M must be positive definite.
std::string reduced_deck(const ModalResult& result, const ReducedModel& model);

/// The data of a modal joint of MBDyn, whose modal node stands in the origin of the mesh: a node
/// for each interface, all elastic modes of the free link, of unit modal mass, and the inertia of
/// the link as a rigid body (record group 12). Modes of a free link have no momentum: nothing is
/// lost of small motions. M must be positive definite.
std::string reduced_mbdyn(const ModalResult& result, const ReducedModel& model);

/// A C++ header with K, M and the interfaces, and a function that adds the link to a system of
/// Project Chrono as a ChModalAssembly, whose floating frame turns with it: a ChNodeFEAxyzrot for
/// each interface, the modes six by six as nodes inside, which Chrono's own reduction by Craig and
/// Bampton keeps. At least one mode.
std::string reduced_chrono(const ModalResult& result, const ReducedModel& model);

}  // namespace kinetostat::fea
