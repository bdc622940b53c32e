#include "kinetostat/common/build_id.h"

#include <cstdint>
#include <cstring>
#include <elf.h>
#include <link.h>
#include <string_view>

#include <fmt/format.h>

namespace kinetostat::common {
namespace {

const char here = 0;

// Of one object in memory: does it hold `here`?
bool holds_this(const dl_phdr_info& object) {
  const auto address = reinterpret_cast<std::uintptr_t>(&here);
  for (int k = 0; k < object.dlpi_phnum; ++k) {
    const ElfW(Phdr)& part = object.dlpi_phdr[k];
    const std::uintptr_t begin = object.dlpi_addr + part.p_vaddr;
    if (part.p_type == PT_LOAD && address >= begin && address < begin + part.p_memsz) return true;
  }
  return false;
}

std::string in_digits(std::string_view bytes) {
  std::string digits;
  for (const char byte : bytes)
    fmt::format_to(std::back_inserter(digits), "{:02x}", static_cast<unsigned char>(byte));
  return digits;
}

constexpr std::size_t padded(std::size_t size) { return (size + 3) / 4 * 4; }

constexpr std::string_view owner{"GNU\0", 4};

// Notes follow one another: a head, a name and contents, both padded to four bytes.
std::string build_id_among(std::string_view notes) {
  ElfW(Nhdr) head = {};
  while (notes.size() >= sizeof head) {
    std::memcpy(&head, notes.data(), sizeof head);
    const std::size_t content = sizeof head + padded(head.n_namesz);
    const std::size_t size = content + padded(head.n_descsz);
    if (size > notes.size()) break;
    if (head.n_type == NT_GNU_BUILD_ID && notes.substr(sizeof head, head.n_namesz) == owner)
      return in_digits(notes.substr(content, head.n_descsz));
    notes.remove_prefix(size);
  }
  return "";
}

int find_build_id(dl_phdr_info* object, std::size_t, void* found) {
  if (!holds_this(*object)) return 0;
  auto& id = *static_cast<std::string*>(found);
  for (int k = 0; k < object->dlpi_phnum && id.empty(); ++k) {
    const ElfW(Phdr)& part = object->dlpi_phdr[k];
    if (part.p_type != PT_NOTE) continue;
    // NOLINTNEXTLINE(performance-no-int-to-ptr): the loader states addresses as numbers
    const auto* begin = reinterpret_cast<const char*>(object->dlpi_addr + part.p_vaddr);
    id = build_id_among({begin, part.p_memsz});
  }
  return 1;
}

}  // namespace

std::string build_id() {
  std::string id;
  ::dl_iterate_phdr(find_build_id, &id);
  return id;
}

}  // namespace kinetostat::common
