// Whole results of identify, kept from one run to the next.
#pragma once

#include <optional>
#include <string>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/fea/link/link_file.h"
#include "kinetostat/io/cache.h"

namespace kinetostat::apps {

class ResultCache {
 public:
  /// The key is what decides the result: the meaning of the link file, the bytes of the files that
  /// it names, the options but those that only name outputs, the number of threads, the program,
  /// the helper that reads the mesh where that is a STEP file.
  ResultCache(const io::Cache& cache, const Run& run, const fea::LinkSpec& spec);

  struct Entry {
    std::string screen, report;  // what is printed first, and all of it
    io::Json result;
  };
  std::optional<Entry> find() const;
  void keep(const Entry& entry) const;

 private:
  const io::Cache& cache_;
  std::string key_;
  std::string link_sha256_;
};

}  // namespace kinetostat::apps
