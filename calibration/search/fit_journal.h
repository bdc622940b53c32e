// Where fits and signatures are kept, so that a search that was interrupted goes on where it was.
#pragma once

#include <optional>
#include <string>

namespace kinetostat::calibration {

/// Given to a search by whoever has a place to keep things; a search without one computes all anew.
/// The whole outcome is kept, bit for bit: it holds the equilibria from which later fits start, so
/// a search that goes on gives the bytes of one that was never interrupted, and no figure depends
/// on whether there is a journal.
class FitJournal {
 public:
  FitJournal() = default;
  FitJournal(const FitJournal&) = delete;
  FitJournal& operator=(const FitJournal&) = delete;
  virtual ~FitJournal() = default;

  /// The content that was kept under a key, or nothing. A key is a SHA-256 of all that is asked of
  /// one robot and one campaign, as they were read, by one build of the program: a journal must
  /// find nothing that was kept for another. Never found: content that is not as it was kept.
  virtual std::optional<std::string> find(const std::string& key) = 0;
  /// May fail silently: what is not kept is computed again.
  virtual void keep(const std::string& key, const std::string& content) = 0;
};

}  // namespace kinetostat::calibration
