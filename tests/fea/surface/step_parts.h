// STEP files for tests, written by Open CASCADE itself.
#pragma once

#include <filesystem>

namespace kinetostat::test {

/// A round bar about the x axis, from the origin to x = `length` [mm]; two plane faces, "foot" and
/// "head", and a round one.
void write_round_bar(const std::filesystem::path& file, double diameter, double length);

/// The same as two solids that touch in the middle, "near half" and "far half".
void write_round_bar_in_two(const std::filesystem::path& file, double diameter, double length);

/// Two solids about the x axis, from the origin to x = `length`: "core", a round bar of the inner
/// diameter, and "sleeve" around it; all [mm].
void write_core_and_sleeve(const std::filesystem::path& file, double inner, double outer,
                           double length);

/// A block of 60 x 60 x 20 mm about the origin with a bore of this diameter [mm] along z.
void write_bored_block(const std::filesystem::path& file, double diameter);

/// A plate, `length` x 60 x 10 mm, with 34 bores of 6 mm in two rows at y = 20 and 40 mm and every
/// eighteenth of the length: 40 faces. Their names: "left" (x = 0), "right", "bore 1.1" to "bore
/// 17.2" (row last); other faces have none. "bore 9.2" is red, all else grey.
void write_perforated_plate(const std::filesystem::path& file, double length);

}  // namespace kinetostat::test
