// hard_meshes FOLDER: writes the corpus (hard_surfaces.h) as link files, each with its mesh, and
// as NAME.clean.yaml the same part from a clean mesh. Prints a line for each: name, family,
// "broken" or "sound".
#include <cstdio>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "fea/surface/hard_surfaces.h"

namespace {

using namespace kinetostat::fea;

std::string box_text(const Box& box) {
  return fmt::format("{{box: {{min: [{}, {}, {}], max: [{}, {}, {}]}}}}", box.min().x(),
                     box.min().y(), box.min().z(), box.max().x(), box.max().y(), box.max().z());
}

void write(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

void write_case(const std::filesystem::path& folder, const std::string& name,
                const hard::HardSurface& part) {
  const auto link = [&](const std::string& mesh, const std::string& more) {
    return fmt::format(
        "kinetostat: 1\nlink: {}\nmesh: {{file: {}, unit: mm{}}}\nmaterial: {{E: 70 GPa, nu: "
        "0.33}}\nfixed: {}\nloaded: {}\nelements: {{accuracy: 10 %}}\n",
        name, mesh, more, box_text(part.fixed), box_text(part.loaded));
  };
  write(folder / (name + ".stl"), stl_bytes(part.mesh, 1));
  write(folder / (name + ".yaml"), link(name + ".stl", ""));
  write(folder / (name + ".clean.stl"), stl_bytes(part.clean, 1));
  write(folder / (name + ".clean.yaml"), link(name + ".clean.stl", ""));
  if (part.is_broken) {
    write(folder / (name + ".repaired.yaml"), link(name + ".repaired.stl", ""));
    write(folder / (name + ".repair.yaml"),
          link(name + ".stl", ", repair: [weld, orient, fill, unite, drop, wrap]"));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: hard_meshes FOLDER\n");
    return 2;
  }
  std::filesystem::create_directories(argv[1]);
  for (const std::string& family : hard::families())
    for (int variant = 0; variant < hard::variants; ++variant) {
      const std::string name = fmt::format("{}_{}", family, variant);
      const hard::HardSurface part = hard::hard_surface(family, variant);
      write_case(argv[1], name, part);
      std::printf("%s %s %s %zu\n", name.c_str(), family.c_str(),
                  part.is_broken ? "broken" : "sound", part.mesh.triangles.size());
    }
}
